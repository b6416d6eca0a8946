// Whether a glTF's geometry is stored in a way that assimp reads right, and how much there is of it,
// found out from its JSON: assimp takes numbers of other types for floats, passes over extensions that
// it does not know, and leaves out triangles whose vertices are not there.
#pragma once

#include "mesh/io/json_text.h"
#include "mesh/io/mesh_source.h"

#include <cstdint>
#include <vector>

namespace proxima::detail {

/// What a primitive has, from its accessors.
struct GltfPrimitive {
    std::uint64_t triangles = 0; ///< of lists, strips and fans; none of points and lines
    std::uint64_t vertices = 0;

    // NOLINTNEXTLINE(modernize-use-nullptr): of the defaulted comparison's own text
    friend auto operator<=>(const GltfPrimitive&, const GltfPrimitive&) = default;
};

/// Refuses versions of glTF other than 2, a required extension that changes geometry and is not read,
/// positions that are no float triples, indices that are no unsigned integers or, in Draco data, longer
/// than 16 bits, and lists of triangles that end within one. Returns the primitives of all meshes in increasing order.
/// Errors: malformed_file, unsupported_format. O(json), and sorting.
[[nodiscard]] Result<std::vector<GltfPrimitive>> check_gltf_geometry(const MeshSource& source,
                                                                     const JsonText& json);

} // namespace proxima::detail
