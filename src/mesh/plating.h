// Grows plates, boxes and grids on the quads of a closed surface until it has exactly as many
// triangles as asked for. Internal to the built-in ship.
//
//     plate  +-------+     box  the same with     grid  +-------+     pyramid  +-------+
//     (+8)   |\_____/|    (+16) upright walls           | +-+-+ |        (+2)  | \   / |
//            | |   | |          between rim             | +-+-+ |              |   x   |
//            |/_____\|          and top                 | +-+-+ |              | /   \ |
//            +-------+                                  +-------+              +-------+
//
// None of them touches a quad's own four edges, so the surface stays closed.
#pragma once

#include "base/progress.h"
#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima::detail {

/// Counter-clockwise corners; plating grows on it where `detail` > 0, the more the larger it is.
struct Quad {
    std::array<std::uint32_t, 4> corners{};
    double detail = 0.0;
};

/// A surface of quads and triangles, as it grows.
struct QuadSurface {
    std::vector<Vec3> positions;
    std::vector<Quad> quads;
    std::vector<TriangleCorners> triangles;

    [[nodiscard]] std::size_t triangle_count() const noexcept
    {
        return triangles.size() + 2 * quads.size();
    }
};

/// Pseudo-random numbers that follow from their seed alone (splitmix64), on every machine.
class Dice {
public:
    explicit Dice(std::uint64_t seed) noexcept : state_(seed) {}

    [[nodiscard]] std::uint64_t next() noexcept
    {
        state_ += 0x9E3779B97F4A7C15U;
        std::uint64_t bits = state_;
        bits = (bits ^ bits >> 30U) * 0xBF58476D1CE4E5B9U;
        bits = (bits ^ bits >> 27U) * 0x94D049BB133111EBU;
        return bits ^ bits >> 31U;
    }

    /// In [low, high).
    [[nodiscard]] double between(double low, double high) noexcept
    {
        return low + (high - low) * (static_cast<double>(next() >> 11U) * 0x1p-53);
    }

private:
    std::uint64_t state_;
};

/// Grows the surface to exactly `triangles` triangles, largest weighted quads first; a step each.
/// False where `steps` asks to stop.
/// \pre triangles >= surface.triangle_count(), an even number of steps away; some detail > 0
[[nodiscard]] bool grow_plating(QuadSurface& surface, std::size_t triangles, Dice dice,
                                StageSteps& steps);

} // namespace proxima::detail
