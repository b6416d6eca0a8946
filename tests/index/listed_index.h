// The index of a mesh with closest-feature lists.
#pragma once

#include "index/lists/proximity_lists.h"
#include "proxima/mesh_index.h"

namespace proxima::testing {

/// Errors: those of build_mesh_index and with_lists.
[[nodiscard]] inline Result<MeshIndex> listed_index(const TriangleMesh& mesh,
                                                    const ListOptions& options = {})
{
    const auto index =
        build_mesh_index(mesh, {.execution = {.threads = options.execution.threads}});
    return index ? with_lists(*index, options) : index;
}

} // namespace proxima::testing
