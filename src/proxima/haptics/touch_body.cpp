#include "proxima/haptics/touch_body.h"

#include "proxima/proximity/build_proximity_octree.h"
#include "proxima/proximity/closest_feature.h"

#include <array>
#include <cmath>

namespace proxima {

namespace {

bool in_range(const SurfaceMaterial& material)
{
    for (const double number : {material.stiffness, material.damping, material.static_friction,
                                material.dynamic_friction}) {
        if (!(number >= 0) || !std::isfinite(number)) return false;
    }
    return material.dynamic_friction <= material.static_friction;
}

} // namespace

std::optional<Vec3> TouchBody::way_out(const Vec3& p) const noexcept
{
    if (!sign_) return std::nullopt;
    const SignedDistance at = sign_of(*sign_, closest_feature(octree_, p), p);
    if (!(at.distance < 0)) return std::nullopt;
    return at.closest.point;
}

Result<std::unique_ptr<const TouchBody>> build_touch_body(TriangleMesh mesh,
                                                          const TouchBodyOptions& options)
{
    if (options.material && !in_range(*options.material)) {
        return fail(ErrorCode::invalid_argument,
                    "a surface's stiffness, damping and frictions are finite and not negative, and "
                    "dynamic friction is no more than static");
    }
    std::unique_ptr<TouchBody> body(new TouchBody);
    body->mesh_ = std::move(mesh);
    auto topology =
        build_topology(body->mesh_, {.threads = options.threads, .progress = options.progress});
    if (!topology) return tl::unexpected(topology.error());
    body->topology_ = std::move(*topology);
    auto octree = build_proximity_octree(
        body->mesh_, body->topology_, {.threads = options.threads, .progress = options.progress});
    if (!octree) return tl::unexpected(octree.error());
    body->octree_ = std::move(*octree);
    auto sign = build_surface_sign(body->mesh_, body->topology_,
                                   {.threads = options.threads, .progress = options.progress});
    if (!sign) return tl::unexpected(sign.error());
    if (sign->is_local()) body->sign_ = std::move(*sign);
    body->bounds_ = bounding_box(body->mesh_);
    body->surface_ = std::make_unique<OctreeContactSurface>(body->octree_);
    if (options.shading == ForceShading::on)
        body->normals_ = std::make_unique<ShadingNormals>(body->mesh_, body->topology_);
    body->material_ = options.material;
    return body;
}

} // namespace proxima
