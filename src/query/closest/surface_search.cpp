#include "query/closest/surface_search.h"

#include "index/triangle_lanes.h"
#include "mesh/triangle_order.h"

#include <array>

namespace proxima {

Result<SurfaceSearch> build_surface_search(const TriangleMesh& mesh, const Topology& topology,
                                           const TriangleTreeOptions& options)
{
    const Result<Box> bounds = detail::checked_search_bounds(mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    SurfaceSearch search;
    search.mesh_ = &mesh;
    search.topology_ = &topology;
    {
        const auto items = triangle_order(mesh, *bounds, SpaceCurve::hilbert, options.progress);
        if (!items) return fail(ErrorCode::cancelled, "surface search: stopped on request");
        search.order_.reserve(items->size());
        for (const KeyedIndex& item : *items) search.order_.push_back(TriangleId{item.index});
    }
    Result<TriangleTree> tree = build_triangle_tree(mesh, search.order_, options);
    if (!tree) return tl::unexpected(tree.error());
    search.tree_ = std::move(*tree);
    return search;
}

void find_closest(const SurfaceSearch& search, const Vec3& p, NearestFeature& best) noexcept
{
    const double scale = search.tree().scale();
    const double reach = search.tree().reach();
    const RowScale row_scale{scale, 1 / scale};
    visit_nearest(
        search.tree(), p, row_scale.unscale_squared(best.squared), [&](RankRange ranks) noexcept {
            const std::span<const TriangleId> ids = search.triangles(ranks);
            std::array<double, TriangleTree::width> squared;
            triangle_distances(search.mesh(), ids, p, scale, squared);
            offer_nearest(
                squared, ids.size(), [&] { return triangle_distance_limit(best.squared, reach); },
                [&](std::size_t i) {
                    offer_triangle(search.mesh(), search.topology(), ids[i], p, row_scale, best);
                });
            return row_scale.unscale_squared(best.squared);
        });
}

ClosestFeature closest_feature(const SurfaceSearch& search, const Vec3& p) noexcept
{
    if (!p.allFinite()) return no_closest_feature();
    NearestFeature best;
    find_closest(search, p, best);
    return describe_closest(search.mesh(), search.topology(), best, p,
                            {search.tree().scale(), 1 / search.tree().scale()});
}

std::optional<ClosestFeature> closest_feature(const SurfaceSearch& search, const Vec3& p,
                                              double radius) noexcept
{
    if (!p.allFinite() || !(radius >= 0)) return std::nullopt;
    NearestFeature best;
    best.squared = radius * search.tree().scale() * (radius * search.tree().scale());
    const Feature none = best.feature;
    find_closest(search, p, best);
    if (best.feature == none) return std::nullopt;
    return describe_closest(search.mesh(), search.topology(), best, p,
                            {search.tree().scale(), 1 / search.tree().scale()});
}

} // namespace proxima
