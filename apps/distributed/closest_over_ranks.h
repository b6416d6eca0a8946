// Closest features of a mesh that is spread over the ranks: those that one process finds, bit for bit.
//
//     first    each point is asked of the rank whose box is nearest: its answer is a bound
//     then     of all ranks whose boxes are no farther than that; the best answer wins
#pragma once

#include "distributed/mesh_part.h"
#include "distributed/world.h"
#include "proxima/topology.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

namespace proxima {

/// A closest feature, by its names in the whole mesh.
struct ClosestOfWhole {
    double squared = std::numeric_limits<double>::infinity(); ///< in units of the frame
    std::uint64_t feature = std::numeric_limits<std::uint64_t>::max();
    std::uint64_t triangle = 0;
    std::array<double, 3> point = {};
    std::uint32_t kind = no_kind;
    std::uint32_t is_on_feature = 0; ///< whether the point is on it, exactly

    static constexpr std::uint32_t no_kind = 3; ///< behind all kinds: nothing was found

    /// The order of answers, as closest_feature.h has it.
    [[nodiscard]] bool before(const ClosestOfWhole& other) const noexcept
    {
        return std::tie(squared, kind, feature) <
               std::tie(other.squared, other.kind, other.feature);
    }
    /// In the mesh's unit.
    [[nodiscard]] double distance(double scale) const noexcept;
};

/// The closest features of this rank's points, which are finite. Collective.
[[nodiscard]] Result<std::vector<ClosestOfWhole>>
closest_over_ranks(const MeshPart& part, std::span<const Vec3> points, World& world);

} // namespace proxima
