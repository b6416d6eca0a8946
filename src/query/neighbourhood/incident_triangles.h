// The triangles that share a feature.
#pragma once

#include "proxima/topology.h"

#include <span>

namespace proxima {

/// The triangles at a feature by topology, ids ascending: of a face itself, which `face` has to
/// name and outlive the answer.
[[nodiscard]] std::span<const TriangleId> incident_triangles(const Topology& topology,
                                                             const Feature& feature,
                                                             const TriangleId& face) noexcept;

} // namespace proxima
