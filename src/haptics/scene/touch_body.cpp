#include "haptics/scene/touch_body.h"

#include "index/lists/build_proximity_octree.h"
#include "index/lists/octree_mesh.h"
#include "query/closest/closest_feature.h"

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

std::optional<Vec3> TouchBody::nearest_exit(const Vec3& p) const noexcept
{
    if (!sign_) return std::nullopt;
    const SignedDistance at = sign_of(*sign_, closest_feature(octree_, p), p);
    if (!(at.distance < 0)) return std::nullopt;
    return at.closest.point;
}

/// Makes a body step by step.
class TouchBodyBuilder {
public:
    explicit TouchBodyBuilder(const TouchBodyOptions& options)
        : options_(options), body_(new TouchBody)
    {}

    [[nodiscard]] Result<std::unique_ptr<const TouchBody>> build(TriangleMesh mesh,
                                                                 ProximityOctree* octree)
    {
        if (options_.material && !in_range(*options_.material)) {
            return fail(ErrorCode::invalid_argument,
                        "a surface's stiffness, damping and frictions are finite and not negative, "
                        "and dynamic friction is no more than static");
        }
        TouchBody& body = *body_;
        body.mesh_ = std::move(mesh);
        auto topology = build_topology(body.mesh_, {.execution = options_.execution});
        if (!topology) return tl::unexpected(topology.error());
        body.topology_ = std::move(*topology);
        if (octree != nullptr) {
            if (Status status = check_edges(*octree, body.topology_); !status)
                return tl::unexpected(status.error());
            body.octree_ = std::move(*octree);
        } else if (Status status = build_octree(); !status) {
            return tl::unexpected(status.error());
        }
        auto sign =
            build_surface_sign(body.mesh_, body.topology_, {.execution = options_.execution});
        if (!sign) return tl::unexpected(sign.error());
        if (sign->is_local()) body.sign_ = std::move(*sign);
        body.bounds_ = bounding_box(body.mesh_);
        if (options_.search == BodySearch::every_triangle) {
            body.surface_ = std::make_unique<MeshContactSurface>(body.mesh_);
        } else {
            body.surface_ = std::make_unique<OctreeContactSurface>(body.octree_);
        }
        if (options_.shading == ForceShading::on)
            body.normals_ = std::make_unique<ShadingNormals>(body.mesh_, body.topology_);
        body.material_ = options_.material;
        return std::move(body_);
    }

private:
    [[nodiscard]] Status build_octree()
    {
        auto built = build_proximity_octree(body_->mesh_, body_->topology_,
                                            {.execution = options_.execution});
        if (!built) return tl::unexpected(built.error());
        body_->octree_ = std::move(*built);
        return {};
    }

    const TouchBodyOptions& options_;
    std::unique_ptr<TouchBody> body_;
};

Result<std::unique_ptr<const TouchBody>> build_touch_body(TriangleMesh mesh,
                                                          const TouchBodyOptions& options)
{
    return TouchBodyBuilder(options).build(std::move(mesh), nullptr);
}

Result<std::unique_ptr<const TouchBody>> build_touch_body(ProximityOctree octree,
                                                          const TouchBodyOptions& options)
{
    auto mesh = mesh_of(octree);
    if (!mesh) return tl::unexpected(mesh.error());
    return TouchBodyBuilder(options).build(std::move(*mesh), &octree);
}

} // namespace proxima
