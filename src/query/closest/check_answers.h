// Whether an index's closest features are right: the part of its invariants that needs its mesh.
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <span>
#include <string>

namespace proxima {

/// What was found, for messages: "face 7 of triangle 7 at 0.25". \pre it is an answer
[[nodiscard]] std::string text_of(const ClosestFeature& answer);

struct CheckAnswersOptions {
    Execution execution = {}; ///< stage "asking every triangle", steps are points
};

/// Asks the index and every triangle for the feature closest to each point: it must be the same,
/// or another one as close, up to rounding: 1e-12 of the mesh's diagonal and the point's distance
/// from its middle, 1e-15 of its largest coordinate. Errors: broken_invariant, naming the first
/// point that has another answer and both of them; cancelled. The same for any number of threads.
/// O(points * features), about 5 ns each. \pre points are finite; the topology is the mesh's, the
/// mesh has a triangle and is the index's (check_same_mesh, or mesh_of it and check_edges)
[[nodiscard]] Status check_answers(const MeshIndex& index, const TriangleMesh& mesh,
                                   const Topology& topology, std::span<const Vec3> points,
                                   const CheckAnswersOptions& options = {});

} // namespace proxima
