// Where a simulated hand wants to go: motions that try a surface, seeded.
//
//     press   down onto places, and up again          corner  from outside into dents and corners
//     slide   from place to place, pressing           poke    fast through the surface and back
//     stroke  across edges, to and fro                walk    at random about the surface
//
// Places are of the device, in metres: the hand is pulled there by its spring, and what it meets on
// the way is what is tried.
#pragma once

#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace proxima {

/// "press, slide, stroke, corner, poke, walk".
[[nodiscard]] std::string_view hand_script_names() noexcept;

/// Whether there is a script of this name.
[[nodiscard]] bool is_hand_script(std::string_view name) noexcept;

/// A path through places at times, smooth in between, round and round.
class HandScript {
public:
    /// A script for a model. The same for the same seed. Of several objects in one mesh, `parts`
    /// are their first triangles, ascending from 0: places are of each in turn. Errors:
    /// invalid_argument (no such script: which there are), invalid_mesh (no triangle has an area).
    /// O(triangles).
    [[nodiscard]] static Result<HandScript> make(std::string_view name, const TriangleMesh& mesh,
                                                 const Topology& topology, const WorkspaceMap& map,
                                                 std::uint64_t seed,
                                                 std::span<const std::uint32_t> parts = {});

    /// Where the hand wants to be. noexcept, no allocation. \pre seconds >= 0
    [[nodiscard]] Vec3 target(double seconds) const noexcept;

    /// Until it begins again.
    [[nodiscard]] double period() const noexcept { return stops_.back().seconds; }

private:
    friend class ScriptWriter;
    struct Stop {
        double seconds = 0;
        Vec3 place = Vec3::Zero();
    };
    std::vector<Stop> stops_; ///< at least two, times ascending from 0
};

} // namespace proxima
