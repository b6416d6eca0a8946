#include "index/visit_near.h"

#include "index/index_parts.h"

#include <algorithm>
#include <array>
#include <limits>

namespace proxima {

namespace {

/// More than distances in doubles are rounded by, those of boxes and those of rows: boxes are drawn
/// out by 2^-20 of the frame besides.
double raised(double squared) noexcept
{
    constexpr double rounding = 0x1p-40;
    return squared >= 0 ? squared * (1 + rounding) + std::numeric_limits<double>::min() : -1;
}

} // namespace

NearWalk::NearWalk(const IndexParts& index, const Box& query, double most_squared) noexcept
    : index_(index), query_{(query.lower - index.center()) * index.scale(),
                            (query.upper - index.center()) * index.scale()},
      most_(raised(most_squared))
{
    if (index.triangle_count() > 0) pending_.push({0, index.root()});
}

const IndexLeaf* NearWalk::next_leaf() noexcept
{
    while (!pending_.empty()) {
        const PendingBlock at = pending_.pop();
        if (at.squared > most_) continue;
        const IndexBlock& block = index_.blocks()[at.reference & ~index_leaf_bit];
        if ((at.reference & index_leaf_bit) != 0) return &block.leaf;
        enter(block.node);
    }
    return nullptr;
}

void NearWalk::shrink(double most_squared) noexcept
{
    most_ = std::min(most_, raised(most_squared));
}

void NearWalk::enter(const IndexNode& node) noexcept
{
    std::array<double, 8> squared{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const auto step = static_cast<double>(node.step[axis]);
        const double base = static_cast<double>(node.origin[axis]) + 32768.0 * step;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const double before = base + node.planes[axis][slot] * step - query_.upper[k];
            const double behind = query_.lower[k] - (base + node.planes[axis][8 + slot] * step);
            const double gap = std::max(std::max(before, behind), 0.0);
            squared[slot] += gap * gap;
        }
    }
    std::array<PendingBlock, 8> near{};
    std::size_t count = 0;
    for (std::size_t slot = 0; slot < 8; ++slot) {
        const bool is_child = node.planes[0][slot] <= node.planes[0][8 + slot];
        if (!is_child || !(squared[slot] <= most_)) continue;
        std::size_t position = count++;
        for (; position > 0 && near[position - 1].squared < squared[slot]; --position)
            near[position] = near[position - 1];
        near[position] = {squared[slot], node.children[slot]};
    }
    for (std::size_t i = 0; i < count; ++i) pending_.push(near[i]);
}

} // namespace proxima
