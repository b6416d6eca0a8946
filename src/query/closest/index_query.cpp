#include "query/closest/index_query.h"

#include <algorithm>

namespace proxima {

namespace {

/// Squared distances are rounded by less, and so are those of rows.
constexpr double distance_rounding = 0x1p-40;

template <class Scalar>
RowDistance first_vertex_of(std::span<const TriangleRow<Scalar>> rows)
{
    RowDistance first;
    for (std::uint32_t rank = 0; rank < rows.size(); ++rank) {
        for (const std::uint32_t vertex : rows[rank].vertices) {
            if (vertex >= first.feature) continue;
            first.feature = vertex;
            first.rank = rank;
        }
    }
    return first;
}

} // namespace

FarWalk::FarWalk(const MeshIndex& index, const Vec3& p, double known) noexcept
    : index_(index), p_((p - index.center()) * index.scale())
{
    const double wanted = known * index.scale();
    most_ = wanted * wanted * (1 + distance_rounding) + distance_rounding;
    pending_.push({0, index.root()});
}

const IndexLeaf* FarWalk::next_leaf() noexcept
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

void FarWalk::shrink(double squared) noexcept
{
    most_ = std::min(most_, squared * (1 + distance_rounding) + distance_rounding);
}

void FarWalk::enter(const IndexNode& node) noexcept
{
    std::array<PendingBlock, 8> near{};
    std::size_t count = 0;
    for (std::size_t slot = 0; slot < 8; ++slot) {
        if (node.planes[0][slot] > node.planes[0][8 + slot]) continue; // no child
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto plane = [&](std::size_t byte) {
                return static_cast<double>(node.origin[axis]) +
                       (32768.0 + node.planes[axis][byte]) * static_cast<double>(node.step[axis]);
            };
            const double at = p_[static_cast<Eigen::Index>(axis)];
            const double gap = std::max({plane(slot) - at, at - plane(8 + slot), 0.0});
            squared += gap * gap;
        }
        if (squared > most_) continue;
        std::size_t place = count++;
        for (; place > 0 && near[place - 1].squared < squared; --place)
            near[place] = near[place - 1];
        near[place] = {squared, node.children[slot]};
    }
    for (std::size_t i = 0; i < count; ++i) pending_.push(near[i]);
}

RowDistance first_vertex(std::span<const TriangleRow<float>> rows) noexcept
{
    return first_vertex_of(rows);
}

RowDistance first_vertex(std::span<const TriangleRow<double>> rows) noexcept
{
    return first_vertex_of(rows);
}

} // namespace proxima
