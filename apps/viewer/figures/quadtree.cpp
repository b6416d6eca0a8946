#include "viewer/figures/quadtree.h"

#include "thesis/minkowski_sums/planar_sum.h"

#include <array>

namespace proxima {
namespace {

class QuadtreeBuilder {
public:
    QuadtreeBuilder(std::vector<PlanarSum> sums, QuadtreeOptions options)
        : sums_(std::move(sums)), options_(std::move(options))
    {}

    std::vector<QuadtreeLeaf> build()
    {
        std::vector<int> all(sums_.size());
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
        visit({options_.center, options_.half, 0, {}}, all);
        return std::move(leaves_);
    }

private:
    void visit(QuadtreeLeaf cell, const std::vector<int>& candidates)
    {
        for (const int set : candidates)
            if (meets(cell, sums_[static_cast<std::size_t>(set)])) cell.sets.push_back(set);
        const bool crowded =
            cell.sets.size() > options_.threshold || options_.subdivision == Subdivision::uniform;
        if (!crowded || cell.depth == options_.max_depth) {
            leaves_.push_back(std::move(cell));
            return;
        }
        const double half = 0.5 * cell.half;
        for (int quadrant = 0; quadrant < 4; ++quadrant) {
            const Vec2 offset((quadrant & 1) != 0 ? half : -half,
                              (quadrant & 2) != 0 ? half : -half);
            visit({cell.center + offset, half, cell.depth + 1, {}}, cell.sets);
        }
    }

    static bool meets(const QuadtreeLeaf& cell, const PlanarSum& sum)
    {
        const PlanarScales scales = {.a = 1.0, .b = cell.half};
        for (const PlanarEdge& edge : sum.edges())
            if (edge.normal.dot(cell.center) > sum.offset(edge, scales)) return false;
        return true;
    }

    std::vector<PlanarSum> sums_;
    QuadtreeOptions options_;
    std::vector<QuadtreeLeaf> leaves_;
};

Vec2 outward_normal(const Vec2& from, const Vec2& to)
{
    const Vec2 along = to - from;
    return Vec2(along.y(), -along.x()).normalized();
}

} // namespace

Result<std::vector<QuadtreeLeaf>> quadtree_leaves(std::span<const ConvexPolygon> sets,
                                                  const QuadtreeOptions& options)
{
    const std::array<Vec2, 4> corners = {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)};
    const auto square = convex_polygon(corners);
    if (!square) return tl::unexpected(square.error());
    std::vector<PlanarSum> sums;
    for (const ConvexPolygon& set : sets) {
        auto sum = planar_sum(set, *square);
        if (!sum) return tl::unexpected(sum.error());
        sums.push_back(std::move(*sum));
    }
    return QuadtreeBuilder(std::move(sums), options).build();
}

Result<std::vector<ConvexPolygon>> edges_of(const ConvexPolygon& polygon)
{
    const auto corners = polygon.points();
    std::vector<ConvexPolygon> edges;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        auto edge = convex_polygon(std::array{corners[i], corners[(i + 1) % corners.size()]});
        if (!edge) return tl::unexpected(edge.error());
        edges.push_back(std::move(*edge));
    }
    return edges;
}

Result<std::vector<ConvexPolygon>> voronoi_regions_of(const ConvexPolygon& polygon)
{
    const auto corners = polygon.points();
    const std::size_t count = corners.size();
    std::vector<ConvexPolygon> regions;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec2& before = corners[(i + count - 1) % count];
        const Vec2& after = corners[(i + 1) % count];
        const std::array rays = {outward_normal(before, corners[i]),
                                 outward_normal(corners[i], after)};
        auto cone = convex_polygon(std::array{corners[i]}, rays);
        if (!cone) return tl::unexpected(cone.error());
        regions.push_back(std::move(*cone));
    }
    for (std::size_t i = 0; i < count; ++i) {
        const std::array ends = {corners[i], corners[(i + 1) % count]};
        auto strip = convex_polygon(ends, std::array{outward_normal(ends[0], ends[1])});
        if (!strip) return tl::unexpected(strip.error());
        regions.push_back(std::move(*strip));
    }
    return regions;
}

bool is_inside(const ConvexPolygon& polygon, const Vec2& point)
{
    const auto corners = polygon.points();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2 normal = outward_normal(corners[i], corners[(i + 1) % corners.size()]);
        if (normal.dot(point - corners[i]) > 0.0) return false;
    }
    return true;
}

} // namespace proxima
