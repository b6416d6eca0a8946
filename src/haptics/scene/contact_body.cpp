#include "haptics/scene/contact_body.h"

#include "base/text.h"
#include "haptics/scene/material_change.h"
#include "haptics/surface/changing_surface.h"
#include "haptics/surface/exits.h"
#include "haptics/surface/height_field.h"
#include "index/check_edges.h"
#include "proxima/mesh_index.h"

namespace proxima {

ChangingParts ContactBody::parts() const noexcept
{
    return {.from = &mesh_,
            .to = &mesh_,
            .tree = tree_ ? &*tree_ : nullptr,
            .order = order(),
            .scale = scale_};
}

/// Makes a body step by step.
class ContactBodyBuilder {
public:
    ContactBodyBuilder(const TouchBodyOptions& options, BodySearch search)
        : options_(options), search_(search), body_(new ContactBody)
    {}

    [[nodiscard]] Result<std::unique_ptr<const ContactBody>> build(TriangleMesh mesh,
                                                                   const MeshIndex* index)
    {
        if (options_.material && !is_valid(*options_.material))
            return fail(ErrorCode::invalid_argument, material_rule);
        if (options_.texture) {
            if (Status status = check_texture(*options_.texture); !status)
                return tl::unexpected(status.error());
        }
        ContactBody& body = *body_;
        body.mesh_ = std::move(mesh);
        auto topology = build_topology(body.mesh_, {.execution = options_.execution});
        if (!topology) return tl::unexpected(topology.error());
        body.topology_ = std::make_shared<const Topology>(std::move(*topology));
        body.search_ = search_;
        if (index != nullptr) {
            if (Status status = check_edges(*index, *body.topology_); !status)
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
            body.tree_ = (*surface)->tree();
            body.surface_ = std::move(*surface);
        }
        body.scale_ = body.surface_->scale();
        if (options_.shading == ForceShading::on)
            body.normals_ = std::make_unique<ShadingNormals>(body.mesh_, *body.topology_);
        body.material_ = options_.material;
        body.texture_ = options_.texture;
        return std::move(body_);
    }

    [[nodiscard]] Result<std::unique_ptr<const ContactBody>> refit(const ContactBody& built,
                                                                   TriangleMesh mesh)
    {
        ContactBody& body = *body_;
        body.mesh_ = std::move(mesh);
        body.topology_ = built.topology_;
        body.index_ = built.index_;
        body.is_refit_ = true;
        body.search_ = search_;
        // This looks at the positions, too.
        auto tree = build_triangle_tree(body.mesh_, body.order(), options_.execution);
        if (!tree) return tl::unexpected(tree.error());
        if (search_ == BodySearch::index) body.tree_ = std::move(*tree);
        body.scale_ = scale_of(body.mesh_);
        body.bounds_ = bounding_box(body.mesh_);
        body.surface_ = std::make_unique<ChangingSurface>(body.parts(), 1.0);
        if (built.normals() != nullptr)
            body.normals_ = std::make_unique<ShadingNormals>(body.mesh_, *body.topology_);
        body.material_ = built.material();
        body.texture_ = built.texture();
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

Result<std::unique_ptr<const ContactBody>> refit_contact_body(const ContactBody& body,
                                                              std::span<const Vec3> positions,
                                                              const Execution& execution)
{
    const TriangleMesh& mesh = body.mesh();
    if (positions.size() != mesh.vertex_count()) {
        return fail(ErrorCode::invalid_argument,
                    concat("a refit has ", positions.size(), " positions, and its body has ",
                           mesh.vertex_count(), " vertices: give one for each"),
                    "positions");
    }
    auto moved = make_triangle_mesh({positions.begin(), positions.end()},
                                    {mesh.triangles().begin(), mesh.triangles().end()});
    if (!moved) return tl::unexpected(moved.error());
    TouchBodyOptions options;
    options.execution = execution;
    return ContactBodyBuilder(options, body.search()).refit(body, std::move(*moved));
}

} // namespace proxima
