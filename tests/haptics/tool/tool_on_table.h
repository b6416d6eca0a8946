// Numbers of the tests of tools on a table: those of plain_springs() and of a box of 20 mm.
#pragma once

#include "haptics/tool/tool_bench.h"

namespace proxima::testing::tool_on_table {

inline constexpr double clearance = 1e-5;
inline constexpr double stiffness = 500; // N/m
inline constexpr double torsional = 0.5; // N m/rad
inline constexpr double half = 0.01;     // of the box, m
inline constexpr double settled = 2e-8;  // m: how near a proxy at rest is to its closed form
inline constexpr double force_error = stiffness * settled;

inline TriangleMesh table()
{
    return box_mesh({0.1, 0.1, 0.05}, {0, 0, -0.05}); // its top is z = 0
}

} // namespace proxima::testing::tool_on_table
