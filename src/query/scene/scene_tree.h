// The tree of a scene about the boxes of its rows.
#pragma once

#include "index/index_parts.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "query/scene/scene_parts.h"

#include <cstdint>
#include <memory>
#include <span>

namespace proxima {

/// Makes a scene's tree: the blocks of `order` as they are, but with the boxes of nodes drawn about those of the
/// scene's first rows, as many as `order` has. Only blocks, ids and the frame are there, which is what scenes ask
/// for: no triangles. The same bits for any number of threads; false where it was cancelled. 30 ns per row.
/// \pre order is not empty, scene.all holds all boxes
[[nodiscard]] bool draw_tree(SceneParts& scene, const IndexParts& order,
                             const Execution& execution);

/// Draws boxes again about rows that moved: the tree is as draw_tree makes it in this frame. O(rows and the blocks
/// above them). `tree` is memory that becomes the tree's: nothing is allocated. \pre the scene's parts are no one
/// else's, they have a tree, scene.all holds the rows' boxes, `tree` is no one else's and not null
void redraw_tree(SceneParts& scene, std::span<const std::uint32_t> rows,
                 std::shared_ptr<IndexParts> tree) noexcept;

/// A copy of a scene that shares its shapes, but not its tree.
[[nodiscard]] SceneParts copy_of(const SceneParts& scene);

} // namespace proxima
