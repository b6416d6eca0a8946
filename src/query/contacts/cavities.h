// Inner shells of a solid: components of its surface that face inward and bound cavities.
#pragma once

#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// Whether every component that faces inward bounds a cavity: it touches neither another component nor
/// itself, and the others wind round it at least once. Only single vertices may lie at one position: of
/// two such components, each of which has others of its own, or of one. Then the whole surface winds
/// round no point a negative number of times: on either side of such a component it does not, and only
/// its cavity's own components can change that farther in, upwards. Error invalid_mesh that names a triangle where one does not, cancelled. `mesh` is
/// that of the index. \pre closed and consistently oriented, every component has a volume
[[nodiscard]] Status check_cavities(const MeshIndex& index, const TriangleMesh& mesh,
                                    const Execution& execution);

} // namespace proxima
