#include "haptics/scene/contact_body.h"

#include "haptics/surface/exits.h"
#include "index/check_edges.h"
#include "proxima/mesh_index.h"

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

/// Makes a body step by step.
class ContactBodyBuilder {
public:
    ContactBodyBuilder(const TouchBodyOptions& options, BodySearch search)
        : options_(options), search_(search), body_(new ContactBody)
    {}

    [[nodiscard]] Result<std::unique_ptr<const ContactBody>> build(TriangleMesh mesh,
                                                                   const MeshIndex* index)
    {
        if (options_.material && !in_range(*options_.material)) {
            return fail(ErrorCode::invalid_argument,
                        "stiffness, damping and friction of a surface must be finite and not "
                        "negative, and dynamic friction at most static friction");
        }
        ContactBody& body = *body_;
        body.mesh_ = std::move(mesh);
        auto topology = build_topology(body.mesh_, {.execution = options_.execution});
        if (!topology) return tl::unexpected(topology.error());
        body.topology_ = std::move(*topology);
        if (index != nullptr) {
            if (Status status = check_edges(*index, body.topology_); !status)
                return tl::unexpected(status.error());
            body.index_ = *index;
        } else {
            const auto built = build_mesh_index(body.mesh_, {.execution = options_.execution});
            if (!built) return tl::unexpected(built.error());
            body.index_ = *built;
        }
        auto with = with_exits(body.index_, options_.execution);
        if (!with) return tl::unexpected(with.error());
        body.index_ = *with;
        body.bounds_ = bounding_box(body.mesh_);
        if (search_ == BodySearch::every_triangle) {
            body.surface_ = std::make_unique<MeshContactSurface>(body.mesh_);
        } else {
            auto surface = IndexContactSurface::make(body.index_);
            if (!surface) return tl::unexpected(surface.error());
            body.surface_ = std::move(*surface);
        }
        if (options_.shading == ForceShading::on)
            body.normals_ = std::make_unique<ShadingNormals>(body.mesh_, body.topology_);
        body.material_ = options_.material;
        return std::move(body_);
    }

private:
    const TouchBodyOptions& options_;
    BodySearch search_;
    std::unique_ptr<ContactBody> body_;
};

Result<std::unique_ptr<const ContactBody>>
build_contact_body(TriangleMesh mesh, const TouchBodyOptions& options, BodySearch search)
{
    return ContactBodyBuilder(options, search).build(std::move(mesh), nullptr);
}

Result<std::unique_ptr<const ContactBody>> build_contact_body(const MeshIndex& index,
                                                              const TouchBodyOptions& options)
{
    auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    return ContactBodyBuilder(options, BodySearch::index).build(std::move(*mesh), &index);
}

} // namespace proxima
