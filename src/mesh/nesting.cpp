#include "mesh/nesting.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>

namespace proxima {

namespace {

constexpr std::size_t triangles_per_nesting_task = 4096;

/// A k-d tree of points: the middle one of a range splits it along x, y and z in turn.
class SampleTree {
public:
    explicit SampleTree(std::span<const SurfaceSample> samples)
        : samples_(samples), order_(samples.size())
    {
        std::iota(order_.begin(), order_.end(), 0U);
        split(0, order_.size(), 0);
    }

    /// Calls visit(sample) for all in the closed box.
    template <class Visit>
    void visit_in(const Box& box, const Visit& visit) const
    {
        visit_range(box, visit, 0, order_.size(), 0);
    }

private:
    void split(std::size_t first, std::size_t end, int axis)
    {
        if (end - first < 2) return;
        const auto at = [&](std::size_t i) {
            return order_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        const std::size_t middle = first + (end - first) / 2;
        std::nth_element(at(first), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
            return samples_[a].position[axis] < samples_[b].position[axis];
        });
        split(first, middle, (axis + 1) % 3);
        split(middle + 1, end, (axis + 1) % 3);
    }

    template <class Visit>
    void visit_range(const Box& box, const Visit& visit, std::size_t first, std::size_t end,
                     int axis) const
    {
        if (first == end) return;
        const std::size_t middle = first + (end - first) / 2;
        const Vec3& position = samples_[order_[middle]].position;
        const int next = (axis + 1) % 3;
        if (box.lower[axis] <= position[axis]) visit_range(box, visit, first, middle, next);
        if ((position.array() >= box.lower.array()).all() &&
            (position.array() <= box.upper.array()).all())
            visit(order_[middle]);
        if (box.upper[axis] >= position[axis]) visit_range(box, visit, middle + 1, end, next);
    }

