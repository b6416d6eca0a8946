// The groups of a patch's own triangles, with which queries of a patch are as quick as those of the
// whole surface.
//
//     triangles   t0..t7   t8..t15  ...    in the order of the patch, in which neighbours are near
//     groups      g0       g1       ...    corners as floats (triangle_groups.h)
//     tree        boxes of groups, boxes of eight boxes, ...    (triangle_tree.h)
//
// The thread that makes the patch fills them, in memory that was allocated before. Rings of triangles
// are scattered over the surface's groups, so they get groups of their own.
#pragma once

#include "haptics/surface/contact_triangle.h"
#include "haptics/surface/triangle_groups.h"
#include "haptics/surface/triangle_tree.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Groups of up to so many triangles. Copies are independent.
class PatchGroups {
public:
    explicit PatchGroups(std::size_t triangles);

    /// Groups these triangles, in this order. `extent` is the whole surface's (SurfaceScale).
    /// O(triangles), about 20 ns each; noexcept, no allocation. \pre finite corners, and at most as
    /// many triangles as the constructor was given
    void make(std::span<const ContactTriangle> triangles, double extent) noexcept;

    [[nodiscard]] std::span<const TriangleGroup> groups() const noexcept
    {
        return std::span(groups_).first((triangle_count_ + width - 1) / width);
    }
    /// The units of the tree.
    [[nodiscard]] GroupQuery query(const Vec3& p) const noexcept
    {
        return {.origin = origin_, .scale = scale_, .position = p};
    }
    /// The tree of the groups' boxes; it refers to this. \pre there are triangles
    [[nodiscard]] TriangleTree tree() const noexcept;

private:
    static constexpr std::size_t width = TriangleGroup::width;
    static_assert(width == TriangleTree::width);

    void set_box(std::size_t group, const Box& box, double margin) noexcept;

    std::vector<TriangleGroup> groups_;
    std::vector<TriangleTreeBlock> blocks_;
    std::uint32_t triangle_count_ = 0;
    Vec3 origin_ = Vec3::Zero();
    double scale_ = 1;
    double reach_ = 0;
};

} // namespace proxima
