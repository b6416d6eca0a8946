// The words of a mesh report: how bad each finding is, what it means, what still works. Internal.
#pragma once

#include "proxima/mesh_report.h"

namespace proxima::detail {

/// The words of a kind; empty for the kinds whose words depend on measured values: non-finite
/// positions, scale, distance from the origin, and inward components.
[[nodiscard]] Severity usual_severity(FindingKind kind) noexcept;
[[nodiscard]] std::string usual_meaning(FindingKind kind);

// Products of three lengths between these stay in the range of doubles.
inline constexpr double smallest_safe_extent = 1e-100;
inline constexpr double largest_safe_coordinate = 1e100; // beyond it octrees are refused

/// The largest magnitude of a coordinate.
[[nodiscard]] double reach_of(const Box& box) noexcept;

/// What each query can do, from the findings and properties already in the report. `counts_twice`:
/// winding numbers count the triangles of some place more than once, whatever faces them.
[[nodiscard]] std::vector<QueryOutlook> outlook_of(const MeshReport& report, bool counts_twice);

} // namespace proxima::detail
