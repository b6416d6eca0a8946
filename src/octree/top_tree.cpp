#include "octree/top_tree.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace proxima {

namespace {

enum class TopState : std::uint8_t { empty, leaf, split };

class TopTree {
public:
    TopTree(const CoarseBins& bins, std::uint32_t threshold) : bins_(bins), threshold_(threshold)
    {
        states_.resize(static_cast<std::size_t>(bins.depth) + 1);
        for (int depth = bins.depth; depth >= 0; --depth) decide(depth);
    }

    [[nodiscard]] std::vector<SubtreeSlot> write(OctreeOutput& output)
    {
        std::vector<SubtreeSlot> level = {{0, 0}};
        output.nodes.push_back(OctreeNode{});
        for (int depth = 0; depth < bins_.depth; ++depth) {
            std::vector<SubtreeSlot> next;
            for (const SubtreeSlot& slot : level) {
                if (state(depth, slot.cell) == TopState::leaf) {
                    write_leaf(depth, slot, output);
                } else {
                    write_split(depth, slot, next, output);
                }
            }
            level = std::move(next);
        }
        return level;
    }

private:
    [[nodiscard]] TopState state(int depth, std::size_t cell) const
    {
        return states_[static_cast<std::size_t>(depth)][cell];
    }

    /// Coarse cells below a cell: [first, first + count).
    [[nodiscard]] std::size_t cells_below(int depth) const
    {
        return std::size_t{1} << (3 * (bins_.depth - depth));
    }

    void decide(int depth)
    {
        const std::size_t below = cells_below(depth);
        auto& states = states_[static_cast<std::size_t>(depth)];
        states.resize(std::size_t{1} << (3 * depth));
        for (std::size_t cell = 0; cell < states.size(); ++cell) {
            const std::uint32_t pairs = bins_.first[(cell + 1) * below] - bins_.first[cell * below];
            if (pairs == 0) {
                states[cell] = TopState::empty;
            } else if (pairs > threshold_ &&
                       (depth == bins_.depth || has_split_child(depth, cell) ||
                        merge(depth, cell).size() > threshold_)) {
                states[cell] = TopState::split;
            } else {
                states[cell] = TopState::leaf;
            }
        }
    }

    [[nodiscard]] bool has_split_child(int depth, std::size_t cell) const
    {
        for (std::size_t child = 0; child < 8; ++child) {
            if (state(depth + 1, 8 * cell + child) == TopState::split) return true;
        }
        return false;
    }

    /// The distinct triangles of a cell, ascending.
    [[nodiscard]] const std::vector<std::uint32_t>& merge(int depth, std::size_t cell)
    {
        const std::size_t below = cells_below(depth);
        const auto ids = bins_.ids.span().subspan(
            bins_.first[cell * below], bins_.first[(cell + 1) * below] - bins_.first[cell * below]);
        merged_.assign(ids.begin(), ids.end());
        std::sort(merged_.begin(), merged_.end());
        merged_.erase(std::unique(merged_.begin(), merged_.end()), merged_.end());
        return merged_;
    }

    void write_leaf(int depth, const SubtreeSlot& slot, OctreeOutput& output)
    {
        const auto& triangles = merge(depth, slot.cell);
        const auto first = static_cast<std::uint32_t>(output.references.size());
        for (const std::uint32_t triangle : triangles) {
            output.references.push_back(TriangleId{triangle});
        }
        output.nodes[slot.record] =
            OctreeNode::leaf(first, static_cast<std::uint32_t>(triangles.size()));
    }

    void write_split(int depth, const SubtreeSlot& slot, std::vector<SubtreeSlot>& next,
                     OctreeOutput& output) const
    {
        const auto first_child = static_cast<std::uint32_t>(output.nodes.size());
        std::uint32_t recorded = 0;
        for (std::uint32_t child = 0; child < 8; ++child) {
            const std::uint32_t cell = 8 * slot.cell + child;
            if (state(depth + 1, cell) == TopState::empty) continue;
            recorded |= 1U << child;
            next.push_back({cell, static_cast<std::uint32_t>(output.nodes.size())});
            output.nodes.push_back(OctreeNode{});
        }
        output.nodes[slot.record] = OctreeNode::split(first_child, recorded);
    }

    const CoarseBins& bins_;
    std::uint32_t threshold_;
    std::vector<std::vector<TopState>> states_;
    std::vector<std::uint32_t> merged_;
};

} // namespace

std::vector<SubtreeSlot> build_top_tree(const CoarseBins& bins, std::uint32_t threshold,
                                        OctreeOutput& output)
{
    return TopTree(bins, threshold).write(output);
}

} // namespace proxima
