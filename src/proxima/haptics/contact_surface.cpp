#include "proxima/haptics/contact_surface.h"

#include "proxima/geometry/closest_point.h"
#include "proxima/proximity/closest_feature.h"
#include "proxima/proximity/triangle_lanes.h"
#include "proxima/proximity/triangle_tree.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// Distances as computed are off by less than this part of the coordinates.
constexpr double distance_rounding = 0x1p-46;

double less_rounding(double distance, const SurfaceScale& scale, const Vec3& p) noexcept
{
    return distance - distance_rounding * (scale.reach + p.cwiseAbs().maxCoeff());
}

/// Adds triangles up, to their scale.
class ScaleSum {
public:
    void add(const Triangle& triangle)
    {
        for (const Vec3& corner : triangle.vertices) box_.extend(corner);
        doubled_area_ += scaled_normal(triangle).norm();
        ++count_;
    }
    [[nodiscard]] SurfaceScale scale() const
    {
        if (count_ == 0) return {};
        const double extent = box_.extent().maxCoeff();
        const double reach =
            std::max(box_.lower.cwiseAbs().maxCoeff(), box_.upper.cwiseAbs().maxCoeff());
        const double area = doubled_area_ / 2 / static_cast<double>(count_);
        return {extent, std::max(reach, std::numeric_limits<double>::min()),
                std::sqrt(area * 4 / std::sqrt(3.0))};
    }

private:
    Box box_;
    double doubled_area_ = 0;
    std::size_t count_ = 0;
};

template <class Scalar>
Triangle triangle_of(const TriangleRow<Scalar>& row) noexcept
{
    return {{row.corner(0), row.corner(1), row.corner(2)}};
}

/// Of one kind of rows, by the tree over them.
template <class Scalar>
std::size_t collect_rows(const TriangleTree& tree, std::span<const TriangleRow<Scalar>> rows,
                         const Vec3& p, double distance, std::span<ContactTriangle> buffer) noexcept
{
    const double unit = tree.scale() * tree.scale();
    const double limit = triangle_distance_limit(distance * distance * unit, tree.reach());
    std::size_t count = 0;
    visit_within(tree, {p, p}, distance * distance, [&](RankRange ranks) noexcept {
        const auto group = rows.subspan(ranks.first, ranks.count);
        std::array<double, TriangleTree::width> squared;
        triangle_distances(group, p, tree.scale(), squared);
        for (std::size_t i = 0; i < group.size(); ++i) {
            if (squared[i] > limit) continue;
            if (count < buffer.size()) {
                buffer[count] = {triangle_of(group[i]), TriangleId{group[i].triangle_id()}};
            }
            ++count;
        }
    });
    return count;
}

/// All of each group that may be near.
template <class Scalar>
std::size_t gather_rows(const TriangleTree& tree, std::span<const TriangleRow<Scalar>> rows,
                        const Vec3& p, double distance, std::span<ContactTriangle> buffer) noexcept
{
    std::size_t count = 0;
    visit_within(tree, {p, p}, distance * distance, [&](RankRange ranks) noexcept {
        for (const TriangleRow<Scalar>& row : rows.subspan(ranks.first, ranks.count)) {
            if (count < buffer.size())
                buffer[count] = {triangle_of(row), TriangleId{row.triangle_id()}};
            ++count;
        }
    });
    return count;
}

} // namespace

std::uint64_t new_edition() noexcept
{
    static std::atomic<std::uint64_t> last{0};
    return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

SurfaceScale scale_of(const TriangleMesh& mesh)
{
    ScaleSum sum;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id)
        sum.add(mesh.triangle(TriangleId{id}));
    return sum.scale();
}

OctreeContactSurface::OctreeContactSurface(const ProximityOctree& octree) : octree_(&octree)
{
    // In the order of ids, so that the sums are those of the mesh.
    const ProximityArrays& arrays = octree.arrays();
    std::vector<Triangle> triangles(octree.triangle_count());
    for (const auto& row : arrays.float_rows) triangles[row.triangle_id()] = triangle_of(row);
    for (const auto& row : arrays.double_rows) triangles[row.triangle_id()] = triangle_of(row);
    ScaleSum sum;
    for (const Triangle& triangle : triangles) sum.add(triangle);
    scale_ = sum.scale();
}

std::size_t OctreeContactSurface::collect(const Vec3& p, double distance,
                                          std::span<ContactTriangle> buffer) const noexcept
{
    const ProximityArrays& arrays = octree_->arrays();
    const TriangleTree& tree = octree_->tree();
    return arrays.double_rows.empty() ? collect_rows(tree, arrays.float_rows, p, distance, buffer)
                                      : collect_rows(tree, arrays.double_rows, p, distance, buffer);
}

std::size_t OctreeContactSurface::gather(const Vec3& p, double distance,
                                         std::span<ContactTriangle> buffer) const noexcept
{
    const ProximityArrays& arrays = octree_->arrays();
    const TriangleTree& tree = octree_->tree();
    return arrays.double_rows.empty() ? gather_rows(tree, arrays.float_rows, p, distance, buffer)
                                      : gather_rows(tree, arrays.double_rows, p, distance, buffer);
}

double OctreeContactSurface::clearance(const Vec3& p) const noexcept
{
    return less_rounding(std::sqrt(closest_feature(*octree_, p).squared_distance), scale_, p);
}

std::size_t MeshContactSurface::collect(const Vec3& p, double distance,
                                        std::span<ContactTriangle> buffer) const noexcept
{
    std::size_t count = 0;
    for (std::uint32_t id = 0; id < mesh_->triangle_count(); ++id) {
        const Triangle triangle = mesh_->triangle(TriangleId{id});
        const Box box = bounding_box(triangle);
        const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
        if (gap.squaredNorm() > distance * distance) continue;
        if (count < buffer.size()) buffer[count] = {triangle, TriangleId{id}};
        ++count;
    }
    return count;
}

double MeshContactSurface::clearance(const Vec3& p) const noexcept
{
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t id = 0; id < mesh_->triangle_count(); ++id) {
        const TrianglePoint closest = closest_point(mesh_->triangle(TriangleId{id}), p);
        least = std::min(least, (closest.point - p).squaredNorm());
    }
    return less_rounding(std::sqrt(least), scale_, p);
}

} // namespace proxima
