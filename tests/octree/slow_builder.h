// An octree builder that is as plain as it can be: the oracle of every other one.
//
// Recursive, one cell at a time, every triangle of the parent tested against every child with the
// given overlap test, thirteen separating axes in long double if none is given.
#pragma once

#include "proxima/octree.h"

#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace proxima::testing {

/// Separating axes (thesis 3.6.3) in long double; touching counts. Its 11 more bits than double
/// make it exact for coordinates of up to about 20 bits.
inline bool slow_overlap(const Triangle& triangle, const Box& box)
{
    using Real = long double;
    using Vector = Eigen::Matrix<Real, 3, 1>;
    const Vector center = (box.lower.cast<Real>() + box.upper.cast<Real>()) / 2;
    const Vector half = (box.upper.cast<Real>() - box.lower.cast<Real>()) / 2;
    const Vector a = triangle[0].cast<Real>() - center;
    const Vector b = triangle[1].cast<Real>() - center;
    const Vector c = triangle[2].cast<Real>() - center;
    const auto separates = [&](const Vector& axis) {
        const Real reach = axis.cwiseAbs().dot(half);
        const Real pa = axis.dot(a);
        const Real pb = axis.dot(b);
        const Real pc = axis.dot(c);
        return std::min({pa, pb, pc}) > reach || std::max({pa, pb, pc}) < -reach;
    };
    if (separates((b - a).cross(c - a))) return false;
    for (int k = 0; k < 3; ++k) {
        const Vector unit = Vector::Unit(k);
        if (separates(unit) || separates(unit.cross(b - a)) || separates(unit.cross(c - b)) ||
            separates(unit.cross(a - c))) {
            return false;
        }
    }
    return true;
}

struct SlowOctreeOptions {
    int max_depth = 5;
    std::uint32_t threshold = 1;
    Subdivision subdivision = Subdivision::adaptive;
    std::optional<OctreeFrame> root =
        {}; ///< default: the cube on the bounding box, a little larger
};

namespace detail {

struct SlowArrays {
    std::vector<OctreeNode> nodes;
    std::vector<TriangleId> references;
};

template <class OverlapsBox>
struct SlowBuilder {
    const TriangleMesh& mesh;
    const SlowOctreeOptions& options;
    const OctreeFrame& frame;
    OverlapsBox& overlaps;
    SlowArrays& arrays;

    void fill(std::size_t record, CellKey key, const std::vector<TriangleId>& ids)
    {
        const bool uniform = options.subdivision == Subdivision::uniform;
        if (depth(key) == options.max_depth || (!uniform && ids.size() <= options.threshold)) {
            arrays.nodes[record] =
                OctreeNode::leaf(static_cast<std::uint32_t>(arrays.references.size()),
                                 static_cast<std::uint32_t>(ids.size()));
            arrays.references.insert(arrays.references.end(), ids.begin(), ids.end());
            return;
        }
        std::vector<std::pair<CellKey, std::vector<TriangleId>>> recorded;
        std::uint32_t mask = 0;
        for (int octant = 0; octant < 8; ++octant) {
            const CellKey child_key = child(key, octant);
            const Box box = cell_box(frame, child_key);
            std::vector<TriangleId> inside;
            for (const TriangleId id : ids) {
                if (overlaps(mesh.triangle(id), box)) inside.push_back(id);
            }
            if (inside.empty() && !uniform) continue;
            mask |= 1U << static_cast<unsigned>(octant);
            recorded.emplace_back(child_key, std::move(inside));
        }
        const std::size_t first = arrays.nodes.size();
        OctreeNode node = OctreeNode::split(static_cast<std::uint32_t>(first), mask);
        if (ids.empty()) node.packed |= OctreeNode::empty_split_bit;
        arrays.nodes[record] = node;
        arrays.nodes.resize(first + recorded.size());
        for (std::size_t i = 0; i < recorded.size(); ++i) {
            fill(first + i, recorded[i].first, recorded[i].second);
        }
    }
};

} // namespace detail

/// The cube on the mesh's bounding box, larger by 2^-20 so that rounding keeps the mesh inside.
inline OctreeFrame slow_root(const TriangleMesh& mesh)
{
    const Box box = bounding_box(mesh);
    const double edge = std::max(box.extent().maxCoeff(), 1e-6) * (1.0 + 0x1p-20);
    return {box.center() - Vec3::Constant(0.5 * edge), Vec3::Constant(edge)};
}

/// Builds an unclassified octree by `overlaps(triangle, box)`.
template <class OverlapsBox>
Octree slow_octree(const TriangleMesh& mesh, const SlowOctreeOptions& options, OverlapsBox overlaps)
{
    const OctreeFrame frame = options.root ? *options.root : slow_root(mesh);
    std::vector<TriangleId> all(mesh.triangle_count());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = TriangleId{static_cast<std::uint32_t>(i)};
    auto arrays = std::make_shared<detail::SlowArrays>();
    arrays->nodes.resize(1);
    detail::SlowBuilder<OverlapsBox>{mesh, options, frame, overlaps, *arrays}.fill(0, {}, all);
    const OctreeParameters parameters{.max_depth = options.max_depth,
                                      .threshold = options.threshold,
                                      .method = OverlapMethod::separating_axis,
                                      .subdivision = options.subdivision,
                                      .exact = true};
    return Octree::adopt(frame, parameters, mesh.triangle_count(), arrays->nodes,
                         arrays->references, arrays);
}

inline Octree slow_octree(const TriangleMesh& mesh, const SlowOctreeOptions& options = {})
{
    return slow_octree(mesh, options, slow_overlap);
}

} // namespace proxima::testing
