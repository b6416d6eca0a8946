// Distances from a mesh with a sign: negative inside, where the winding number is at least 1/2.
//
//     auto index = build_mesh_index(mesh);
//     auto sign = build_surface_sign(*index);                            // once
//     double distance = signed_distance(*index, *sign, point).distance;
//
//     std::vector<double> distances(points.size());                      // many points, on all cores
//     Status done = signed_distances(*index, *sign, points, {.distances = distances});
//
// Where the surface is known to separate inside from outside, the side of the angle-weighted
// pseudonormal of the closest feature tells [baerentzen-2005]: tens of nanoseconds. Everywhere else,
// and where rounding leaves that in doubt, the winding number does: microseconds, more near the
// surface.
//
// In doubt: a point is so far from a feature, for the size of its triangles, that another feature
// is as near but for rounding; or it lies all but in the plane that parts inside from outside
// there. Outside of the box of a surface that separates, all is outside, however far.
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

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

/// What an examined surface knows, as the library's own searches use it.
class SignParts;

/// What tells signs. Immutable and cheap to copy: copies share what they hold. Thread safe. Made by
/// build_surface_sign.
class SurfaceSign {
public:
    /// Whether the closest feature tells the sign everywhere, but for rounding: so it is for closed,
    /// consistently oriented meshes that do not intersect themselves.
    [[nodiscard]] bool is_local() const noexcept;

    /// Bytes beside those of the mesh and its topology: 15 per triangle of a closed mesh, and 30 for
    /// winding numbers.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// For the library's own searches.
    [[nodiscard]] const SignParts& parts() const noexcept { return *parts_; }
    /// For the library's own builders. \pre parts is not null
    explicit SurfaceSign(std::shared_ptr<const SignParts> parts) noexcept;

    // Copies only: a moved-from one would have no parts.
    SurfaceSign(const SurfaceSign&) noexcept = default;
    SurfaceSign& operator=(const SurfaceSign&) noexcept = default;
    ~SurfaceSign() = default;

private:
    std::shared_ptr<const SignParts> parts_; ///< never null
};

struct SurfaceSignOptions {
    Execution execution = {};
};

/// Examines the surface of the index's mesh: 3 us per triangle of a closed mesh, 1 us of others, on
/// one thread. The sign holds a mesh and a topology of its own and refers to nothing. The same bits
/// for any number of threads. Errors: invalid_mesh (an empty index), broken_invariant (mesh_of),
/// limit_exceeded, budget_exceeded, cancelled.
[[nodiscard]] Result<SurfaceSign> build_surface_sign(const MeshIndex& index,
                                                     const SurfaceSignOptions& options = {});

/// The closest feature's distance from p with its sign. No allocation, thread safe. If p is
/// not finite, the distance is NaN, by no method.
/// \pre closest is the closest feature of p, up to rounding, by whichever search
[[nodiscard]] SignedDistance sign_of(const SurfaceSign& sign, const ClosestFeature& closest,
                                     const Vec3& p) noexcept;

/// The signed distance of p. As closest_feature and sign_of together; NaN, by no method, where p is
/// not finite. \pre the sign is of the index's mesh
[[nodiscard]] SignedDistance signed_distance(const MeshIndex& index, const SurfaceSign& sign,
                                             const Vec3& p) noexcept;

/// Where a batch writes: each span is empty or has an element for every point.
struct SignedOutputs {
    std::span<double> distances = {};
    std::span<SignedDistance> answers = {}; ///< in full
};

/// signed_distance() of many points, searched as closest_features does: the same bits, for any
/// number of threads. Stage "signed distances", steps are points. Allocates 6 MB per thread at most.
/// Errors: invalid_argument (sizes differ, a point is not finite: which), cancelled. \pre the sign is
/// of the index's mesh
[[nodiscard]] Status signed_distances(const MeshIndex& index, const SurfaceSign& sign,
                                      std::span<const Vec3> points, const SignedOutputs& outputs,
                                      const BatchOptions& options = {});

/// "on_surface", "pseudonormal", "winding_number", "none".
[[nodiscard]] std::string_view name_of(SignMethod method) noexcept;

} // namespace proxima
