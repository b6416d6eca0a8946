#include "haptics/surface/exits.h"

#include "proxima/signed_distance.h"

namespace proxima {

Result<MeshIndex> with_exits(const MeshIndex& index, const Execution& execution)
{
    if (index.has_signs()) return index;
    auto with = with_signs(index, {.execution = execution});
    if (with && !has_local_signs(*with)) return index;
    return with;
}

std::optional<Vec3> exit_of(const MeshIndex& index, const Vec3& p) noexcept
{
    if (!has_local_signs(index)) return std::nullopt;
    const auto at = signed_distance(index, p);
    if (!at || !(at->distance < 0)) return std::nullopt;
    return at->closest.point;
}

Vec3 beyond(const Vec3& exit, const Vec3& p, double gap) noexcept
{
    const Vec3 step = exit - p;
    const double length = step.norm();
    return length > 0 ? Vec3(exit + step * (2 * gap / length)) : p;
}

} // namespace proxima
