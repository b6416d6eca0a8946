// What a SurfaceSign holds, and how it is built of a mesh and a topology that are there already.
#pragma once

#include "octree/winding_number.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/signed_distance.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "query/closest/surface_sides.h"

#include <memory>
#include <span>
#include <vector>

namespace proxima {

/// What a surface is known of. Immutable. Keeps mesh and topology alive, or refers to those of its
/// maker: as the pointers given to the builder do.
class SignParts {
public:
    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return winding_.mesh(); }
    [[nodiscard]] const Topology& topology() const noexcept { return *topology_; }
    [[nodiscard]] const WindingNumber& winding() const noexcept { return winding_; }

    /// By triangle id. The closest point in a face tells by these.
    [[nodiscard]] std::span<const SurfaceSides> sides() const noexcept { return sides_; }

    /// By vertex id: the sides that all its triangles agree on, else doubtful.
    [[nodiscard]] std::span<const SurfaceSides> vertex_sides() const noexcept
    {
        return vertex_sides_;
    }

    /// By vertex id, of length 1 where the vertex separates: the sum of the normals of its
    /// triangles, weighted by their angles. Empty where no triangle separates.
    [[nodiscard]] std::span<const Vec3> pseudonormals() const noexcept { return pseudonormals_; }

    /// Of the mesh where it is known to be closed: all beyond is outside. Else endless.
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }

    /// The least height of the triangles whose sides are known: points near for that are told
    /// without a look at the closest one's.
    [[nodiscard]] double least_height() const noexcept { return least_height_; }

private:
    friend class SurfaceSignBuilder;

    std::shared_ptr<const TriangleMesh> mesh_; ///< that the winding number refers to
    std::shared_ptr<const Topology> topology_;
    WindingNumber winding_;
    std::vector<SurfaceSides> sides_;
    std::vector<SurfaceSides> vertex_sides_;
    std::vector<Vec3> pseudonormals_;
    Box bounds_;
    double least_height_ = 0;
};

/// As the public one, without building mesh and topology again: refers to both, which must outlive
/// the sign. The index is needed here only. \pre all are of one mesh
[[nodiscard]] Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh,
                                                     const Topology& topology,
                                                     const MeshIndex& index,
                                                     const SurfaceSignOptions& options = {});

/// The same, with an index of its own for the time of the build.
[[nodiscard]] Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh,
                                                     const Topology& topology,
                                                     const SurfaceSignOptions& options = {});

} // namespace proxima
