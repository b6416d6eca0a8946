// Searches of a surface through its triangle tree: exact, quick enough, and of little memory.
//
//     const auto search = build_surface_search(mesh, topology);    // once, refers to both
//     const ClosestFeature closest = closest_feature(*search, p);  // a microsecond or two
//
// Every answer is the one of brute_force.h, bit for bit. Queries are noexcept, do not allocate, and
// may run on any number of threads.
#pragma once

#include "index/triangle_tree.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "query/closest/closest_feature.h"
#include "query/closest/feature_distance.h"

#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// A surface and the tree over its triangles in Hilbert order. Refers to mesh and topology, which
/// must outlive it. Immutable.
class SurfaceSearch {
public:
    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return *mesh_; }
    [[nodiscard]] const Topology& topology() const noexcept { return *topology_; }
    [[nodiscard]] const TriangleTree& tree() const noexcept { return tree_; }

    /// Triangles by rank.
    [[nodiscard]] std::span<const TriangleId> order() const noexcept { return order_; }
    [[nodiscard]] std::span<const TriangleId> triangles(RankRange ranks) const noexcept
    {
        return order().subspan(ranks.first, ranks.count);
    }

    /// Without mesh and topology: 7.5 per triangle.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return tree_.bytes() + order_.size() * sizeof(TriangleId);
    }

private:
    friend Result<SurfaceSearch> build_surface_search(const TriangleMesh& mesh,
                                                      const Topology& topology,
                                                      const TriangleTreeOptions& options);
    const TriangleMesh* mesh_ = nullptr;
    const Topology* topology_ = nullptr;
    std::vector<TriangleId> order_;
    TriangleTree tree_;
};

/// Sorts the triangles and builds their tree. Errors: those of build_triangle_tree, and
/// invalid_mesh where the mesh is less than 1e-140 large. O(triangles), about 0.1 us each. \pre
/// topology is the mesh's
[[nodiscard]] Result<SurfaceSearch> build_surface_search(const TriangleMesh& mesh,
                                                         const Topology& topology,
                                                         const TriangleTreeOptions& options = {});

/// Lowers `best` to the closest feature where that comes before it. Start with what is known, a
/// squared radius or the last answer's feature and its distance from p; the nearer, the quicker.
/// \pre p is finite. Points more than 2^40 times the mesh's size away may take O(triangles).
void find_closest(const SurfaceSearch& search, const Vec3& p, NearestFeature& best) noexcept;

/// The closest feature; no_closest_feature() where p is not finite.
[[nodiscard]] ClosestFeature closest_feature(const SurfaceSearch& search, const Vec3& p) noexcept;

/// The closest feature if its squared distance, as computed, is at most radius^2; nothing also
/// where p is not finite, or the radius NaN or below 0.
[[nodiscard]] std::optional<ClosestFeature> closest_feature(const SurfaceSearch& search,
                                                            const Vec3& p, double radius) noexcept;

} // namespace proxima
