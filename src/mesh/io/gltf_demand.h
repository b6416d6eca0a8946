// What a glTF would make assimp allocate, found out from its JSON before assimp reads it: a few
// hundred bytes can ask for any amount of memory, or for recursion deeper than the stack.
#pragma once

#include "mesh/io/gltf_geometry.h"
#include "mesh/io/mesh_source.h"

#include <string_view>
#include <vector>

namespace proxima::detail {

/// Refuses a glTF whose scene needs more than the budget, by an estimate from above, or
/// whose nodes lie too deep in each other, or whose geometry is stored in a way that would be read
/// wrong (gltf_geometry.h, which tells of the primitives). `json` is a part of source.text.
/// Errors: malformed_file, unsupported_format, limit_exceeded, budget_exceeded. O(json).
[[nodiscard]] Result<std::vector<GltfPrimitive>>
check_gltf_demand(const MeshSource& source, std::string_view json, MemoryBudget budget);

} // namespace proxima::detail
