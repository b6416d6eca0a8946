// The words of a mesh report: how bad each finding is, what it means, what still works. Internal.
#pragma once

#include "proxima/mesh/mesh_report.h"

namespace proxima::detail {

/// \pre kind is not one of the kinds about the whole mesh or its positions, whose words depend on
/// measured values
[[nodiscard]] Severity usual_severity(FindingKind kind) noexcept;
[[nodiscard]] std::string usual_meaning(FindingKind kind);

/// What each query can do, from the findings and properties already in the report.
[[nodiscard]] std::vector<QueryOutlook> outlook_of(const MeshReport& report);

} // namespace proxima::detail