    std::span<const SurfaceSample> samples_;
    std::vector<std::uint32_t> order_;
};

/// Orientation of the triangle's shadow along an axis: the sign of its normal's component.
int shadow_sign(const Triangle& triangle, int axis) noexcept
{
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const auto shadow = [&](const Vec3& p) { return Vec2(p[u], p[v]); };
    return orient2d(shadow(triangle[0]), shadow(triangle[1]), shadow(triangle[2]));
}

/// Whether the shadow along z covers the point moved by a hair along x and a far smaller one along
/// y: then it is on no line through two corners, and of triangles that share an edge one covers it.
bool shadow_covers(const Triangle& triangle, const Vec3& point) noexcept
{
    bool covers = false;
    for (int k = 0; k < 3; ++k) {
        const Vec3& a = triangle[k];
        const Vec3& b = triangle[(k + 1) % 3];
        const bool rises = a.y() <= point.y();
        if (rises != (b.y() > point.y())) continue;
        int side = orient2d(a.head<2>(), b.head<2>(), point.head<2>());
        if (side == 0) side = rises ? -1 : 1; // moved along x, to the right of what rises
        if ((side > 0) == rises) covers = !covers;
    }
    return covers;
}

/// Whether the triangle is above the point moved by hairs along x, y and z, each far smaller than
/// the one before.
bool is_above(const Triangle& triangle, const Vec3& point) noexcept
{
    if (!shadow_covers(triangle, point)) return false;
    const int up = shadow_sign(triangle, 2);
    int side = orient3d(triangle[0], triangle[1], triangle[2], point);
    for (int axis = 0; axis < 3 && side == 0; ++axis) side = shadow_sign(triangle, axis);
    return side != up;
}

std::vector<Box> boxes_of(const TriangleMesh& mesh, std::span<const std::uint32_t> surface_of,
                          std::uint32_t count)
{
    std::vector<Box> boxes(count);
    for (std::uint32_t id = 0; id < surface_of.size(); ++id) {
        if (surface_of[id] == no_surface) continue;
        for (const Vec3& corner : mesh.triangle(TriangleId{id}).vertices)
            boxes[surface_of[id]].extend(corner);
    }
    return boxes;
}

/// 1 for surfaces whose box is in that of another one.
std::vector<std::uint8_t> with_box_inside(std::span<const Box> boxes, const Progress* progress)
{
    std::vector<SurfaceSample> lower_corners;
    for (std::uint32_t surface = 0; surface < boxes.size(); ++surface) {
        if (!boxes[surface].empty()) lower_corners.push_back({boxes[surface].lower, surface});
    }
    const SampleTree tree(lower_corners);
    std::vector<std::uint8_t> inside(boxes.size(), 0);
    for (const SurfaceSample& around : lower_corners) {
        if (is_cancelled(progress)) break;
        tree.visit_in(boxes[around.surface], [&](std::uint32_t sample) {
            const std::uint32_t other = lower_corners[sample].surface;
            if (inside[other] != 0) return;
            const bool holds =
                (boxes[other].upper.array() <= boxes[around.surface].upper.array()).all();
            if (other != around.surface && holds) inside[other] = 1;
        });
    }
    return inside;
}

/// The corners of the surfaces asked for that belong to no other one.
std::vector<SurfaceSample> own_corners(const TriangleMesh& mesh,
                                       std::span<const std::uint32_t> surface_of,
                                       std::span<const std::uint8_t> asked_for)
{
    constexpr std::uint32_t several = no_surface - 1;
    std::vector<std::uint32_t> owner(mesh.vertex_count(), no_surface);
    for (std::size_t id = 0; id < surface_of.size(); ++id) {
        if (surface_of[id] == no_surface) continue;
        for (const std::uint32_t corner : mesh.triangles()[id]) {
            std::uint32_t& one = owner[corner];
            one = one == no_surface || one == surface_of[id] ? surface_of[id] : several;
        }
    }
    std::vector<SurfaceSample> corners;
    for (std::uint32_t vertex = 0; vertex < owner.size(); ++vertex) {
        if (owner[vertex] >= several || asked_for[owner[vertex]] == 0) continue;
        corners.push_back({mesh.position(VertexId{vertex}), owner[vertex]});
    }
    return corners;
}

} // namespace

std::vector<std::uint8_t> odd_nesting(const TriangleMesh& mesh,
                                      std::span<const std::uint32_t> surface_of,
                                      std::span<const SurfaceSample> samples, Threads threads,
                                      const Progress* progress)
{
    // Whether a point is in an odd number of surfaces is whether an odd number of triangles of all
    // of them together is above it.
    if (samples.empty()) return {};
    const SampleTree tree(samples);
    std::vector<std::atomic<std::uint8_t>> odd(samples.size());
    const auto count_above = [&](std::size_t id) {
        if (surface_of[id] == no_surface) return;
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(id)});
        Box below = bounding_box(triangle);
        below.lower.z() = -std::numeric_limits<double>::infinity();
        tree.visit_in(below, [&](std::uint32_t sample) {
            const SurfaceSample& one = samples[sample];
            if (one.surface != surface_of[id] && is_above(triangle, one.position))
                odd[sample].fetch_xor(1, std::memory_order_relaxed);
        });
    };
    parallel_chunks(mesh.triangle_count(), triangles_per_nesting_task, threads,
                    [&](std::size_t first, std::size_t end) {
                        for (std::size_t id = first; id < end && !is_cancelled(progress); ++id)
                            count_above(id);
                    });
    std::vector<std::uint8_t> result;
    result.reserve(odd.size());
    for (const auto& one : odd) result.push_back(one.load(std::memory_order_relaxed));
    return result;
}

std::vector<std::uint8_t> nested_surfaces(const TriangleMesh& mesh,
                                          std::span<const std::uint32_t> surface_of,
                                          std::uint32_t count, Threads threads,
                                          const Progress* progress)
{
    std::vector<std::uint8_t> nested = with_box_inside(boxes_of(mesh, surface_of, count), progress);
    const std::vector<SurfaceSample> corners = own_corners(mesh, surface_of, nested);
    const std::vector<std::uint8_t> odd = odd_nesting(mesh, surface_of, corners, threads, progress);
    std::vector<std::uint8_t> has_corner(count, 0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        has_corner[corners[i].surface] = 1;
        nested[corners[i].surface] &= odd[i];
    }
    for (std::uint32_t surface = 0; surface < count; ++surface)
        nested[surface] &= has_corner[surface];
    return nested;
}

} // namespace proxima
