#include "thesis/proximity_octree/grown_regions.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/length.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/minkowski_sum.h"
#include "thesis/proximity_octree/voronoi_region.h"

#include <array>
#include <atomic>
#include <cmath>
#include <optional>

namespace proxima {
namespace {

// What rounding may do. Let u = 2^-53 and M bound the coordinates in the root, so that no two of
// its points are farther apart than 2 sqrt(3) M.
// - A facet's normal is off by at most 4 u per component, its plane at a point of the root by
//   4 u sqrt(3) * 2 sqrt(3) M = 24 u M.
// - Three-term dot products of a normal with a point lose 3 u sqrt(3) M each; there are two for the
//   offset and one for the centre: 16 u M. The growth's, times a half size below M: 6 u M.
// - Centre and half size of a cell and its planes are off by at most 5 u M per axis together
//   (rounding_bounds.h), along a normal by 9 u M.
// - A ray is a normal of length 1, off by 4 u per component. What lies in the root at a distance r
//   from a corner is sum l_i n_i with l_i >= 0 and sum l_i <= r / k, where z . n_i >= k for some z
//   of length 1: it moves by at most 4 u sqrt(3) r / k <= 24 u M / k.
// Together below (64 + 32 / k) u M.
constexpr double half_ulp = 0x1p-53;
constexpr double plane_allowance = 64 * half_ulp;
constexpr double ray_allowance = 32 * half_ulp;

/// So many features are one task.
constexpr std::size_t block = 64;

class RegionGrower {
public:
    RegionGrower(const TriangleMesh& mesh, const Topology& topology, const ConvexSurface& surface,
                 const OctreeFrame& root)
        : mesh_(mesh), topology_(topology), surface_(surface), numbers_(topology),
          cube_(polyhedron_of_box({Vec3::Constant(-1), Vec3::Constant(1)}).value()),
          reach_(std::max(root.lower.cwiseAbs().maxCoeff(),
                          (root.lower + root.edge).cwiseAbs().maxCoeff())),
          diagonal_(root.edge.norm())
    {}

    /// Appends the planes of one feature's grown region; none where it has none.
    Status append(std::uint32_t number, std::vector<GrowingPlane>& planes) const
    {
        const Feature feature = numbers_.feature(number);
        if (!is_listed(feature)) return {};
        const auto region = region_of(feature);
        if (!region) return tl::unexpected(region.error());
        const auto sum = minkowski_sum(*region, cube_);
        if (!sum) return tl::unexpected(sum.error());
        const double margin = allowance(feature);
        // Facets of the region first: they end most tests.
        for (const bool of_region : {true, false}) {
            for (std::uint32_t f = 0; f < sum->facet_count(); ++f) {
                const FacetOrigin origin = sum->facet(f).origin;
                if ((origin == FacetOrigin::a || origin == FacetOrigin::both) != of_region)
                    continue;
                const Vec3 normal = sum->half_space(f).normal;
                const SumCorner& rest = sum->support(f);
                planes.push_back({normal, normal.dot(region->vertex(rest.a)) + margin,
                                  normal.dot(cube_.vertex(rest.b))});
            }
        }
        return {};
    }

private:
    [[nodiscard]] bool is_listed(Feature feature) const
    {
        switch (feature.kind) {
        case FeatureKind::vertex:
            return !topology_.triangles(VertexId{feature.id}).empty();
        case FeatureKind::edge:
            return surface_.folds[feature.id] == EdgeFold::ridge;
        case FeatureKind::face:
            break;
        }
        return true;
    }

    [[nodiscard]] std::vector<Vec3> normals_at(Feature feature) const
    {
        std::vector<Vec3> normals;
        const auto add = [&](std::span<const TriangleId> triangles) {
            for (const TriangleId triangle : triangles)
                normals.push_back(surface_.normals[to_index(triangle)]);
        };
        switch (feature.kind) {
        case FeatureKind::vertex:
            add(topology_.triangles(VertexId{feature.id}));
            break;
        case FeatureKind::edge:
            add(topology_.triangles(EdgeId{feature.id}));
            break;
        case FeatureKind::face:
            add(std::array{TriangleId{feature.id}});
            break;
        }
        return normals;
    }

    [[nodiscard]] Result<ConvexPolyhedron> region_of(Feature feature) const
    {
        switch (feature.kind) {
        case FeatureKind::vertex:
            return voronoi_region_of_vertex(mesh_.position(VertexId{feature.id}),
                                            normals_at(feature));
        case FeatureKind::edge: {
            const auto [p, q] = topology_.vertices(EdgeId{feature.id});
            const auto normals = normals_at(feature);
            return voronoi_region_of_edge(mesh_.position(p), mesh_.position(q), normals[0],
                                          normals[1]);
        }
        case FeatureKind::face:
            break;
        }
        return voronoi_region_of_face(mesh_.triangle(TriangleId{feature.id}));
    }

