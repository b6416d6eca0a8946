// Whether points near holes are inside, by the winding number of a mesh that is spread over ranks.
#pragma once

#include "distributed/route_triangles.h"
#include "distributed/world.h"

#include <vector>

namespace proxima {

/// For each point of this rank, whether the whole mesh's winding number there is 1/2 or more, as
/// is_inside decides it. Every rank sums solid angles of its triangles; clusters of them are summed
/// more finely until the bound of the error cannot change the answer. Error limit_exceeded where
/// rounding alone would decide: within 2^-42 of the least number that counts as 1/2. Collective.
[[nodiscard]] Result<std::vector<bool>>
inside_near_holes(const RoutedPart& part, const std::vector<Vec3>& points, World& world);

} // namespace proxima
