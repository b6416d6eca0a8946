#include "query/field/search_grid.h"

#include "base/progress.h"
#include "index/index_parts.h"
#include "index/visit_near.h"
#include "query/closest/find_closest.h"
#include "query/field/grid_part.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/field/search_grid.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/closest/search_index-inl.h"
#include "query/field/covered_box-inl.h"
#include "query/field/point_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

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
        : search_(search), index_(search.index), lanes_(index_, search.squared),
          blocks_(index_.blocks().data())
    {
        // More than coordinates are rounded by, and more than signs allow points on the surface.
        rounding_ = 0x1p-40 * largest_coordinate(index_, search.grid);
    }

    void run(const GridBlock& block)
    {
        GridPart part = part_of(search_.grid, block, std::nullopt);
        if (!is_near(part)) return search_one_by_one(block);
        const RowDistance closest = find_closest(index_, part.middle, infinite);
        part.least = to_mesh_unit(closest);
        if (is_answered(part)) return;
        LeafBoxes& leaves = search_.leaves[0];
        leaves.clear();
        const double reach = reach_of(part);
        NearWalk walk(index_, part.box, reach * reach);
        while (const IndexLeaf* const leaf = walk.next_leaf()) {
            if (leaves.size() >= most_leaves(block)) return search_as_neighbours(part);
            leaves.add(*leaf, position_of(*leaf));
        }
        descend(part, 0, closest);
    }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();
    static constexpr std::uint32_t no_leaf = ~std::uint32_t{0};
    /// To compare each point of a block of eight with so many takes longer than to search the tree.
    static constexpr std::size_t most_triangles = 4096;
    // So many triangles are compared with all points of a block of so many a side.
    static constexpr std::size_t few_of_four = 64;
    static constexpr std::size_t few_of_eight = 8;

    /// To look at so many takes longer than to search the tree for each point.
    [[nodiscard]] static std::size_t most_leaves(const GridBlock& block) noexcept
    {
        const std::size_t points = std::size_t{block.size[0]} * block.size[1] * block.size[2];
        return std::max(2 * points, std::min(16 * points, 2 * most_triangles));
    }

    [[nodiscard]] static std::uint32_t longest_side(const GridBlock& block) noexcept
    {
        return *std::ranges::max_element(block.size);
    }

    /// The pieces of a block, cut in two along each axis that is longer than half of the longest.
    template <class Visit>
    static void for_each_piece(const GridBlock& block, const Visit& visit)
    {
        const std::uint32_t half = std::bit_ceil(longest_side(block)) / 2;
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

    /// Finds out where a part is that the surface does not enter. True where all of it is beyond the
    /// band: then that is its answer.
    bool is_answered(GridPart& part)
    {
        if (is_clear(part) && !part.inside) {
            part.inside =
                search_.question.side_of({part.middle, part.radius, part.least - rounding_});
        }
        if (!(part.least - part.radius - rounding_ > search_.question.band * (1 + 0x1p-40)))
            return false;
        take(part, {});
        return true;
    }

    void take(const GridPart& part, std::span<const RowDistance> found)
    {
        search_.question.take({part.block, found, is_clear(part), part.inside});
    }

    /// \pre the level has the leaves that may be closest to points of the part, `closest` is what is
    /// closest to its middle
    void descend(const GridPart& part, std::size_t level, const RowDistance& closest)
    {
        const LeafBoxes& leaves = search_.leaves[level];
        if (leaves.size() >= most_leaves(part.block)) return search_as_neighbours(part);
        if (longest_side(part.block) > 8) {
            return for_each_piece(part.block,
                                  [&](const GridBlock& piece) { enter(piece, level, part); });
        }
        TriangleLanes& near = search_.triangles[0];
        near.clear();
        const Triangle triangle = index_.triangle(closest.rank);
        EightTriangles lanes;
        for (int k = 0; k < 3; ++k) lanes.v[k] = frame_lanes(triangle[k]);
        const double extent = bounding_box(triangle).extent().maxCoeff() + rounding_;
        const CoveredBox covered =
            cover(part.box, lanes, static_cast<float>(extent * index_.scale()));
        for (const LeafBoxes::Group& group : leaves.groups()) {
            std::uint32_t near_leaves = may_be_closest(group, covered) & ((1U << group.count) - 1);
            for (; near_leaves != 0; near_leaves &= near_leaves - 1) {
                const auto place = static_cast<std::size_t>(std::countr_zero(near_leaves));
                const IndexLeaf& leaf = blocks_[group.leaves[place]].leaf;
                const EightTriangles triangles = triangles_of(leaf);
                const std::uint32_t bits =
                    may_be_closest(triangles, covered) & ((1U << leaf.count) - 1);
                keep(
                    triangles, bits, extent_of(leaf),
                    [&](std::uint32_t lane) { return leaf.first_row + lane; }, near);
            }
        }
        if (near.size() > most_triangles) return search_as_neighbours(part);
        descend_triangles(part, 0);
    }

    /// \pre the level has the triangles that may be closest to points of the part
    void descend_triangles(const GridPart& part, std::size_t level)
    {
        const TriangleLanes& all = search_.triangles[level];
        const std::uint32_t side = longest_side(part.block);
        const bool is_few = all.size() <= (side <= 4 ? few_of_four : few_of_eight);
        const bool is_told = part.inside || !search_.question.are_sides_dear;
        if (side <= 2 || (is_few && is_told)) return search_points(part, all);
        std::array<GridPart, 8> pieces;
        std::size_t count = 0;
        for_each_piece(part.block, [&](const GridBlock& block) {
            pieces[count++] = part_of(search_.grid, block, part.inside);
        });
        const std::array<Nearest, 8> nearest =
            lanes_.nearest_to(std::span(pieces).first(count), all);
        for (std::size_t i = 0; i < count; ++i) {
            GridPart& piece = pieces[i];
            piece.least = nearest[i].least;
            if (!is_answered(piece)) enter_triangles(piece, level, nearest[i]);
        }
    }

    void enter_triangles(const GridPart& part, std::size_t level, const Nearest& nearest)
    {
        const std::span<const TriangleLanes::Group> all = search_.triangles[level].groups();
        TriangleLanes& near = search_.triangles[level + 1];
        near.clear();
        const TriangleLanes::Group& of_nearest = all[nearest.triangle / 8];
        const CoveredBox covered =
            cover(part.box, in_all_lanes(of_nearest, nearest.triangle % 8), of_nearest.extent);
        for (const TriangleLanes::Group& group : all) {
            const EightTriangles triangles = triangles_of(group);
            const std::uint32_t bits =
                may_be_closest(triangles, covered) & ((1U << group.count) - 1);
            keep(
                triangles, bits, group.extent, [&](std::uint32_t lane) { return group.rows[lane]; },
                near);
        }
        descend_triangles(part, level + 1);
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

    /// By a triangle, in all lanes, that is about the closest to the middle.
    [[nodiscard]] HWY_NOINLINE CoveredBox cover(const Box& box, const EightTriangles& closest,
                                                float extent) const
    {
        // Of differences alone: far from the origin the box's center is rounded by more than floats are.
        const Vec3 lower = (box.lower - index_.center()) * index_.scale();
        const Vec3 upper = (box.upper - index_.center()) * index_.scale();
        const Vec3 middle = 0.5 * (lower + upper);
        const Vec3 half = 0.5 * (upper - lower);
        CoveredBox covered;
        float at[3];
        HWY_ALIGN float corners[3][8];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            at[axis] = static_cast<float>(middle[k]);
            covered.half[axis] = static_cast<float>(half[k] * (1 + 0x1p-20));
            for (std::size_t corner = 0; corner < 8; ++corner) {
                const bool is_upper = (corner >> axis & 1U) != 0;
                corners[axis][corner] =
                    at[axis] + (is_upper ? covered.half[axis] : -covered.half[axis]);
            }
        }
        covered.middle = {eight(at[0]), eight(at[1]), eight(at[2])};
        // As a query from the farthest corner rounds.
        IndexQuery query;
        query.error = IndexQuery::rounding_from((middle.cwiseAbs() + half).maxCoeff());
        covered.rounding = 16 * query.error;
        const TriangleDistances distances = distances_of(
            closest, {load_eight(corners[0]), load_eight(corners[1]), load_eight(corners[2])});
        HWY_ALIGN float squared[8];
        store_eight(distances.squared, squared);
        for (std::size_t corner = 0; corner < 8; ++corner)
            covered.reach[corner] = query.most_distance(squared[corner], extent) * (1 + 0x1p-20F);
        return covered;
    }

    void enter(const GridBlock& block, std::size_t level, const GridPart& from)
    {
        if (is_stopped()) return;
        const LeafBoxes& all = search_.leaves[level];
        GridPart part = part_of(search_.grid, block, from.inside);
        const double known = from.least + (part.middle - from.middle).norm();
        const RowDistance closest = search_leaves(all, part.middle, known);
        part.least = to_mesh_unit(closest);
        if (is_answered(part)) return;
        LeafBoxes& near = search_.leaves[level + 1];
        near.clear();
        const Eight3 lower = frame_lanes(part.box.lower);
        const Eight3 upper = frame_lanes(part.box.upper);
        const auto reach = static_cast<float>(reach_of(part) * (1 + 0x1p-18));
        for (const LeafBoxes::Group& group : all.groups()) {
            const Eight squared = box_distances(group, lower, upper);
            std::uint32_t bits = (squared <= eight(reach * reach)).bits();
            for (; bits != 0; bits &= bits - 1)
                near.add(group, static_cast<std::size_t>(std::countr_zero(bits)));
        }
        descend(part, level + 1, closest);
    }

    template <class RowOf>
    HWY_INLINE void take_leaf(const TriangleDistances& distances, std::uint32_t count, float extent,
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
            take_leaf(
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

    void search_points(const GridPart& part, const TriangleLanes& triangles)
    {
        begin_answers(part.block);
        for_each_point(part.block, [&](const Vec3& p) { search_.points.push_back(p); });
        for (std::size_t first = 0; first < search_.points.size(); first += most_together) {
            const std::size_t count = std::min(most_together, search_.points.size() - first);
            lanes_.search(triangles, std::span(search_.points).subspan(first, count),
                          search_.found.data() + first);
        }
        take(part, search_.found);
    }

    /// In the tree, each point after the one before it.
    void search_as_neighbours(const GridPart& part)
    {
        begin_answers(part.block);
        Vec3 last = part.middle;
        double last_distance = infinite;
        std::size_t at = 0;
        for_each_point(part.block, [&](const Vec3& p) {
            if (is_stopped()) return;
            const double known = last_distance + (p - last).norm();
            RowDistance& found = search_.found[at++];
            found = find_closest(index_, p, std::min(known, search_.question.band));
            if (!found.found()) return;
            last = p;
            last_distance = to_mesh_unit(found);
        });
        take(part, search_.found);
    }

    /// As any other points, where floats tell nothing.
    void search_one_by_one(const GridBlock& block)
    {
        begin_answers(block);
        std::size_t at = 0;
        for_each_point(block, [&](const Vec3& p) {
            if (is_stopped()) return;
            search_.found[at++] = find_closest(index_, p, search_.question.band);
        });
        search_.question.take({block, search_.found, false, std::nullopt});
    }

    void begin_answers(const GridBlock& block)
    {
        search_.points.clear();
        search_.found.assign(std::size_t{block.size[0]} * block.size[1] * block.size[2],
                             RowDistance{});
    }

    /// Calls visit(point), x fastest.
    template <class Visit>
    void for_each_point(const GridBlock& block, const Visit& visit) const
    {
        const auto [i, j, k] = block.first;
        for (std::uint32_t z = k; z < k + block.size[2]; ++z) {
            for (std::uint32_t y = j; y < j + block.size[1]; ++y) {
                for (std::uint32_t x = i; x < i + block.size[0]; ++x)
                    visit(search_.grid.point(x, y, z));
            }
        }
    }

    /// A point from which all of a round mesh is as far takes milliseconds: asked before each.
    [[nodiscard]] bool is_stopped() const noexcept
    {
        return is_cancelled(search_.question.progress);
    }
    /// Whether floats tell the part's points apart.
    [[nodiscard]] bool is_near(const GridPart& part) const noexcept
    {
        const double away = (part.middle - index_.center()).cwiseAbs().maxCoeff() + part.radius;
        return away * index_.scale() < IndexQuery::far - 1;
    }
    [[nodiscard]] bool is_clear(const GridPart& part) const noexcept
    {
        return part.least > part.radius + rounding_;
    }
    /// No point of the part is farther from its closest feature, in the frame. \pre least is exact
    [[nodiscard]] double reach_of(const GridPart& part) const noexcept
    {
        return (part.least + part.radius + rounding_) * index_.scale();
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
    PointLanes lanes_;
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

double largest_coordinate(const IndexParts& index, const PointGrid& grid) noexcept
{
    const Vec3 last = grid.point(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
    return std::max({grid.origin.cwiseAbs().maxCoeff(), last.cwiseAbs().maxCoeff(),
                     index.center().cwiseAbs().maxCoeff() + index.unscale()});
}

void search_grid(const IndexParts& index, const PointGrid& grid, const GridBlock& block,
                 const GridQuestion& question)
{
    GridSearch search{index, grid, question, {}, {}, {}, {}, {}};
    HWY_DYNAMIC_DISPATCH(search_grid_block)(search, block);
}

} // namespace proxima

#endif
