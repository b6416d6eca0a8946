#include "haptics/surface/contact_surface.h"

#include "base/check.h"
#include "geometry/closest_point.h"
#include "haptics/proxy/slide_sphere.h"
#include "haptics/surface/exits.h"
#include "haptics/surface/find_groups.h"
#include "haptics/surface/triangle_tree.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "index/triangle_lanes.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima {

namespace {

/// Computes the scale of triangles one by one.
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
                std::max(std::sqrt(area * 4 / std::sqrt(3.0)), least_edge * extent)};
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

template <class Scalar>
ContactTriangle contact_triangle(const TriangleRow<Scalar>& row) noexcept
{
    return {triangle_of(row), TriangleId{row.triangle_id()}};
}

/// Collects triangles of one kind of rows, by the tree over them.
template <class Scalar>
std::size_t collect_rows(const TriangleTree& tree, std::span<const TriangleRow<Scalar>> rows,
                         const Vec3& p, double distance, std::span<ContactTriangle> buffer) noexcept
{
    const double unit = tree.scale() * tree.scale();
    const double limit = triangle_distance_limit(distance * distance * unit, tree.reach());
    std::size_t count = 0;
    visit_within(tree, {p, p}, distance * distance, [&](RowRange ranks) noexcept {
        const auto group = rows.subspan(ranks.first, ranks.count);
        std::array<double, TriangleTree::width> squared;
        triangle_distances(group, p, tree.scale(), squared);
        for (std::size_t i = 0; i < group.size(); ++i) {
            if (squared[i] > limit) continue;
            if (count < buffer.size()) buffer[count] = contact_triangle(group[i]);
            ++count;
        }
        return count > buffer.size() ? Flow::stop : Flow::proceed;
    });
    return count;
}

/// Appends groups of eight rows.
template <class Scalar>
void make_groups(std::span<const TriangleRow<Scalar>> rows, double scale,
                 std::vector<TriangleGroup>& groups)
{
    std::array<Triangle, TriangleGroup::width> triangles;
    for (std::size_t first = 0; first < rows.size(); first += TriangleGroup::width) {
        const std::size_t count = std::min(TriangleGroup::width, rows.size() - first);
        for (std::size_t i = 0; i < count; ++i) triangles[i] = triangle_of(rows[first + i]);
        groups.push_back(make_group(std::span(triangles).first(count), scale));
    }
}

/// Whether the index lists the triangles that can be nearest to a point.
bool has_list(const IndexParts& index, const Vec3& p) noexcept
{
    if (index.lists() == nullptr) return false;
    const ProximityLists& lists = *index.lists();
    std::array<std::uint32_t, 3> at{};
    if (!lists.locate(lists.frame().to_frame(p), at)) return false;
    const int depth = lists.table_depth();
    int shift = static_cast<int>(ProximityLists::location_bits) - depth;
    std::uint64_t word =
        lists.arrays().table[(std::size_t{at[2] >> shift} << depth | at[1] >> shift) << depth |
                             at[0] >> shift];
    while (!proximity_word::is_leaf(word)) {
        --shift;
        word = lists.arrays().nodes[word + ((at[0] >> shift & 1U) | (at[1] >> shift & 1U) << 1U |
                                            (at[2] >> shift & 1U) << 2U)];
    }
    return word != proximity_word::search;
}

} // namespace

double less_rounding(double distance, const SurfaceScale& scale, const Vec3& p) noexcept
{
    constexpr double distance_rounding = 0x1p-46; // in parts of the coordinates
    return distance - distance_rounding * (scale.reach + p.cwiseAbs().maxCoeff());
}

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

Result<IndexContactSurface::Parts> IndexContactSurface::build_parts(const MeshIndex& index)
{
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    auto tree = build_triangle_tree(*mesh, index.ids());
    if (!tree) return tl::unexpected(tree.error());
    return Parts{std::move(*tree), scale_of(*mesh)};
}

Result<std::unique_ptr<const IndexContactSurface>> IndexContactSurface::make(const MeshIndex& index)
{
    auto parts = build_parts(index);
    if (!parts) return tl::unexpected(parts.error());
    return std::unique_ptr<const IndexContactSurface>(
        new IndexContactSurface(index, std::move(*parts)));
}

