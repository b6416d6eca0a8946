#include "cull_path.h"

#include "index/index_parts.h"

#include <algorithm>
#include <cstdint>

namespace proxima::bench {
namespace {

/// A plane in the index's units, over |n|_1.
struct UnitPlane {
    Vec3 normal;
    double offset;
};

std::vector<UnitPlane> planes_of(const MeshIndex& index, const ViewVolume& volume)
{
    std::vector<UnitPlane> planes;
    for (const ViewPlane& plane : volume.planes()) {
        const double length = plane.normal.cwiseAbs().sum();
        const Vec3 normal = plane.normal / length;
        planes.push_back({normal, (normal.dot(index.parts().center()) + plane.offset / length) *
                                      index.parts().scale()});
    }
    return planes;
}

/// How far a plane's values change over the root at most.
double motion(std::span<const UnitPlane> from, std::span<const UnitPlane> to)
{
    double most = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        most = std::max(most, (to[i].normal - from[i].normal).cwiseAbs().sum() +
                                  std::abs(to[i].offset - from[i].offset));
    }
    return most;
}

/// The blocks that planes cut, moved by up to `band`.
struct CutBlocks {
    std::size_t nodes = 0;
    std::vector<std::uint32_t> leaves; ///< ascending
};

CutBlocks cut_blocks(const MeshIndex& index, std::span<const UnitPlane> planes, double band)
{
    struct Pending {
        std::uint32_t reference;
        std::uint64_t mask;
    };
    CutBlocks cut;
    std::vector<Pending> pending = {
        {index.parts().root(), (std::uint64_t{1} << planes.size()) - 1}};
    while (!pending.empty()) {
        const Pending at = pending.back();
        pending.pop_back();
        const std::uint32_t block = at.reference & ~index_leaf_bit;
        if ((at.reference & index_leaf_bit) != 0) {
            cut.leaves.push_back(block);
            continue;
        }
        ++cut.nodes;
        const IndexNode& node = index.parts().blocks()[block].node;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            Box box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto plane = [&](std::uint8_t byte) {
                    return double{node.origin[axis]} + (32768.0 + byte) * double{node.step[axis]};
                };
                const auto k = static_cast<Eigen::Index>(axis);
                box.lower[k] = plane(node.planes[axis][slot]);
                box.upper[k] = plane(node.planes[axis][8 + slot]);
            }
            if (box.empty()) continue;
            std::uint64_t mask = 0;
            bool outside = false;
            for (std::size_t i = 0; i < planes.size() && !outside; ++i) {
                if ((at.mask >> i & 1U) == 0) continue;
                const double middle = planes[i].normal.dot(box.center()) + planes[i].offset;
                const double reach = planes[i].normal.cwiseAbs().dot(box.extent()) / 2 + band;
                outside = middle < -reach;
                if (middle <= reach) mask |= std::uint64_t{1} << i;
            }
            if (!outside && mask != 0) pending.push_back({node.children[slot], mask});
        }
    }
    std::ranges::sort(cut.leaves);
    return cut;
}

} // namespace

PathCounts count_path(const MeshIndex& index, std::span<const ViewVolume> frames)
{
    std::vector<std::vector<UnitPlane>> planes;
    for (const ViewVolume& frame : frames) planes.push_back(planes_of(index, frame));
    PathCounts counts;
    const auto count = static_cast<double>(frames.size());
    std::vector<std::uint32_t> last;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        CutBlocks cut = cut_blocks(index, planes[i], 0);
        counts.plain_nodes += static_cast<double>(cut.nodes) / count;
        counts.plain_leaves += static_cast<double>(cut.leaves.size()) / count;
        std::vector<std::uint32_t> both;
        std::ranges::set_intersection(cut.leaves, last, std::back_inserter(both));
        counts.kept_leaves += static_cast<double>(both.size());
        last = std::move(cut.leaves);
    }
    counts.kept_leaves /= std::max(1.0, counts.plain_leaves * (count - 1));
    for (std::size_t k = 0; k < front_frames.size(); ++k) {
        for (std::size_t first = 0; first < frames.size(); first += front_frames[k]) {
            const std::size_t end = std::min(frames.size(), first + front_frames[k]);
            double band = 0;
            for (std::size_t i = first; i < end; ++i)
                band = std::max(band, motion(planes[first], planes[i]));
            const CutBlocks front = cut_blocks(index, planes[first], band);
            const auto leaves = static_cast<double>(front.leaves.size());
            counts.with_front[k] +=
                (static_cast<double>(front.nodes) + leaves * static_cast<double>(end - first)) /
                count;
        }
    }
    return counts;
}

} // namespace proxima::bench
