#include "query/scene/instance_box.h"

#include "base/progress.h"
#include "index/index_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

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

/// A ball about the middle of the boxes that has all corners.
void set_ball(const IndexParts& index, Progress* progress, InstancedShape& shape)
{
    constexpr std::uint32_t rows_between_looks = 65536;

    Box all;
    for (const ShapeBox& box : shape.boxes) {
        all.extend(box.center - box.half);
        all.extend(box.center + box.half);
    }
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
    shape.boxes.reserve(open.size());
    for (const OpenBlock& block : open) {
        const Vec3 half = 0.5 * block.box.upper - 0.5 * block.box.lower;
        shape.boxes.push_back({block.box.center(), half});
        shape.reach = std::max(shape.reach, (block.box.center().cwiseAbs() + half).sum());
    }
    set_ball(parts, progress, shape);
    return shape;
}

Box instance_box(const InstancedShape& shape, const RigidTransform& pose) noexcept
{
    const Mat3& r = pose.rotation;
    const Mat3 sizes = r.cwiseAbs();
    Box box;
    for (const ShapeBox& part : shape.boxes) {
        const Vec3 center = r * part.center;
        const Vec3 half = sizes * part.half;
        box.lower = box.lower.cwiseMin(center - half);
        box.upper = box.upper.cwiseMax(center + half);
    }
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
