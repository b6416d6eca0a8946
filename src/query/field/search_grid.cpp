#include "query/field/search_grid.h"

#include "index/index_parts.h"
#include "index/visit_near.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/field/search_grid.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/closest/search_index-inl.h"

#ifndef PROXIMA_QUERY_FIELD_SEARCH_GRID_ONCE
#define PROXIMA_QUERY_FIELD_SEARCH_GRID_ONCE

namespace proxima {

/// Boxes of leaves in the index's frame, eight side by side, and the references to these.
class LeafBoxes {
public:
    /// Eight boxes: by axis their lower planes and their upper ones.
    struct alignas(32) Group {
        std::array<std::array<float, 8>, 3> lower;
        std::array<std::array<float, 8>, 3> upper;
        std::array<std::uint32_t, 8> leaves;
    };

    [[nodiscard]] std::span<const Group> groups() const noexcept { return groups_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }

    void clear() noexcept
    {
        groups_.clear();
        size_ = 0;
    }

    /// Of a leaf's vertices, drawn out as those of blocks are, by more than floats round.
    void add(const IndexLeaf& leaf, std::uint32_t position)
    {
        constexpr float rounding = 0x1p-20F;
        Group& group = group_for_one_more();
        const std::size_t lane = size_++ % 8;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            float least = std::numeric_limits<float>::infinity();
            float most = -least;
            for (const auto& corners : leaf.corners) {
                for (std::size_t i = 0; i < leaf.count; ++i) {
                    least = std::min(least, leaf.coordinates[axis][corners[i]]);
                    most = std::max(most, leaf.coordinates[axis][corners[i]]);
                }
            }
            group.lower[axis][lane] = least - rounding;
            group.upper[axis][lane] = most + rounding;
        }
        group.leaves[lane] = position;
    }

    void add(const Group& from, std::size_t at)
    {
        Group& group = group_for_one_more();
        const std::size_t lane = size_++ % 8;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            group.lower[axis][lane] = from.lower[axis][at];
            group.upper[axis][lane] = from.upper[axis][at];
        }
        group.leaves[lane] = from.leaves[at];
    }

private:
    Group& group_for_one_more()
    {
        if (size_ % 8 == 0) {
            constexpr float none = std::numeric_limits<float>::infinity();
            groups_.emplace_back();
            for (auto& lower : groups_.back().lower) lower.fill(none);
            for (auto& upper : groups_.back().upper) upper.fill(-none);
        }
        return groups_.back();
    }

    std::vector<Group> groups_;
    std::size_t size_ = 0;
};

/// A search on its way: what it was asked, and memory that it uses again.
struct GridSearch {
    const IndexParts& index;
    const PointGrid& grid;
    double band;
    FunctionRef<void(const GridAnswers&)> take;
    std::array<LeafBoxes, 6> leaves; ///< by level: of blocks of 32 points a side, 16, 8, 4, 2, 1
    std::vector<RowDistance> found;
};

/// The box of a block's points.
inline Box points_box(const PointGrid& grid, const GridBlock& block) noexcept
{
    const auto [i, j, k] = block.first;
    return {grid.point(i, j, k),
            grid.point(i + block.size[0] - 1, j + block.size[1] - 1, k + block.size[2] - 1)};
}

/// A ball about a block's points.
struct GridBall {
    explicit GridBall(const Box& box) noexcept
        : middle(box.center()), radius(0.5 * box.extent().norm() * (1 + 0x1p-40))
    {}

    Vec3 middle;
    double radius;
};

} // namespace proxima

#endif

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Squared distances of a group's boxes from a box; infinite where there is none.
PROXIMA_LANE_OP Eight box_distances(const LeafBoxes::Group& group, const Eight3& lower,
                                    const Eight3& upper)
{
    const auto gap = [&](std::size_t axis, const Eight& least, const Eight& most) HWY_ATTR {
        return maximum(maximum(load_eight(group.lower[axis].data()) - most,
                               least - load_eight(group.upper[axis].data())),
                       eight(0.0F));
    };
    const Eight x = gap(0, lower.x, upper.x);
    const Eight y = gap(1, lower.y, upper.y);
    const Eight z = gap(2, lower.z, upper.z);
    return multiply_add(x, x, multiply_add(y, y, z * z));
}

