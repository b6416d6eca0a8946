// Where two solids overlap most, by the distances from a point to both surfaces.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "query/contacts/solid_parts.h"

#include <cstdint>

namespace proxima {

/// A point, and how deep it is in A and B together: no translation of B shorter than that parts
/// a ball in A from a ball in B, both about the point.
struct DeepestPoint {
    double depth = 0; ///< 0 where no point of both was found
    Vec3 point = Vec3::Zero();
};

/// A point of both solids whose depths in A and B have the largest sum found, by branch and bound over the
/// box that both boxes share: at most `max_points` points are looked at. Depths as computed; the caller
/// takes off what they are rounded by. Deterministic. Ends early where the progress is cancelled.
[[nodiscard]] DeepestPoint find_deepest_point(const SolidParts& a, const SolidParts& b,
                                              const RigidTransform& pose_b,
                                              std::uint32_t max_points,
                                              const Progress* progress = nullptr);

} // namespace proxima
