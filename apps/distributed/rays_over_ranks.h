// First hits of rays with a mesh that is spread over the ranks: those of one process, bit for bit.
//
//     rank      of those whose boxes a ray meets, the one that it enters first is asked first
//     rounds    then twice as many in each round, until none that is left is entered before the best
//               hit so far
#pragma once

#include "distributed/mesh_part.h"
#include "distributed/world.h"

#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

namespace proxima {

/// A hit, by the triangle's id in the whole mesh.
struct HitOfWhole {
    double t = std::numeric_limits<double>::infinity(); ///< infinite for a miss
    std::uint64_t triangle = std::numeric_limits<std::uint64_t>::max();
    double u = 0;
    double v = 0;

    [[nodiscard]] bool is_hit() const noexcept
    {
        return t < std::numeric_limits<double>::infinity();
    }
    /// The order of hits, as cast_ray.h has it.
    [[nodiscard]] bool before(const HitOfWhole& other) const noexcept
    {
        return std::tie(t, triangle) < std::tie(other.t, other.triangle);
    }
};

/// The first hits of this rank's rays, which are valid. Collective.
[[nodiscard]] Result<std::vector<HitOfWhole>>
hits_over_ranks(const MeshPart& part, std::span<const Ray> rays, World& world);

} // namespace proxima