template <class Scalar>
class GridWalk {
public:
    GridWalk(GridSearch& search, std::span<const TriangleRow<Scalar>> rows)
        : search_(search), index_(search.index), rows_(rows), blocks_(index_.blocks().data())
    {
        const PointGrid& grid = search.grid;
        const Vec3 last = grid.point(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
        const double size = std::max({grid.origin.cwiseAbs().maxCoeff(), last.cwiseAbs().maxCoeff(),
                                      index_.center().cwiseAbs().maxCoeff() + index_.unscale()});
        // More than coordinates are rounded by, and more than signs allow points on the surface.
        rounding_ = 0x1p-40 * size;
    }

    void run(const GridBlock& block)
    {
        const Box box = points_box(search_.grid, block);
        const GridBall ball(box);
        if (!is_near(ball)) return search_one_by_one(block);
        const double distance = to_mesh_unit(search_index(index_, rows_, ball.middle, infinite));
        if (is_beyond(ball, distance)) return search_.take({block, {}, true});
        LeafBoxes& leaves = search_.leaves[0];
        leaves.clear();
        const double reach = reach_of(ball, distance);
        NearWalk walk(index_, box, reach * reach);
        while (const IndexLeaf* const leaf = walk.next_leaf())
            leaves.add(*leaf, position_of(*leaf));
        descend(block, 0, ball, distance);
    }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();
    static constexpr std::uint32_t no_leaf = ~std::uint32_t{0};
    /// Blocks of 4 points a side are searched as they are where there are no more leaves.
    static constexpr std::size_t few_leaves = 96;

    /// \pre the level has the leaves that may be closest to points of the block, `distance` is that
    /// of its middle
    void descend(const GridBlock& block, std::size_t level, const GridBall& ball, double distance)
    {
        const std::uint32_t longest = *std::ranges::max_element(block.size);
        const std::size_t leaves = search_.leaves[level].size();
        if (longest <= 2 || (longest <= 4 && leaves <= few_leaves))
            return search_points(block, search_.leaves[level], ball, distance);
        std::array<std::array<std::uint32_t, 2>, 3> first{}; // of the halves along each axis
        std::array<std::array<std::uint32_t, 2>, 3> size{};
        const std::uint32_t half = std::bit_ceil(longest) / 2;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::uint32_t lower = std::min(half, block.size[axis]);
            first[axis] = {block.first[axis], block.first[axis] + lower};
            size[axis] = {lower, block.size[axis] - lower};
        }
        for (std::size_t part = 0; part < 8; ++part) {
            GridBlock piece;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                piece.first[axis] = first[axis][part >> axis & 1U];
                piece.size[axis] = size[axis][part >> axis & 1U];
            }
            if (std::ranges::find(piece.size, 0U) == piece.size.end())
                enter(piece, level, ball, distance);
        }
    }

    void enter(const GridBlock& block, std::size_t level, const GridBall& from,
               double from_distance)
    {
        const LeafBoxes& all = search_.leaves[level];
        const Box box = points_box(search_.grid, block);
        const GridBall ball(box);
        const double known = from_distance + (ball.middle - from.middle).norm();
        const double distance = to_mesh_unit(search_leaves(all, ball.middle, known));
        if (is_beyond(ball, distance)) return search_.take({block, {}, true});
        LeafBoxes& near = search_.leaves[level + 1];
        near.clear();
        const Eight3 lower = frame_lanes(box.lower);
        const Eight3 upper = frame_lanes(box.upper);
        const auto reach = static_cast<float>(reach_of(ball, distance) * (1 + 0x1p-18));
        for (const LeafBoxes::Group& group : all.groups()) {
            const Eight squared = box_distances(group, lower, upper);
            std::uint32_t bits = (squared <= eight(reach * reach)).bits();
            for (; bits != 0; bits &= bits - 1)
                near.add(group, static_cast<std::size_t>(std::countr_zero(bits)));
        }
        descend(block, level + 1, ball, distance);
    }

    /// The closest feature of p, in these leaves.
    RowDistance search_leaves(const LeafBoxes& leaves, const Vec3& p, double known)
    {
        IndexQuery query;
        if (query.begin(index_, p, known) != QueryStart::near) return {};
        const Eight3 lanes = lanes_of(query);
        const std::uint32_t begun = last_leaf_;
        const auto visit = [&](std::uint32_t leaf) {
            const float least = query.least;
            visit_leaf(index_, rows_, blocks_[leaf].leaf, lanes, p, query);
            if (query.least < least) last_leaf_ = leaf;
        };
        if (begun != no_leaf) visit(begun);
        for (const LeafBoxes::Group& group : leaves.groups()) {
            const Eight squared = box_distances(group, lanes, lanes);
            std::uint32_t bits = (squared <= eight(query.most)).bits();
            while (bits != 0) {
                const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
                bits &= bits - 1;
                if (group.leaves[lane] == begun) continue;
                visit(group.leaves[lane]);
                if (bits != 0) bits &= (squared <= eight(query.most)).bits();
            }
        }
        settle(index_, rows_, p, query);
        return query.best;
    }

    /// Each point after a neighbour.
    void search_points(const GridBlock& block, const LeafBoxes& leaves, const GridBall& ball,
                       double distance)
    {
        begin_answers(block);
        Vec3 last = ball.middle;
        double last_distance = distance;
        for_each_point(block, [&](std::size_t at, const Vec3& p) {
            const double known = last_distance + (p - last).norm();
            RowDistance& found = search_.found[at];
            found = search_leaves(leaves, p, std::min(known, search_.band));
            if (!found.found()) return;
            last = p;
            last_distance = to_mesh_unit(found);
        });
        search_.take({block, search_.found, distance > ball.radius + rounding_});
    }

    /// As any other points, where floats tell nothing.
    void search_one_by_one(const GridBlock& block)
    {
        begin_answers(block);
        for_each_point(block, [&](std::size_t at, const Vec3& p) {
            search_.found[at] = search_index(index_, rows_, p, search_.band);
        });
        search_.take({block, search_.found, false});
    }

    void begin_answers(const GridBlock& block)
    {
        search_.found.resize(std::size_t{block.size[0]} * block.size[1] * block.size[2]);
    }

    /// Calls visit(position, point) along rows forth and back.
    template <class Visit>
    void for_each_point(const GridBlock& block, const Visit& visit) const
    {
        const auto [width, height, depth] = block.size;
        for (std::uint32_t z = 0; z < depth; ++z) {
            for (std::uint32_t row = 0; row < height; ++row) {
                const std::uint32_t y = z % 2 == 0 ? row : height - 1 - row;
                for (std::uint32_t column = 0; column < width; ++column) {
                    const std::uint32_t x = (y + z) % 2 == 0 ? column : width - 1 - column;
                    visit((std::size_t{z} * height + y) * width + x,
                          search_.grid.point(block.first[0] + x, block.first[1] + y,
                                             block.first[2] + z));
                }
            }
        }
    }

    /// Whether floats tell the block's points apart.
    [[nodiscard]] bool is_near(const GridBall& ball) const noexcept
    {
        const double away = (ball.middle - index_.center()).cwiseAbs().maxCoeff() + ball.radius;
        return away * index_.scale() < IndexQuery::far - 1;
    }
    [[nodiscard]] bool is_beyond(const GridBall& ball, double distance) const noexcept
    {
        return distance - ball.radius - rounding_ > search_.band * (1 + 0x1p-40);
    }
    /// No point of the block is farther from its closest feature, in the frame.
    [[nodiscard]] double reach_of(const GridBall& ball, double distance) const noexcept
    {
        return (distance + ball.radius + rounding_) * index_.scale();
    }
    /// A point in the frame, in all lanes.
    [[nodiscard]] HWY_INLINE Eight3 frame_lanes(const Vec3& p) const noexcept
    {
        const Vec3 at = (p - index_.center()) * index_.scale();
        return {eight(static_cast<float>(at.x())), eight(static_cast<float>(at.y())),
                eight(static_cast<float>(at.z()))};
    }
    [[nodiscard]] double to_mesh_unit(const RowDistance& found) const noexcept
    {
        return std::sqrt(found.squared) * index_.unscale();
    }
    [[nodiscard]] std::uint32_t position_of(const IndexLeaf& leaf) const noexcept
    {
        return static_cast<std::uint32_t>(reinterpret_cast<const IndexBlock*>(&leaf) - blocks_);
    }

    GridSearch& search_;
    const IndexParts& index_;
    std::span<const TriangleRow<Scalar>> rows_;
    const IndexBlock* blocks_;
    double rounding_ = 0;
    std::uint32_t last_leaf_ = no_leaf;
};

void search_grid_block(GridSearch& search, const GridBlock& block)
{
    if (search.index.double_rows().empty()) {
        GridWalk(search, search.index.float_rows()).run(block);
    } else {
        GridWalk(search, search.index.double_rows()).run(block);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_grid_block);

void search_grid(const IndexParts& index, const PointGrid& grid, const GridBlock& block,
                 double band, FunctionRef<void(const GridAnswers&)> take)
{
    GridSearch search{index, grid, band, take, {}, {}};
    HWY_DYNAMIC_DISPATCH(search_grid_block)(search, block);
}

} // namespace proxima

#endif
