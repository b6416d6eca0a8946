// What an Enclosure holds.
#pragma once

#include "octree/winding_number.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/triangle_mesh.h"

#include <optional>
#include <vector>

namespace proxima {

/// Stays where it was made: the winding number refers to the mesh.
struct EnclosureParts {
    explicit EnclosureParts(TriangleMesh own) : mesh(std::move(own)) {}
    EnclosureParts(const EnclosureParts&) = delete;
    EnclosureParts& operator=(const EnclosureParts&) = delete;

    const TriangleMesh mesh;
    Box bounds;
    InsideMethod method = InsideMethod::crossings;
    std::vector<VertexId> vertices;       ///< the lowest of every connected part, ascending
    std::optional<WindingNumber> winding; ///< for open meshes only
};

} // namespace proxima
