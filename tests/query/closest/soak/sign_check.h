// Signs of distances against the truth: on closed meshes the winding number, counted along a line
// by exact determinants; on others the sum of all solid angles.
#pragma once

#include "oracles/column_winding.h"
#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace proxima::soak {

struct SignTally {
    std::uint64_t points = 0; ///< with a sign to compare
    std::uint64_t wrong = 0;
    std::uint64_t inside = 0;
    std::uint64_t undecided = 0; ///< within rounding of the surface, or of a winding number of 1/2
    std::string first_wrong;

    void add(const SignTally& other);
};

/// Refers to what it is given. check() may be called from any thread.
class SignCheck {
public:
    /// \pre the index is of the mesh, with signs; `closed` tells whether every edge has as many
    /// triangles in one way as in the other
    SignCheck(const TriangleMesh& mesh, const MeshIndex& index, bool closed);

    [[nodiscard]] SignTally check(std::span<const Vec3> points) const;

private:
    [[nodiscard]] std::optional<bool> is_inside(const Vec3& p) const;

    const TriangleMesh& mesh_;
    const MeshIndex& index_;
    std::optional<oracle::ColumnWinding> columns_;
    double size_ = 0;
};

} // namespace proxima::soak
