// How long the lists of leaves are: thesis figure 5.3.
//
//     std::vector<std::uint32_t> lengths = outer_list_lengths(octree, circumscribed_sphere(mesh));
//     const ListStatistics statistics = list_statistics(lengths);
//     statistics.mean; statistics.share_up_to(16); statistics.weights[5];   // lists of 5 features
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

class ProximityLists;
class ThesisProximityOctree;

/// A histogram of lengths and what it says.
struct ListStatistics {
    std::uint64_t cells = 0;
    double total_weight = 0;
    double mean = 0; ///< weighted; 0 without cells
    std::uint32_t max = 0;
    std::vector<double> weights; ///< by length, from 0 to the longest; empty without cells

    /// The part of the weight that is of lists no longer than this, 0 to 1; 0 without cells.
    [[nodiscard]] double share_up_to(std::uint32_t length) const noexcept;
};

/// Counts lengths, each with its weight (a cell's volume, or how often it is met), or 1 where there
/// are no weights. Sums go in the order given. O(cells + longest).
/// \pre as many weights as lengths, or none; weights are finite and not negative
[[nodiscard]] ListStatistics list_statistics(std::span<const std::uint32_t> lengths,
                                             std::span<const double> weights = {});

/// A sphere about a mesh: cells outside of it are surely outside of the mesh.
struct MeshSphere {
    Vec3 center = Vec3::Zero();
    double squared_radius = 0;

    /// Whether the closed box has no point inside the sphere, up to rounding.
    [[nodiscard]] bool is_outside(const Box& box) const noexcept
    {
        return (center.cwiseMax(box.lower).cwiseMin(box.upper) - center).squaredNorm() >=
               squared_radius;
    }
};

/// About the centre of the bounding box, through the farthest vertex in use. O(triangles).
/// \pre the mesh has triangles, its coordinates are finite
[[nodiscard]] MeshSphere circumscribed_sphere(const TriangleMesh& mesh);

/// The lengths of the lists of the leaves outside the sphere, in Morton order.
[[nodiscard]] std::vector<std::uint32_t> outer_list_lengths(const ThesisProximityOctree& octree,
                                                            const MeshSphere& sphere);

/// The leaves of an octree: how many triangles each lists, and its part of the root's volume.
struct LeafLists {
    std::vector<std::uint32_t> lengths;
    std::vector<double> volumes; ///< powers of 1/8, sum 1
};

/// In Morton order: every leaf that the builder made, whatever level the table has. O(leaves), 12
/// bytes each. \pre the octree is sound, as built and read ones are
[[nodiscard]] LeafLists list_lengths(const ProximityLists& lists);

} // namespace proxima
