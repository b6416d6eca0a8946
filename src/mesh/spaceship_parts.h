// The drawing of the built-in ship: its parts as stacks of cross-sections. Internal.
//
//     sections    0   1   2  3         a part is lofted through its sections, in straight lines,
//     across ^   |\__/     \_|         and closed by a flat cap at either end; where `along` turns
//            |   |/  \_____/ |         back, as in a nozzle, the surface folds inwards
//            +-----> along
//
// x is forward, y to port, z up. Sizes in ship units: the hull is 4 long.
#pragma once

#include "proxima/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

enum class Outline : std::uint8_t { round, chamfered, box };

/// Which way a part is lofted.
enum class Direction : std::uint8_t { forward, to_port, to_starboard, up };

struct Section {
    double along = 0.0;
    double across = 0.0; ///< centre, in the section's plane
    double lift = 0.0;
    double half_across = 0.0;
    double half_lift = 0.0;
};

struct ShipPart {
    std::span<const Section> sections;
    Direction direction = Direction::forward;
    Vec3 origin = Vec3::Zero();
    std::uint32_t segments = 8; ///< round a section, at level 1; a multiple of 4
    Outline outline = Outline::round;
    double detail = 0.0; ///< how much plating grows on it, 0 for none
};

/// All parts of the ship.
[[nodiscard]] std::vector<ShipPart> ship_parts();

} // namespace proxima::detail