IndexContactSurface::IndexContactSurface(const MeshIndex& index)
    : IndexContactSurface(index, [&] {
          auto parts = build_parts(index);
          PROXIMA_CHECK(parts.has_value());
          return std::move(*parts);
      }())
{}

IndexContactSurface::IndexContactSurface(const MeshIndex& index, Parts parts)
    : index_(index), tree_(std::move(parts.tree)), scale_(parts.scale)
{
    groups_.reserve((index_.triangle_count() + TriangleGroup::width - 1) / TriangleGroup::width);
    make_groups(index_.parts().float_rows(), tree_.scale(), groups_);
    make_groups(index_.parts().double_rows(), tree_.scale(), groups_);
}

std::size_t IndexContactSurface::collect(const Vec3& p, double distance,
                                         std::span<ContactTriangle> buffer) const noexcept
{
    const IndexParts& parts = index_.parts();
    return parts.double_rows().empty()
               ? collect_rows(tree_, parts.float_rows(), p, distance, buffer)
               : collect_rows(tree_, parts.double_rows(), p, distance, buffer);
}

GroupQuery IndexContactSurface::group_query(const Vec3& p) const noexcept
{
    return {.origin = tree_.origin(), .scale = tree_.scale(), .position = p};
}

void IndexContactSurface::find_groups(const Vec3& p, double distance,
                                      GroupBoxes& boxes) const noexcept
{
    proxima::find_groups(tree_, p, distance, boxes);
}

void IndexContactSurface::read_triangles(std::span<const std::uint32_t> ranks,
                                         std::span<ContactTriangle> triangles) const noexcept
{
    const IndexParts& parts = index_.parts();
    const bool floats = parts.double_rows().empty();
    for (const std::uint32_t rank : ranks) {
        const auto* const row = floats ? static_cast<const void*>(&parts.float_rows()[rank])
                                       : static_cast<const void*>(&parts.double_rows()[rank]);
        __builtin_prefetch(row);
        __builtin_prefetch(static_cast<const std::byte*>(row) + 64);
    }
    for (std::size_t i = 0; i < ranks.size(); ++i) {
        triangles[i] = floats ? contact_triangle(parts.float_rows()[ranks[i]])
                              : contact_triangle(parts.double_rows()[ranks[i]]);
    }
}

double IndexContactSurface::clearance(const Vec3& p) const noexcept
{
    return less_rounding(std::sqrt(closest_feature(index_, p)->squared_distance), scale_, p);
}

Vec3 IndexContactSurface::nearest_exit(const Vec3& p) const noexcept
{
    const auto out = exit_of(index_, p);
    return out ? beyond(*out, p, safety_gap(scale_)) : p;
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

double IndexContactSurface::least_clearance(const Vec3& p) const noexcept
{
    if (has_list(index_.parts(), p)) return clearance(p);
    // Boxes no nearer than two thirds of the nearest one found are not opened.
    const TriangleTree& tree = tree_;
    const std::span<const TriangleTreeBlock> blocks =
        tree.blocks().subspan(tree.levels().front().first_block);
    const Vec3 at = (p - tree.origin()) * tree.scale();
    double least = std::numeric_limits<double>::infinity();
    visit_nearest(tree, p, least, [&](RowRange ranks) noexcept {
        const std::uint32_t id = ranks.first / TriangleTree::width;
        const TriangleTreeBlock& block = blocks[id / TriangleTree::width];
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double coordinate = at[static_cast<Eigen::Index>(axis)];
            const auto lower = static_cast<double>(block.lower[axis][id % TriangleTree::width]);
            const auto upper = static_cast<double>(block.upper[axis][id % TriangleTree::width]);
            const double gap = std::max({lower - coordinate, coordinate - upper, 0.0});
            squared += gap * gap;
        }
        constexpr double part = 4.0 / 9;
        least = std::min(least, part * squared / (tree.scale() * tree.scale()));
        return least;
    });
    return less_rounding(std::sqrt(least), scale_, p);
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
