// Distances with a sign: negative inside, where the winding number is at least 1/2.
//
//     const auto sign = build_surface_sign(mesh, topology, index);        // once
//     const ClosestFeature closest = closest_feature(octree, p);          // by any search
//     const SignedDistance d = sign_of(*sign, closest, p);
//
// Where the surface is known to separate inside from outside (surface_sides.h), the side of the
// angle-weighted pseudonormal of the closest feature tells [baerentzen-2005]: tens of nanoseconds.
// Everywhere else, and where rounding leaves that in doubt, the winding number does:
// microseconds, more near the surface.
//
// In doubt: a point is so far from a feature, for the size of its triangles, that another feature
// is as near but for rounding; or it lies all but in the plane that parts inside from outside
// there. Outside of the box of a surface that separates, all is outside, however far.
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "index/mesh_index.h"
#include "mesh/topology.h"
#include "mesh/triangle_mesh.h"
#include "octree/winding_number.h"
#include "query/closest/closest_feature.h"
#include "query/closest/surface_sides.h"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace proxima {

/// How a sign was found.
enum class SignMethod : std::uint8_t {
    on_surface,     ///< the distance is 0
    pseudonormal,   ///< by the side of the closest feature
    winding_number, ///< by the winding number at the point
    none            ///< the point is not finite, the distance NaN
};

struct SignedDistance {
    /// In the mesh's unit, negative inside. 0 exactly on the closest feature, even where
    /// the closest point as computed is beside it.
    double distance = 0.0;
    SignMethod method = SignMethod::on_surface;
    ClosestFeature closest;
};

/// What tells signs. Refers to mesh and topology, which must outlive it. Immutable.
class SurfaceSign {
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

    /// Whether the closest feature tells the sign everywhere, but for rounding.
    [[nodiscard]] bool is_local() const noexcept;

    /// Of the mesh where it is known to be closed: all beyond is outside. Else endless.
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }

    /// The least height of the triangles whose sides are known: points near for that are told
    /// without a look at the closest one's.
    [[nodiscard]] double least_height() const noexcept { return least_height_; }

    /// Memory without mesh and topology: 15 per triangle of a closed mesh, and the winding
    /// number's 30.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

private:
    friend class SurfaceSignBuilder;

    const Topology* topology_ = nullptr;
    WindingNumber winding_;
    std::vector<SurfaceSides> sides_;
    std::vector<SurfaceSides> vertex_sides_;
    std::vector<Vec3> pseudonormals_;
    Box bounds_;
    double least_height_ = 0;
};

struct SurfaceSignOptions {
    Threads threads = {};
    Progress* progress = nullptr; ///< watched and obeyed where given
};

/// Examines the surface: 3 us per triangle of a closed mesh, 1 us of others, on one thread. Errors:
/// those of build_winding_number, cancelled. The same bits for any number of threads. The index is
/// needed here only. \pre all are of one mesh
[[nodiscard]] Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh,
                                                     const Topology& topology,
                                                     const MeshIndex& index,
                                                     const SurfaceSignOptions& options = {});

/// Builds an index of its own for the time of the build.
[[nodiscard]] Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh,
                                                     const Topology& topology,
                                                     const SurfaceSignOptions& options = {});

/// The closest feature's distance from p with its sign. No allocation, thread safe. Of the answer
/// to a p that is not finite: NaN, by no method.
/// \pre closest is the closest feature of p, up to rounding, by whichever search
[[nodiscard]] SignedDistance sign_of(const SurfaceSign& sign, const ClosestFeature& closest,
                                     const Vec3& p) noexcept;

/// "on_surface", "pseudonormal", "winding_number", "none".
[[nodiscard]] std::string_view name_of(SignMethod method) noexcept;

} // namespace proxima
