#include "query/field/search_grid.h"

#include "index/index_parts.h"
#include "index/visit_near.h"
#include "query/closest/find_closest.h"
#include "query/field/grid_candidates.h"

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

/// A search on its way: what it was asked, and memory that it uses again.
struct GridSearch {
    const IndexParts& index;
    const PointGrid& grid;
    double band;
    FunctionRef<void(const GridAnswers&)> take;
    std::array<LeafBoxes, 3> leaves;        ///< by level: of blocks of 32 points a side, 16, 8
    std::array<TriangleLanes, 3> triangles; ///< of blocks of 8, 4, 2
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

PROXIMA_LANE_OP Eight square_root(const Eight& a)
{
    return make_eight([&](std::size_t i) { return hn::Sqrt(a.part[i]); });
}
PROXIMA_LANE_OP Eight3 choose(const EightMask& mask, const Eight3& yes, const Eight3& no)
{
    return {choose(mask, yes.x, no.x), choose(mask, yes.y, no.y), choose(mask, yes.z, no.z)};
}

PROXIMA_LANE_OP EightTriangles triangles_of(const TriangleLanes::Group& group)
{
    const auto corner = [&](std::size_t k) HWY_ATTR {
        return Eight3{load_eight(group.corners[k][0].data()),
                      load_eight(group.corners[k][1].data()),
                      load_eight(group.corners[k][2].data())};
    };
    return {{corner(0), corner(1), corner(2)}};
}

/// From about the triangles' closest points towards p, no longer than 1.
PROXIMA_STEP Eight3 directions_of(const EightTriangles& triangles, const Eight3& p)
{
    const Eight tiny = eight(1e-30F);
    const Eight3 a[3] = {triangles.v[0] - p, triangles.v[1] - p, triangles.v[2] - p};
    Eight least = eight(0.0F);
    Eight3 towards{least, least, least};
    for (std::size_t i = 0; i < 3; ++i) {
        const Eight3 side = a[i == 2 ? 0 : i + 1] - a[i];
        const Eight t = minimum(
            maximum(quotient(-dot(a[i], side), maximum(dot(side, side), tiny)), eight(0.0F)),
            eight(1.0F));
        const Eight3 from{-multiply_add(t, side.x, a[i].x), -multiply_add(t, side.y, a[i].y),
                          -multiply_add(t, side.z, a[i].z)};
        const Eight squared = dot(from, from);
        const EightMask nearer = i == 0 ? squared <= squared : squared < least;
        towards = choose(nearer, from, towards);
        least = choose(nearer, squared, least);
    }
    // Inside, seen from the corners: where p is on the inner side of all sides.
    const Eight3 normal = cross(a[1] - a[0], a[2] - a[0]);
    const Eight within =
        minimum(minimum(dot(normal, cross(a[0], a[1])), dot(normal, cross(a[1], a[2]))),
                dot(normal, cross(a[2], a[0])));
    const EightMask behind = eight(0.0F) < dot(normal, a[0]);
    const Eight3 upright = choose(behind, Eight3{-normal.x, -normal.y, -normal.z}, normal);
    towards = choose(eight(0.0F) < within, upright, towards);
    const Eight factor =
        quotient(eight(1 - 0x1p-20F), square_root(maximum(dot(towards, towards), tiny)));
    return {towards.x * factor, towards.y * factor, towards.z * factor};
}

// Which triangles can be the closest of no point of a box: with n of length 1 at most, no point x is
// nearer to triangle f than the least of n (x - v) over its corners v. Where that is more than the
// distance of x to one triangle g at all eight corners of the box, it is in all of the box, for that
// distance is convex. n is the direction to the box's middle from the closest point of f: wherever it
// points, what it says is true.

/// A box of points in the frame, and how far each of its corners is from the triangle closest to its
/// middle, rounded up.
struct CoveredBox {
    Eight3 middle;
    float half[3];
    float reach[8];
    float rounding; ///< of differences of coordinates and their products
};

/// The lanes in which something may be the closest of a point in the box: `least` are the least of
/// n (middle - v).
PROXIMA_STEP std::uint32_t may_be_closest(const Eight3& n, const Eight& least,
                                          const CoveredBox& box)
{
    const Eight3 half{n.x * eight(box.half[0]), n.y * eight(box.half[1]), n.z * eight(box.half[2])};
    const Eight sure = least - eight(box.rounding);
    std::uint32_t some = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        Eight at = (corner & 1U) != 0 ? sure + half.x : sure - half.x;
        at = (corner & 2U) != 0 ? at + half.y : at - half.y;
        at = (corner & 4U) != 0 ? at + half.z : at - half.z;
        some |= (at <= eight(box.reach[corner])).bits();
    }
    return some;
}

