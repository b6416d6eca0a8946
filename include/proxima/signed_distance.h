// Distances from a mesh with a sign: negative inside, where the winding number is at least 1/2.
//
//     auto index = build_mesh_index(mesh).and_then(
//         [](const MeshIndex& plain) { return with_signs(plain); });         // once
//     double distance = signed_distance(*index, point)->distance;
//
//     std::vector<double> distances(points.size());                          // many, on all cores
//     Status done = signed_distances(*index, points, {.distances = distances});
//
// Where the surface is known to separate inside from outside, the side of the angle-weighted
// pseudonormal of the closest feature tells [baerentzen-2005]: tens of nanoseconds. Everywhere else,
// and where rounding leaves that in doubt, the winding number does: microseconds. Of surfaces
// without holes it is counted exactly, along a ray; of others summed, which takes longer near them.
//
// In doubt: a point is so far from a feature, for the size of its triangles, that another feature
// is as near but for rounding; or it lies all but in the plane that parts inside from outside
// there. Outside of the box of a surface that separates, all is outside, however far.
//
// Signs are an addition to an index: with_signs (mesh_index.h).
#pragma once

#include "proxima/closest_feature.h"
#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace PROXIMA_EXPORT proxima {

/// How a sign was found.
enum class SignMethod : std::uint8_t {
    on_surface,    ///< the distance is 0
    pseudonormal,  ///< by the side of the closest feature
    winding_number ///< by the winding number at the point
};

struct SignedDistance {
    /// In the mesh's unit, negative inside. 0 exactly on the closest feature, even where
    /// the closest point as computed is beside it.
    double distance = 0.0;
    SignMethod method = SignMethod::on_surface;
    ClosestFeature closest;
};

/// Whether the closest feature tells the sign everywhere, but for rounding: so it is for closed,
/// consistently oriented meshes that do not intersect themselves. False where the index has no signs.
[[nodiscard]] bool has_local_signs(const MeshIndex& index) noexcept;

/// The signed distance of p; nothing where p is not finite or the index has no signs. Real-time safe:
/// noexcept, no allocation, no lock; any number of threads. The time of closest_feature, and where a
/// winding number decides microseconds more.
[[nodiscard]] std::optional<SignedDistance> signed_distance(const MeshIndex& index,
                                                            const Vec3& p) noexcept;

/// Like signed_distance, for a closest feature that was found before. \pre closest is the closest
/// feature of p in this index, up to rounding
[[nodiscard]] std::optional<SignedDistance>
sign_of(const MeshIndex& index, const ClosestFeature& closest, const Vec3& p) noexcept;

/// Where a batch writes: each span is empty or has an element for every point.
struct SignedOutputs {
    std::span<double> distances = {};
    std::span<SignMethod> methods = {};
    std::span<SignedDistance> answers = {}; ///< in full
};

/// signed_distance() of many points, searched as closest_features does: the same bits, for any
/// number of threads. Stage "signed distances", steps are points. Allocates 6 MB per thread at most.
/// Errors: invalid_argument (an index without signs, sizes differ, a point is not finite: which),
/// cancelled.
[[nodiscard]] Status signed_distances(const MeshIndex& index, std::span<const Vec3> points,
                                      const SignedOutputs& outputs,
                                      const BatchOptions& options = {});

/// "on_surface", "pseudonormal", "winding_number".
[[nodiscard]] std::string_view name_of(SignMethod method) noexcept;

} // namespace proxima
