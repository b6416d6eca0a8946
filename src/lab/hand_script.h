// Targets of a simulated hand: seeded motions that test a surface.
//
//     press   down onto points, and up again          corner  from outside into dents and corners
//     slide   from point to point, pressing           poke    fast through the surface and back
//     stroke  across edges, to and fro                walk    at random about the surface
//
// Targets are positions of the device, in metres. The hand's spring pulls it there, and the surface
// in between is what is tested.
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

/// A closed path through positions at given times, smooth in between.
class HandScript {
public:
    /// Makes a script for a model, the same for the same seed. `parts` are the first triangles of
    /// several objects in one mesh, ascending from 0, which are visited in turn. Errors:
    /// invalid_argument (no such script, with a list), invalid_mesh (no triangle has an area).
    /// O(triangles).
    [[nodiscard]] static Result<HandScript> make(std::string_view name, const TriangleMesh& mesh,
                                                 const Topology& topology, const WorkspaceMap& map,
                                                 std::uint64_t seed,
                                                 std::span<const std::uint32_t> parts = {});

    /// The target at a time. noexcept, no allocation. \pre seconds >= 0
    [[nodiscard]] Vec3 target(double seconds) const noexcept;

    /// The time until it repeats, s.
    [[nodiscard]] double period() const noexcept { return stops_.back().seconds; }

private:
    friend class ScriptWriter;
    struct Stop {
        double seconds = 0;
        Vec3 position = Vec3::Zero();
    };
    std::vector<Stop> stops_; ///< at least two, times ascending from 0
};

} // namespace proxima
