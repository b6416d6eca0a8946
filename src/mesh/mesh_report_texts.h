// The words of a mesh report: how bad each finding is, what it means, what still works. Internal.
#pragma once

#include "proxima/mesh_report.h"

namespace proxima::detail {

/// The words of a kind; empty for the kinds whose words depend on measured values: non-finite
/// positions, scale, distance from the origin, and inward components.
[[nodiscard]] Severity usual_severity(FindingKind kind) noexcept;
[[nodiscard]] std::string usual_meaning(FindingKind kind);

/// What each query can do, from the findings and properties already in the report.
[[nodiscard]] std::vector<QueryOutlook> outlook_of(const MeshReport& report);

} // namespace proxima::detail