/// The triangles of eight that may be the closest of a point in the box.
PROXIMA_STEP std::uint32_t may_be_closest(const EightTriangles& triangles, const CoveredBox& box)
{
    const Eight3 n = directions_of(triangles, box.middle);
    Eight least = dot(n, box.middle - triangles.v[0]);
    for (std::size_t k = 1; k < 3; ++k) least = minimum(least, dot(n, box.middle - triangles.v[k]));
    return may_be_closest(n, least, box);
}

/// The leaves of a group of which a triangle may be, by their boxes: n from these boxes' middles.
PROXIMA_STEP std::uint32_t may_be_closest(const LeafBoxes::Group& group, const CoveredBox& box)
{
    const auto lower = [&](std::size_t axis)
                           HWY_ATTR { return load_eight(group.lower[axis].data()); };
    const auto upper = [&](std::size_t axis)
                           HWY_ATTR { return load_eight(group.upper[axis].data()); };
    const auto middle = [&](std::size_t axis)
                            HWY_ATTR { return (lower(axis) + upper(axis)) * eight(0.5F); };
    const Eight3 away = box.middle - Eight3{middle(0), middle(1), middle(2)};
    const Eight factor =
        quotient(eight(1 - 0x1p-20F), square_root(maximum(dot(away, away), eight(1e-30F))));
    const Eight3 n{away.x * factor, away.y * factor, away.z * factor};
    const auto along = [&](std::size_t axis, const Eight& part, const Eight& to) HWY_ATTR {
        return minimum(part * (to - lower(axis)), part * (to - upper(axis)));
    };
    return may_be_closest(
        n, along(0, n.x, box.middle.x) + along(1, n.y, box.middle.y) + along(2, n.z, box.middle.z),
        box);
}

/// As settle, for floats or doubles. Called: what is copied into the walk is for both.
HWY_NOINLINE inline void settle_any(const IndexParts& index, const Vec3& p, IndexQuery& query)
{
    if (index.double_rows().empty()) {
        settle(index, index.float_rows(), p, query);
    } else {
        settle(index, index.double_rows(), p, query);
    }
}

