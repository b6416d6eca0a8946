// The index of a part of a mesh whose other parts lie elsewhere, in other processes.
//
//     index_frame(box of the whole)     distances of all parts in one unit: they compare bit for bit
//     edges numbered as in the whole    ties between a part's edges go as they go in the whole
//
// Where vertices, edges and triangles have the order that they have in the whole mesh, the best of
// the parts' answers is that of the whole mesh's index.
#pragma once

#include "index/binary_tree.h"
#include "mesh/edge_numbers.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// Like build_mesh_index, in the frame of the whole mesh, with edges that the caller numbered from 0
/// on. \pre the frame is that of a box that contains the part; `edges` has the sides of the part,
/// each edge's first side being its lowest
[[nodiscard]] Result<MeshIndex> build_part_index(const TriangleMesh& part, const IndexFrame& frame,
                                                 const EdgeNumbers& edges,
                                                 const MeshIndexOptions& options = {});

} // namespace proxima
