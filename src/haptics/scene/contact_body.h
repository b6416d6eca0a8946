// The implementation of TouchBody (touch_scene.h): mesh, index with signs and surface, normals.
//
//     built     from a mesh or an index
//     refit     from a body and other positions of its vertices: the tree of the surface alone, in the
//               order of the triangles that the body's index has
#pragma once

#include "haptics/surface/changing_surface.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/exits.h"
#include "haptics/surface/shading_normals.h"
#include "haptics/surface/triangle_tree.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <memory>
#include <optional>
#include <span>

namespace proxima {

/// How queries of a body search.
enum class BodySearch : bool {
    index,
    every_triangle ///< slow: the reference for the other
};

/// Immutable. Queries are noexcept and without allocation.
class PROXIMA_HIDDEN ContactBody {
public:
    ContactBody(const ContactBody&) = delete;
    ContactBody& operator=(const ContactBody&) = delete;

    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return mesh_; }
    /// The index of the body, of a refit that of the body that was built first.
    [[nodiscard]] const MeshIndex& mesh_index() const noexcept { return index_; }
    [[nodiscard]] bool is_refit() const noexcept { return is_refit_; }
    /// The order of the triangles in trees of this body and of all refits of it.
    [[nodiscard]] std::span<const TriangleId> order() const noexcept { return index_.ids(); }
    /// Whether both are the same body or refits of the same one.
    [[nodiscard]] bool has_triangles_of(const ContactBody& other) const noexcept
    {
        return topology_ == other.topology_;
    }
    [[nodiscard]] BodySearch search() const noexcept { return search_; }
    /// What a ChangingSurface is made of that is at rest here.
    [[nodiscard]] ChangingParts parts() const noexcept;
    [[nodiscard]] const ContactSurface& surface() const noexcept { return *surface_; }
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }
    [[nodiscard]] const std::optional<SurfaceMaterial>& material() const noexcept
    {
        return material_;
    }
    [[nodiscard]] const std::optional<SurfaceTexture>& texture() const noexcept { return texture_; }
    /// Null for a body without shading.
    [[nodiscard]] const ShadingNormals* normals() const noexcept { return normals_.get(); }

    /// The point of the surface nearest to p where p is inside a closed mesh; nothing outside, and
    /// where the mesh does not separate its inside everywhere, and of a refit. \pre p is finite
    [[nodiscard]] std::optional<Vec3> nearest_exit(const Vec3& p) const noexcept
    {
        return is_refit_ ? std::nullopt : exit_of(index_, p);
    }

private:
    friend class ContactBodyBuilder;
    ContactBody() = default;

    TriangleMesh mesh_;
    std::shared_ptr<const Topology> topology_; ///< shared by refits
    MeshIndex index_;                          ///< with signs where the mesh is closed
    bool is_refit_ = false;
    BodySearch search_ = BodySearch::index;
    std::optional<TriangleTree> tree_; ///< of the surface; none where it tests every triangle
    SurfaceScale scale_;
    Box bounds_;
    std::unique_ptr<const ContactSurface> surface_;
    std::unique_ptr<ShadingNormals> normals_;
    std::optional<SurfaceMaterial> material_;
    std::optional<SurfaceTexture> texture_;
};

/// Builds a body and its index, without lists. Errors: those of build_topology, build_mesh_index and
/// with_signs; invalid_argument for materials that are not finite, negative, or of more dynamic
/// than static friction; those of check_texture.
[[nodiscard]] Result<std::unique_ptr<const ContactBody>>
build_contact_body(TriangleMesh mesh, const TouchBodyOptions& options = {},
                   BodySearch search = BodySearch::index);

/// Builds a body from an index, with its mesh and the lists it may have. Errors: also those of
/// mesh_of and check_edges.
[[nodiscard]] Result<std::unique_ptr<const ContactBody>>
build_contact_body(const MeshIndex& index, const TouchBodyOptions& options = {});

/// The body with its vertices elsewhere. Errors: as refit_touch_body.
[[nodiscard]] Result<std::unique_ptr<const ContactBody>>
refit_contact_body(const ContactBody& body, std::span<const Vec3> positions,
                   const Execution& execution = {});

} // namespace proxima
