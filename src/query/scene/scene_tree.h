// The tree of a scene about the boxes of its rows.
#pragma once

#include "index/index_parts.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "query/scene/scene_parts.h"

#include <optional>
#include <span>

namespace proxima {

/// The blocks of `order` as they are, but with the boxes of nodes drawn about those of `rows`, the first rows of a scene.
/// Only blocks, ids and the frame are there, which is what scenes ask for: no triangles. `all` holds all boxes. The same
/// bits for any number of threads; nothing where it was cancelled. 30 ns per row. \pre order is not empty
[[nodiscard]] std::optional<MeshIndex> tree_about(const IndexParts& order,
                                                  std::span<const SceneRow> rows, const Box& all,
                                                  const Execution& execution);

} // namespace proxima
