#include "haptics/surface/patch_groups.h"

#include "base/check.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace proxima {

namespace {

Box box_of(std::span<const Triangle> triangles) noexcept
{
    Box box;
    for (const Triangle& triangle : triangles)
        for (const Vec3& corner : triangle.vertices) box.extend(corner);
    return box;
}

} // namespace

PatchGroups::PatchGroups(std::size_t triangles)
    : groups_((triangles + width - 1) / width),
      blocks_(TriangleTree::block_count(static_cast<std::uint32_t>(std::max(triangles, width))))
{}

void PatchGroups::make(std::span<const ContactTriangle> triangles, double extent) noexcept
{
    PROXIMA_CHECK_LE(triangles.size(), groups_.size() * width);
    triangle_count_ = static_cast<std::uint32_t>(triangles.size());
    if (triangles.empty()) return;
    Box all;
    for (const ContactTriangle& triangle : triangles)
        for (const Vec3& corner : triangle.corners.vertices) all.extend(corner);
    origin_ = all.center();
    scale_ = extent > 0 ? std::ldexp(1.0, std::clamp(-std::ilogb(extent), -1000, 1000)) : 1.0;
    reach_ = std::max(all.lower.cwiseAbs().maxCoeff(), all.upper.cwiseAbs().maxCoeff()) * scale_;
    // More than the rounding of coordinates up to 2 as floats, and the margin of triangle_tree.cpp.
    const double margin = 0x1p-22 + 0x1p-48 * reach_;
    std::fill_n(blocks_.begin(), TriangleTree::block_count(triangle_count_), detail::empty_block());
    std::array<Triangle, width> eight;
    for (std::size_t group = 0; group * width < triangles.size(); ++group) {
        const auto own = triangles.subspan(group * width)
                             .first(std::min(width, triangles.size() - group * width));
        std::ranges::transform(own, eight.begin(), &ContactTriangle::corners);
        const auto corners = std::span<const Triangle>(eight).first(own.size());
        groups_[group] = make_group(corners, scale_);
        set_box(group, box_of(corners), margin);
    }
    detail::fill_parents(tree().levels(), 1, blocks_);
}

void PatchGroups::set_box(std::size_t group, const Box& box, double margin) noexcept
{
    TriangleTreeBlock& block = blocks_[group / width];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const double low = (box.lower[k] - origin_[k]) * scale_ - margin;
        const double high = (box.upper[k] - origin_[k]) * scale_ + margin;
        block.lower[axis][group % width] = static_cast<float>(low);
        block.upper[axis][group % width] = static_cast<float>(high);
    }
}

TriangleTree PatchGroups::tree() const noexcept
{
    const std::size_t count = TriangleTree::block_count(triangle_count_);
    return TriangleTree::adopt(origin_, scale_, reach_, triangle_count_,
                               std::span(blocks_).first(count), nullptr);
}

} // namespace proxima
