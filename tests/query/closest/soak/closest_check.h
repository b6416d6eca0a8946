// Answers of closest-feature lists against a search that shares only the arithmetic of rows with
// them.
//
// The truth is brute force on small meshes, the mesh index's tree on large ones (the same answers
// bit for bit; a few points are asked of brute force there too). Wrong is
//
//     a distance that is off by more than 1e-12 of the mesh's diagonal (of the query's own
//         distance where that is greater: far outside)
//     another feature, unless it is as close but for rounding: a tie that rounding decides
//     a triangle that is not the lowest of the feature, a closest point that is not there
//     a batch's answer, or that of lists within another budget, with other bits
//     more steps or blocks than the index says
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace proxima::soak {

/// What checks of many points found.
struct ClosestTally {
    std::uint64_t points = 0;
    std::uint64_t wrong = 0;
    std::uint64_t ties = 0;  ///< answered by another feature that is as close but for rounding
    std::uint64_t brute = 0; ///< points that brute force was asked
    double worst = 0;        ///< error of a distance, in diagonals
    double worst_steps = 0;  ///< part of the worst case that a query took
    double worst_blocks = 0; ///< the same of blocks
    std::string first_wrong; ///< what it was; empty without any

    void add(const ClosestTally& other);
};

/// A mesh and its index.
struct SoakSearch {
    const TriangleMesh& mesh;
    const Topology& topology;
    const MeshIndex& index;
};

/// Refers to what it is given. check() may be called from any thread.
class ClosestCheck {
public:
    ClosestCheck(const SoakSearch& search, std::span<const MeshIndex> indexes);

    [[nodiscard]] ClosestTally check(std::span<const Vec3> points) const;

private:
    [[nodiscard]] ClosestFeature truth_at(const Vec3& p, std::size_t place,
                                          ClosestTally& tally) const;
    [[nodiscard]] std::string problem(const ClosestFeature& found, const ClosestFeature& truth,
                                      const Vec3& p, ClosestTally& tally) const;
    [[nodiscard]] double exact_distance(const Feature& feature, const Vec3& p) const;

    SoakSearch search_;
    std::span<const MeshIndex> indexes_;
    Vec3 center_;
    double diagonal_ = 0;
    double largest_ = 0; ///< coordinate of the mesh
};

} // namespace proxima::soak