    /// How far outside a plane a cell's centre may be and still count as in it.
    [[nodiscard]] double allowance(Feature feature) const
    {
        const double rounding = plane_allowance + ray_allowance / lead(feature);
        return rounding * reach_ + flat_reach(feature);
    }

    /// The k of the note above: for z the mean of the normals, or away from the inside, whichever
    /// is better.
    [[nodiscard]] double lead(Feature feature) const
    {
        const std::vector<Vec3> normals = normals_at(feature);
        Vec3 mean = Vec3::Zero();
        for (const Vec3& normal : normals) mean += normal;
        const auto least = [&](const Vec3& direction) {
            const Vec3 unit = unit_of(direction);
            double product = 1;
            for (const Vec3& normal : normals) product = std::min(product, normal.dot(unit));
            return product;
        };
        const Vec3 outward = position_of(feature) - surface_.inner_point;
        // Behind its planes strictly, the inside leads outward; rounding may hide how little.
        return std::max({least(mean), least(outward), half_ulp});
    }

    [[nodiscard]] Vec3 position_of(Feature feature) const
    {
        switch (feature.kind) {
        case FeatureKind::vertex:
            return mesh_.position(VertexId{feature.id});
        case FeatureKind::edge:
            return mesh_.position(topology_.vertices(EdgeId{feature.id})[0]);
        case FeatureKind::face:
            break;
        }
        return mesh_.triangle(TriangleId{feature.id})[0];
    }

    /// How far the regions of a face's flat edges, which are not listed, reach out of its own
    /// within the root.
    [[nodiscard]] double flat_reach(Feature feature) const
    {
        if (feature.kind != FeatureKind::face) return 0;
        double sine = 0;
        for (const EdgeId edge : topology_.edges(TriangleId{feature.id})) {
            if (surface_.folds[to_index(edge)] != EdgeFold::flat) continue;
            const auto sides = topology_.triangles(edge);
            sine = std::max(sine, sine_between(surface_.normals[to_index(sides[0])],
                                               surface_.normals[to_index(sides[1])]));
        }
        if (sine == 0) return 0;
        // More than rounding of the sine, of the sine for the angle, and of this product.
        return 1.01 * diagonal_ * (sine + 16 * half_ulp);
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    const ConvexSurface& surface_;
    FeatureNumbers numbers_;
    ConvexPolyhedron cube_;
    double reach_;
    double diagonal_;
};

/// The planes of one task's features.
struct RegionBlock {
    std::vector<GrowingPlane> planes;
    std::vector<std::uint32_t> counts; ///< by feature of the block
    std::optional<Error> error;
};

} // namespace

Result<GrownRegions> grow_regions(const TriangleMesh& mesh, const Topology& topology,
                                  const ConvexSurface& surface, const OctreeFrame& root,
                                  const GrownRegionsOptions& options)
{
    const RegionGrower grower(mesh, topology, surface, root);
    const std::size_t features = FeatureNumbers(topology).count();
    std::vector<RegionBlock> blocks(chunk_count(features, block));
    const std::uint64_t limit = budget_bytes(options.execution.budget);
    std::atomic<std::uint64_t> used{0};
    begin_stage(options.execution.progress, "Voronoi regions", features);
    parallel_chunks(
        features, block, options.execution.threads, [&](std::size_t first, std::size_t end) {
            RegionBlock& output = blocks[first / block];
            for (std::size_t number = first; number < end && !output.error; ++number) {
                if (is_cancelled(options.execution.progress) ||
                    used.load(std::memory_order_relaxed) > limit)
                    return;
                const std::size_t before = output.planes.size();
                const Status status =
                    grower.append(static_cast<std::uint32_t>(number), output.planes);
                if (!status) output.error = status.error();
                output.counts.push_back(static_cast<std::uint32_t>(output.planes.size() - before));
                // In the block, and again in the result.
                used += 2 * (output.planes.size() - before) * sizeof(GrowingPlane);
            }
            advance_stage(options.execution.progress, end - first);
        });
    if (is_cancelled(options.execution.progress)) {
        return cancelled("building the proximity octree");
    }
    if (Status status = check_budget(options.execution.budget, used, "the Voronoi regions",
                                     "raise the budget or take a mesh of fewer triangles");
        !status)
        return tl::unexpected(status.error());

    GrownRegions regions;
    regions.first_.reserve(features + 1);
    regions.first_.push_back(0);
    regions.planes_.reserve(used / (2 * sizeof(GrowingPlane)));
    for (RegionBlock& finished : blocks) {
        if (finished.error) return tl::unexpected(*finished.error);
        for (const std::uint32_t count : finished.counts)
            regions.first_.push_back(regions.first_.back() + count);
        regions.planes_.insert(regions.planes_.end(), finished.planes.begin(),
                               finished.planes.end());
        finished = {};
    }
    return regions;
}

} // namespace proxima
