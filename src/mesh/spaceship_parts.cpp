#include "mesh/spaceship_parts.h"

#include <array>

namespace proxima::detail {

namespace {

// Columns: along, across, lift, half across, half lift.

constexpr std::array<Section, 9> hull = {{{-1.80, 0.0, 0.020, 0.36, 0.15},
                                          {-1.70, 0.0, 0.020, 0.45, 0.21},
                                          {-1.10, 0.0, 0.025, 0.54, 0.25},
                                          {-0.30, 0.0, 0.025, 0.50, 0.24},
                                          {0.30, 0.0, 0.010, 0.40, 0.19},
                                          {1.00, 0.0, -0.020, 0.29, 0.13},
                                          {1.60, 0.0, -0.045, 0.18, 0.08},
                                          {2.05, 0.0, -0.060, 0.09, 0.04},
                                          {2.20, 0.0, -0.065, 0.03, 0.015}}};

constexpr std::array<Section, 5> deck = {{{0.10, -0.75, 0.0, 0.80, 0.30},
                                          {0.31, -0.80, 0.0, 0.64, 0.23},
                                          {0.33, -0.82, 0.0, 0.56, 0.19},
                                          {0.43, -0.86, 0.0, 0.45, 0.15},
                                          {0.45, -0.88, 0.0, 0.38, 0.12}}};

constexpr std::array<Section, 5> bridge = {{{0.40, -0.95, 0.0, 0.17, 0.10},
                                            {0.60, -1.00, 0.0, 0.11, 0.08},
                                            {0.63, -1.00, 0.0, 0.14, 0.30},
                                            {0.72, -1.01, 0.0, 0.12, 0.28},
                                            {0.75, -1.03, 0.0, 0.06, 0.20}}};

// Along the span; across is forward, so the centres move back with the sweep.
constexpr std::array<Section, 6> wing = {{{0.30, -0.60, 0.000, 0.85, 0.075},
                                          {0.60, -0.78, -0.015, 0.66, 0.060},
                                          {1.00, -1.02, -0.060, 0.46, 0.045},
                                          {1.40, -1.26, -0.125, 0.28, 0.030},
                                          {1.52, -1.34, -0.150, 0.21, 0.020},
                                          {1.55, -1.38, -0.155, 0.14, 0.006}}};

constexpr std::array<Section, 7> cannon = {{{-0.42, 0.0, 0.0, 0.030, 0.030},
                                            {-0.36, 0.0, 0.0, 0.065, 0.065},
                                            {0.36, 0.0, 0.0, 0.060, 0.060},
                                            {0.42, 0.0, 0.0, 0.028, 0.028},
                                            {1.42, 0.0, 0.0, 0.020, 0.020},
                                            {1.44, 0.0, 0.0, 0.032, 0.032},
                                            {1.54, 0.0, 0.0, 0.032, 0.032}}};

// From the bottom of the nozzle back to its lip, then forward along the outside.
constexpr std::array<Section, 9> engine = {{{-1.60, 0.0, 0.0, 0.09, 0.09},
                                            {-1.98, 0.0, 0.0, 0.17, 0.17},
                                            {-2.00, 0.0, 0.0, 0.19, 0.19},
                                            {-1.72, 0.0, 0.0, 0.18, 0.18},
                                            {-1.66, 0.0, 0.0, 0.23, 0.23},
                                            {-0.75, 0.0, 0.0, 0.24, 0.24},
                                            {-0.50, 0.0, 0.0, 0.20, 0.20},
                                            {-0.40, 0.0, 0.0, 0.12, 0.12},
                                            {-0.30, 0.0, 0.0, 0.04, 0.04}}};

constexpr std::array<Section, 4> thruster = {{{-1.76, 0.0, 0.0, 0.04, 0.04},
                                              {-2.04, 0.0, 0.0, 0.11, 0.11},
                                              {-2.06, 0.0, 0.0, 0.13, 0.13},
                                              {-1.70, 0.0, 0.0, 0.08, 0.08}}};

constexpr std::array<Section, 4> fin = {{{0.20, -1.30, 0.00, 0.42, 0.035},
                                         {0.60, -1.52, 0.06, 0.26, 0.025},
                                         {0.95, -1.72, 0.12, 0.13, 0.015},
                                         {0.98, -1.75, 0.125, 0.09, 0.006}}};

constexpr std::array<Section, 4> mirrored_fin = {{{0.20, -1.30, 0.00, 0.42, 0.035},
                                                  {0.60, -1.52, -0.06, 0.26, 0.025},
                                                  {0.95, -1.72, -0.12, 0.13, 0.015},
                                                  {0.98, -1.75, -0.125, 0.09, 0.006}}};

constexpr std::array<Section, 2> antenna = {
    {{0.70, 0.0, 0.0, 0.010, 0.010}, {1.10, 0.0, 0.0, 0.002, 0.002}}};

} // namespace

std::vector<ShipPart> ship_parts()
{
    using enum Direction;
    using enum Outline;
    std::vector<ShipPart> parts = {
        {hull, forward, Vec3::Zero(), 12, chamfered, 1.0},
        {deck, up, Vec3::Zero(), 8, box, 1.5},
        {bridge, up, Vec3::Zero(), 8, chamfered, 2.0},
        {wing, to_port, Vec3::Zero(), 8, round, 0.25},
        {wing, to_starboard, Vec3::Zero(), 8, round, 0.25},
        {fin, up, Vec3(0.0, 0.70, 0.0), 4, round, 0.2},
        {mirrored_fin, up, Vec3(0.0, -0.70, 0.0), 4, round, 0.2},
        {thruster, forward, Vec3(0.0, 0.0, 0.03), 8, round, 0.0},
        {antenna, up, Vec3(-1.03, 0.0, 0.0), 4, round, 0.0},
    };
    for (const double side : {1.0, -1.0}) {
        parts.push_back({engine, forward, Vec3(0.0, 0.70 * side, 0.02), 8, round, 0.5});
        parts.push_back({cannon, forward, Vec3(-1.30, 1.52 * side, -0.15), 4, chamfered, 0.1});
        parts.push_back({thruster, forward, Vec3(0.0, 0.23 * side, 0.03), 8, round, 0.0});
        parts.push_back({antenna, up, Vec3(-1.01, 0.22 * side, -0.02), 4, round, 0.0});
    }
    return parts;
}

} // namespace proxima::detail