class GridWalk {
public:
    explicit GridWalk(GridSearch& search)
        : search_(search), index_(search.index), blocks_(index_.blocks().data())
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
        const RowDistance middle = find_closest(index_, ball.middle, infinite);
        const double distance = to_mesh_unit(middle);
        if (is_beyond(ball, distance)) return search_.take({block, {}, true});
        LeafBoxes& leaves = search_.leaves[0];
        leaves.clear();
        const double reach = reach_of(ball, distance);
        NearWalk walk(index_, box, reach * reach);
        while (const IndexLeaf* const leaf = walk.next_leaf()) {
            if (leaves.size() >= most_leaves(block))
                return search_as_neighbours(block, ball, middle);
            leaves.add(*leaf, position_of(*leaf));
        }
        descend(block, 0, box, ball, middle);
    }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();
    static constexpr std::uint32_t no_leaf = ~std::uint32_t{0};

    /// To look at so many takes longer than to search the tree for each point.
    [[nodiscard]] static std::size_t most_leaves(const GridBlock& block) noexcept
    {
        return 2 * std::size_t{block.size[0]} * block.size[1] * block.size[2];
    }

    /// The pieces of a block, cut in two along each axis that is longer than half of the longest.
    template <class Visit>
    static void for_each_piece(const GridBlock& block, const Visit& visit)
    {
        const std::uint32_t half = std::bit_ceil(*std::ranges::max_element(block.size)) / 2;
        for (std::size_t part = 0; part < 8; ++part) {
            GridBlock piece;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::uint32_t lower = std::min(half, block.size[axis]);
                const bool is_upper = (part >> axis & 1U) != 0;
                piece.first[axis] = block.first[axis] + (is_upper ? lower : 0);
                piece.size[axis] = is_upper ? block.size[axis] - lower : lower;
            }
            if (std::ranges::find(piece.size, 0U) == piece.size.end()) visit(piece);
        }
    }

    /// \pre the level has the leaves that may be closest to points of the block, `distance` is that
    /// of its middle
    void descend(const GridBlock& block, std::size_t level, const Box& box, const GridBall& ball,
                 const RowDistance& middle)
    {
        const LeafBoxes& leaves = search_.leaves[level];
        if (leaves.size() >= most_leaves(block)) return search_as_neighbours(block, ball, middle);
        if (*std::ranges::max_element(block.size) > 8) {
            return for_each_piece(block, [&](const GridBlock& piece) {
                enter(piece, level, ball, to_mesh_unit(middle));
            });
        }
        TriangleLanes& near = search_.triangles[0];
        near.clear();
        const CoveredBox covered = cover(box, middle);
        for (const LeafBoxes::Group& group : leaves.groups()) {
            std::uint32_t near_leaves = may_be_closest(group, covered) & ((1U << group.count) - 1);
            for (; near_leaves != 0; near_leaves &= near_leaves - 1) {
                const auto place = static_cast<std::size_t>(std::countr_zero(near_leaves));
                const IndexLeaf& leaf = blocks_[group.leaves[place]].leaf;
                const EightTriangles triangles = triangles_of(leaf);
                const std::uint32_t lanes =
                    may_be_closest(triangles, covered) & ((1U << leaf.count) - 1);
                keep(
                    triangles, lanes, extent_of(leaf),
                    [&](std::uint32_t lane) { return leaf.first_row + lane; }, near);
            }
        }
        descend_triangles(block, 0, ball, middle);
    }

    /// \pre the level has the triangles that may be closest to points of the block
    void descend_triangles(const GridBlock& block, std::size_t level, const GridBall& ball,
                           const RowDistance& middle)
    {
        constexpr std::size_t few = 2;
        const std::size_t groups = search_.triangles[level].groups().size();
        if (groups <= few || *std::ranges::max_element(block.size) <= 2)
            return search_points(block, search_.triangles[level], ball, middle);
        for_each_piece(block, [&](const GridBlock& piece) {
            enter_triangles(piece, level, ball, to_mesh_unit(middle));
        });
    }

    void enter_triangles(const GridBlock& block, std::size_t level, const GridBall& from,
                         double from_distance)
    {
        const TriangleLanes& all = search_.triangles[level];
        const Box box = points_box(search_.grid, block);
        const GridBall ball(box);
        const double known = from_distance + (ball.middle - from.middle).norm();
        const RowDistance middle = search_triangles(all, ball.middle, known);
        if (is_beyond(ball, to_mesh_unit(middle))) return search_.take({block, {}, true});
        TriangleLanes& near = search_.triangles[level + 1];
        near.clear();
        const CoveredBox covered = cover(box, middle);
        for (const TriangleLanes::Group& group : all.groups()) {
            const EightTriangles triangles = triangles_of(group);
            const std::uint32_t lanes =
                may_be_closest(triangles, covered) & ((1U << group.count) - 1);
            keep(
                triangles, lanes, group.extent,
                [&](std::uint32_t lane) { return group.rows[lane]; }, near);
        }
        descend_triangles(block, level + 1, ball, middle);
    }

    template <class RowOf>
    static void keep(const EightTriangles& triangles, std::uint32_t lanes, float extent,
                     const RowOf& row_of, TriangleLanes& to)
    {
        if (lanes == 0) return;
        HWY_ALIGN float corners[3][3][8];
        for (std::size_t k = 0; k < 3; ++k) {
            store_eight(triangles.v[k].x, corners[k][0]);
            store_eight(triangles.v[k].y, corners[k][1]);
            store_eight(triangles.v[k].z, corners[k][2]);
        }
        to.add(corners, lanes, extent, row_of);
    }

    /// By the triangle that is closest to the middle.
    [[nodiscard]] HWY_NOINLINE CoveredBox cover(const Box& box, const RowDistance& closest) const
    {
        const Vec3 middle = (box.center() - index_.center()) * index_.scale();
        const Vec3 half = 0.5 * box.extent() * index_.scale();
        CoveredBox covered;
        float at[3];
        float signs[3][8];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            at[axis] = static_cast<float>(middle[k]);
            covered.half[axis] = static_cast<float>(half[k] * (1 + 0x1p-20));
            for (std::size_t corner = 0; corner < 8; ++corner) {
                signs[axis][corner] = at[axis] + ((corner >> axis & 1U) != 0 ? covered.half[axis]
                                                                             : -covered.half[axis]);
            }
        }
        covered.middle = {eight(at[0]), eight(at[1]), eight(at[2])};
        // As a query from the farthest corner rounds.
        IndexQuery query;
        query.error = IndexQuery::rounding_from((middle.cwiseAbs() + half).maxCoeff());
        covered.rounding = 16 * query.error;
        const Triangle triangle = index_.triangle(closest.rank);
        EightTriangles lanes;
        for (int k = 0; k < 3; ++k) lanes.v[k] = frame_lanes(triangle[k]);
        const TriangleDistances distances =
            distances_of(lanes, {load_eight(signs[0]), load_eight(signs[1]), load_eight(signs[2])});
        HWY_ALIGN float squared[8];
        store_eight(distances.squared, squared);
        const auto extent = static_cast<float>(
            (bounding_box(triangle).extent().maxCoeff() + rounding_) * index_.scale());
        for (std::size_t corner = 0; corner < 8; ++corner)
            covered.reach[corner] = query.most_distance(squared[corner], extent) * (1 + 0x1p-20F);
        return covered;
    }

    void enter(const GridBlock& block, std::size_t level, const GridBall& from,
               double from_distance)
    {
        const LeafBoxes& all = search_.leaves[level];
        const Box box = points_box(search_.grid, block);
        const GridBall ball(box);
        const double known = from_distance + (ball.middle - from.middle).norm();
        const RowDistance middle = search_leaves(all, ball.middle, known);
        const double distance = to_mesh_unit(middle);
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
        descend(block, level + 1, box, ball, middle);
    }

    template <class RowOf>
    HWY_INLINE void take(const TriangleDistances& distances, std::uint32_t count, float extent,
                         const RowOf& row_of, const Vec3& p, IndexQuery& query) const
    {
        take_triangles(
            distances, count, extent, row_of, [&](std::uint32_t row) { prefetch_row(row); },
            [&] { settle_any(index_, p, query); }, query);
    }

    HWY_INLINE void prefetch_row(std::uint32_t row) const
    {
        if (index_.double_rows().empty()) {
            prefetch_row_of(index_.float_rows()[row]);
        } else {
            prefetch_row_of(index_.double_rows()[row]);
        }
    }

    /// The closest feature of p, in these leaves.
    HWY_NOINLINE RowDistance search_leaves(const LeafBoxes& leaves, const Vec3& p, double known)
    {
        IndexQuery query;
        if (query.begin(index_, p, known) != QueryStart::near) return {};
        const Eight3 lanes = lanes_of(query);
        const std::uint32_t begun = last_leaf_;
        const auto visit = [&](std::uint32_t leaf) {
            const float least = query.least;
            const IndexLeaf& triangles = blocks_[leaf].leaf;
            take(
                distances_of(triangles_of(triangles), lanes), triangles.count, extent_of(triangles),
                [&](std::uint32_t lane) { return triangles.first_row + lane; }, p, query);
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
        settle_any(index_, p, query);
        return query.best;
    }

    /// The closest feature of p among these triangles.
    HWY_NOINLINE RowDistance search_triangles(const TriangleLanes& triangles, const Vec3& p,
                                              double known)
    {
        IndexQuery query;
        if (query.begin(index_, p, known) != QueryStart::near) return {};
        const Eight3 lanes = lanes_of(query);
        for (const TriangleLanes::Group& group : triangles.groups()) {
            take(
                distances_of(triangles_of(group), lanes), group.count, group.extent,
                [&](std::uint32_t lane) { return group.rows[lane]; }, p, query);
        }
        settle_any(index_, p, query);
        return query.best;
    }

    /// Each point after a neighbour, by search(point, known).
    template <class Search>
    void search_each(const GridBlock& block, const GridBall& ball, const RowDistance& middle,
                     const Search& search)
    {
        begin_answers(block);
        Vec3 last = ball.middle;
        const double distance = to_mesh_unit(middle);
        double last_distance = distance;
        for_each_point(block, [&](std::size_t at, const Vec3& p) {
            const double known = last_distance + (p - last).norm();
            RowDistance& found = search_.found[at];
            found = search(p, std::min(known, search_.band));
            if (!found.found()) return;
            last = p;
            last_distance = to_mesh_unit(found);
        });
        search_.take({block, search_.found, distance > ball.radius + rounding_});
    }

    void search_points(const GridBlock& block, const TriangleLanes& triangles, const GridBall& ball,
                       const RowDistance& middle)
    {
        search_each(block, ball, middle, [&](const Vec3& p, double known) {
            return search_triangles(triangles, p, known);
        });
    }

    /// In the tree.
    void search_as_neighbours(const GridBlock& block, const GridBall& ball,
                              const RowDistance& middle)
    {
        search_each(block, ball, middle,
                    [&](const Vec3& p, double known) { return find_closest(index_, p, known); });
    }

    /// As any other points, where floats tell nothing.
    void search_one_by_one(const GridBlock& block)
    {
        begin_answers(block);
        for_each_point(block, [&](std::size_t at, const Vec3& p) {
            search_.found[at] = find_closest(index_, p, search_.band);
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
    const IndexBlock* blocks_;
    double rounding_ = 0;
    std::uint32_t last_leaf_ = no_leaf;
};

void search_grid_block(GridSearch& search, const GridBlock& block)
{
    GridWalk(search).run(block);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(search_grid_block);

void search_grid(const IndexParts& index, const PointGrid& grid, const GridBlock& block,
                 double band, FunctionRef<void(const GridAnswers&)> take)
{
    GridSearch search{index, grid, band, take, {}, {}, {}};
    HWY_DYNAMIC_DISPATCH(search_grid_block)(search, block);
}

} // namespace proxima

#endif
