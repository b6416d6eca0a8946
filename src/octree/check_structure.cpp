#include "octree/check_structure.h"

#include "base/fixed_stack.h"
#include "base/progress.h"
#include "base/text.h"

#include <bit>
#include <cmath>
#include <vector>

namespace proxima {

namespace {

constexpr std::uint32_t known_split_bits = 0xFFFFU | OctreeNode::empty_split_bit;

/// A record that is still to be looked at.
struct Pending {
    std::uint32_t record = 0;
    int depth = 0;
    bool empty_is_inner = false; ///< the class bit its parent holds for it
};

class StructureChecker {
public:
    StructureChecker(const Octree& octree, Progress* progress)
        : octree_(octree), nodes_(octree.nodes()), reached_(nodes_.size()),
          listed_(octree.references().size()),
          steps_(progress, "checking the octree", nodes_.size() + listed_.size())
    {}

    Status run()
    {
        if (Status status = check_header(); !status) return status;
        FixedStack<Pending, 7 * max_octree_depth + 1> pending;
        pending.push({});
        reached_[0] = true;
        while (!pending.empty()) {
            const Pending top = pending.pop();
            const OctreeNode node = nodes_[top.record];
            if (!steps_.done(1)) return cancelled("checking the octree");
            if (node.is_leaf()) {
                if (Status status = check_leaf(top, node); !status) return status;
                continue;
            }
            if (Status status = check_split(top, node); !status) return status;
            std::uint32_t record = node.first;
            for (std::uint32_t mask = node.recorded_mask(); mask != 0; mask &= mask - 1) {
                const std::uint32_t lowest = mask & (~mask + 1U);
                pending.push({record++, top.depth + 1, (node.inner_mask() & lowest) != 0});
            }
        }
        if (reached_count_ != nodes_.size()) {
            return bad(concat(nodes_.size() - reached_count_, " records belong to no cell"), 0);
        }
        if (listed_count_ != listed_.size()) {
            return bad(concat(listed_.size() - listed_count_, " references belong to no leaf"), 0);
        }
        return {};
    }

private:
    static tl::unexpected<Error> bad(std::string message, std::uint32_t record)
    {
        return fail(ErrorCode::broken_invariant, std::move(message),
                    concat("octree record ", record));
    }

    [[nodiscard]] bool uniform() const noexcept
    {
        return octree_.parameters().subdivision == Subdivision::uniform;
    }

    [[nodiscard]] Status check_header() const
    {
        const OctreeParameters& parameters = octree_.parameters();
        const OctreeFrame& frame = octree_.frame();
        if (!frame.lower.allFinite() || !frame.edge.allFinite() ||
            !(frame.edge.array() > 0.0).all() || !(frame.lower + frame.edge).allFinite()) {
            return bad("the root cell is not a finite box", 0);
        }
        if (parameters.max_depth < 0 || parameters.max_depth > max_octree_depth) {
            return bad(concat("maximum depth ", parameters.max_depth, " is outside 0 to ",
                              max_octree_depth),
                       0);
        }
        if (parameters.method > OverlapMethod::pairwise ||
            parameters.subdivision > Subdivision::uniform) {
            return bad("unknown overlap method or subdivision", 0);
        }
        if (!parameters.classified && parameters.classification != ClassificationSummary{}) {
            return bad("a classification summary without classes", 0);
        }
        if (nodes_.empty() || nodes_.size() >= Cell::no_node) {
            return bad(concat("an octree has 1 to 2^32 - 2 records, this one ", nodes_.size()), 0);
        }
        if (octree_.triangle_count() > std::numeric_limits<std::int32_t>::max()) {
            return bad(concat("impossible number of triangles ", octree_.triangle_count()), 0);
        }
        return {};
    }

    Status check_leaf(const Pending& at, OctreeNode node)
    {
        if (uniform() && at.depth != octree_.parameters().max_depth) {
            return bad(concat("a leaf at depth ", at.depth, " of a uniform octree"), at.record);
        }
        if (!uniform() && node.is_empty()) {
            return bad("an empty leaf has a record of its own", at.record);
        }
        const std::uint64_t first = node.first;
        const std::uint64_t end = first + node.count();
        if (end > listed_.size()) {
            return bad(concat("a list ends at reference ", end, " of ", listed_.size()), at.record);
        }
        if (Status status = check_class_bit(at, node); !status) return status;
        const std::span<const TriangleId> list =
            octree_.references().subspan(node.first, node.count());
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (!steps_.done(1)) return cancelled("checking the octree");
            if (to_index(list[i]) >= octree_.triangle_count()) {
                return bad(concat("triangle ", to_index(list[i]), " of ", octree_.triangle_count()),
                           at.record);
            }
            if (i > 0 && list[i] <= list[i - 1]) return bad("a list does not ascend", at.record);
            if (listed_[first + i]) return bad("a reference belongs to two leaves", at.record);
            listed_[first + i] = true;
        }
        listed_count_ += list.size();
        ++reached_count_;
        return {};
    }

    Status check_split(const Pending& at, OctreeNode node)
    {
        if (at.depth >= octree_.parameters().max_depth) {
            return bad(concat("a cell at depth ", at.depth, " is split, the maximum is ",
                              octree_.parameters().max_depth),
                       at.record);
        }
        if ((node.packed & ~known_split_bits) != 0) return bad("unknown bits", at.record);
        const std::uint32_t recorded = node.recorded_mask();
        if (uniform() ? recorded != 0xFFU : recorded == 0 || node.is_empty()) {
            return bad("a split cell lacks children", at.record);
        }
        const auto children = static_cast<std::uint64_t>(std::popcount(recorded));
        if (node.first + children > nodes_.size()) {
            return bad(
                concat("children end at record ", node.first + children, " of ", nodes_.size()),
                at.record);
        }
        bool all_empty = true;
        for (std::uint64_t i = 0; i < children; ++i) {
            if (reached_[node.first + i]) {
                return bad(concat("record ", node.first + i, " has two parents"), at.record);
            }
            reached_[node.first + i] = true;
            all_empty = all_empty && nodes_[node.first + i].is_empty();
        }
        if (all_empty != node.is_empty()) {
            return bad("a split cell's empty bit contradicts its children", at.record);
        }
        if (!octree_.parameters().classified && node.inner_mask() != 0) {
            return bad("class bits in an unclassified octree", at.record);
        }
        if (node.is_empty() && node.inner_mask() != (at.empty_is_inner ? 0xFFU : 0U)) {
            return bad("an empty cell is partly inner", at.record);
        }
        if (Status status = check_class_bit(at, node); !status) return status;
        ++reached_count_;
        return {};
    }

    /// Cells that triangles touch are boundary, so their class bit is clear.
    static Status check_class_bit(const Pending& at, OctreeNode node)
    {
        if (at.empty_is_inner && !node.is_empty()) {
            return bad("a cell with triangles is marked inner", at.record);
        }
        return {};
    }

    const Octree& octree_;
    std::span<const OctreeNode> nodes_;
    std::vector<bool> reached_; ///< records that are the root or some cell's child
    std::vector<bool> listed_;  ///< references that some leaf holds
    StageSteps steps_;
    std::size_t reached_count_ = 0;
    std::size_t listed_count_ = 0;
};

} // namespace

Status check_structure(const Octree& octree, Progress* progress)
{
    return StructureChecker(octree, progress).run();
}

} // namespace proxima
