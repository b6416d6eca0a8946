#include "proxima/thesis.h"
#include "thesis/proximity_octree/thesis_closest.h"
#include "thesis/proximity_octree/thesis_proximity_parts.h"

#include <utility>

namespace proxima {

ThesisProximity::ThesisProximity(std::shared_ptr<const ThesisProximityParts> parts) noexcept
    : parts_(std::move(parts))
{}

int ThesisProximity::depth_reached() const noexcept
{
    return parts_->octree.depth_reached();
}

std::uint64_t ThesisProximity::bytes() const noexcept
{
    return parts_->octree.bytes();
}

Result<ThesisProximity> build_thesis_proximity(TriangleMesh mesh,
                                               const ThesisProximityOptions& options)
{
    auto topology = build_topology(mesh, {.execution = options.execution});
    if (!topology) return tl::unexpected(topology.error());
    auto octree = build_thesis_proximity_octree(mesh, *topology, options);
    if (!octree) return tl::unexpected(octree.error());
    return ThesisProximity(std::make_shared<const ThesisProximityParts>(
        ThesisProximityParts{std::move(mesh), std::move(*topology), std::move(*octree)}));
}

std::optional<ClosestFeature> closest_feature(const ThesisProximity& proximity,
                                              const Vec3& point) noexcept
{
    const ThesisProximityParts& parts = proximity.parts();
    return closest_feature(parts.octree, parts.mesh, parts.topology, point);
}

} // namespace proxima
