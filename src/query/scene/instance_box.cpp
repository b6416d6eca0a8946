#include "query/scene/instance_box.h"

#include "base/progress.h"
#include "index/index_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/scene/instance_box.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The box of all boxes, each turned. The same bits for any number of lanes.
Box turned_box(std::span<const ShapeBoxes> boxes, const Mat3& rotation)
{
    const hn::CappedTag<double, 8> d;
    Box all;
    for (int axis = 0; axis < 3; ++axis) {
        const auto x = hn::Set(d, rotation(axis, 0));
        const auto y = hn::Set(d, rotation(axis, 1));
        const auto z = hn::Set(d, rotation(axis, 2));
        auto lower = hn::Set(d, all.lower[axis]);
        auto upper = hn::Set(d, all.upper[axis]);
        for (const ShapeBoxes& eight : boxes) {
            for (std::size_t i = 0; i < 8; i += hn::Lanes(d)) {
                const auto along = [&](const auto& by_axis, auto a, auto b, auto c) {
                    return hn::Add(hn::Add(hn::Mul(a, hn::Load(d, by_axis[0].data() + i)),
                                           hn::Mul(b, hn::Load(d, by_axis[1].data() + i))),
                                   hn::Mul(c, hn::Load(d, by_axis[2].data() + i)));
                };
                const auto middle = along(eight.center, x, y, z);
                const auto half = along(eight.half, hn::Abs(x), hn::Abs(y), hn::Abs(z));
                lower = hn::Min(lower, hn::Sub(middle, half));
                upper = hn::Max(upper, hn::Add(middle, half));
            }
        }
        all.lower[axis] = hn::GetLane(hn::MinOfLanes(d, lower));
        all.upper[axis] = hn::GetLane(hn::MaxOfLanes(d, upper));
    }
    return all;
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(turned_box);

namespace {

/// A block and its box.
struct OpenBlock {
    std::uint32_t reference;
    Box box;
};

Box box_of_leaf(const IndexParts& index, const IndexLeaf& leaf)
{
    Box box;
    for (std::uint32_t i = 0; i < leaf.count; ++i)
        for (const Vec3& corner : index.triangle(leaf.first_row + i).vertices) box.extend(corner);
    return box;
}

double half_area(const Box& box)
{
    const Vec3 size = box.extent();
    return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

/// Puts the children of a node in its place.
void open_block(const IndexParts& index, std::size_t at, std::vector<OpenBlock>& open)
{
    const IndexNode& node = index.blocks()[open[at].reference].node;
    open[at] = open.back();
    open.pop_back();
    for (std::size_t slot = 0; slot < 8; ++slot) {
        if (!node.has_child(slot)) continue;
        const std::uint32_t reference = node.children[slot];
        OpenBlock child = {reference, {}};
        if ((reference & index_leaf_bit) != 0) {
            child.box = box_of_leaf(index, index.blocks()[reference & ~index_leaf_bit].leaf);
        } else {
            // Planes lie outward by more than these are rounded.
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                child.box.lower[k] = node.plane(axis, slot) * index.unscale() + index.center()[k];
                child.box.upper[k] =
                    node.plane(axis, 8 + slot) * index.unscale() + index.center()[k];
            }
        }
        open.push_back(child);
    }
}

/// A ball about the middle of the box that has all corners.
void set_ball(const IndexParts& index, const Box& all, Progress* progress, InstancedShape& shape)
{
    constexpr std::uint32_t rows_between_looks = 65536;

    shape.center = all.center();
    double squared = 0; // in the index's units, where squares stay within the doubles
    for (std::uint32_t row = 0; row < index.triangle_count(); ++row) {
        if (row % rows_between_looks == 0 && is_cancelled(progress)) return;
        for (const Vec3& corner : index.triangle(row).vertices) {
            const Vec3 off = (corner - shape.center) * index.scale();
            squared = std::max(squared, off.squaredNorm());
        }
    }
    shape.radius = std::sqrt(squared) * index.unscale() * (1 + 0x1p-40);
}

} // namespace

InstancedShape make_instanced_shape(const MeshIndex& index, Progress* progress)
{
    InstancedShape shape{index, {}, 0};
    const IndexParts& parts = index.parts();
    if (parts.triangle_count() == 0) return shape;
    std::vector<OpenBlock> open;
    if ((parts.root() & index_leaf_bit) != 0) {
        const IndexLeaf& leaf = parts.blocks()[parts.root() & ~index_leaf_bit].leaf;
        open.push_back({parts.root(), box_of_leaf(parts, leaf)});
    } else {
        open.push_back({parts.root(), {}});
        open_block(parts, 0, open);
    }
    while (open.size() + 7 <= most_shape_boxes) {
        std::size_t largest = open.size();
        double area = -1;
        for (std::size_t i = 0; i < open.size(); ++i) {
            if ((open[i].reference & index_leaf_bit) != 0 || !(half_area(open[i].box) > area))
                continue;
            area = half_area(open[i].box);
            largest = i;
        }
        if (largest == open.size()) break;
        open_block(parts, largest, open);
    }
    Box all;
    shape.boxes.resize((open.size() + 7) / 8);
    for (std::size_t i = 0; i < 8 * shape.boxes.size(); ++i) {
        const Box& box = open[std::min(i, open.size() - 1)].box;
        const Vec3 center = box.center();
        const Vec3 half = 0.5 * box.upper - 0.5 * box.lower;
        shape.reach = std::max(shape.reach, (center.cwiseAbs() + half).sum());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            shape.boxes[i / 8].center[axis][i % 8] = center[k];
            shape.boxes[i / 8].half[axis][i % 8] = half[k];
        }
        all.extend(center - half);
        all.extend(center + half);
    }
    set_ball(parts, all, progress, shape);
    return shape;
}

Box instance_box(const InstancedShape& shape, const RigidTransform& pose) noexcept
{
    const Mat3& r = pose.rotation;
    Box box = HWY_DYNAMIC_DISPATCH(turned_box)(shape.boxes, r);
    const Vec3 middle = r * shape.center;
    box.lower = box.lower.cwiseMax((middle.array() - shape.radius).matrix());
    box.upper = box.upper.cwiseMin((middle.array() + shape.radius).matrix());
    const double off = (r.transpose() * r - Mat3::Identity()).norm();
    const double slack =
        4 * off * shape.reach +
        scene_roundoff * (pose.translation.lpNorm<Eigen::Infinity>() + shape.reach) +
        std::numeric_limits<double>::min();
    box.lower = (box.lower + pose.translation).array() - slack;
    box.upper = (box.upper + pose.translation).array() + slack;
    return box;
}

} // namespace proxima

#endif
