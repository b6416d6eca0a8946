// What a TouchBody (touch_scene.h) is made of: the mesh, its index and surface, normals and signs.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "haptics/surface/shading_normals.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/signed_distance.h"
#include "proxima/topology.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <memory>
#include <optional>

namespace proxima {

/// What a body's questions are answered by.
enum class BodySearch : bool {
    index,
    every_triangle ///< slow: a reference that the other is compared with
};

/// Immutable. Questions are noexcept and without allocation.
class ContactBody {
public:
    ContactBody(const ContactBody&) = delete;
    ContactBody& operator=(const ContactBody&) = delete;

    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return mesh_; }
    [[nodiscard]] const MeshIndex& mesh_index() const noexcept { return index_; }
    [[nodiscard]] const ContactSurface& surface() const noexcept { return *surface_; }
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }
    [[nodiscard]] const std::optional<SurfaceMaterial>& material() const noexcept
    {
        return material_;
    }
    /// Null where none were asked for.
    [[nodiscard]] const ShadingNormals* normals() const noexcept { return normals_.get(); }

    /// The place of the surface nearest to p where p is inside of a closed mesh; nothing outside,
    /// and where the mesh does not separate its inside everywhere. \pre p is finite
    [[nodiscard]] std::optional<Vec3> nearest_exit(const Vec3& p) const noexcept;

private:
    friend class ContactBodyBuilder;
    ContactBody() = default;

    TriangleMesh mesh_;
    Topology topology_;
    MeshIndex index_;
    Box bounds_;
    std::unique_ptr<ContactSurface> surface_;
    std::unique_ptr<ShadingNormals> normals_;
    std::optional<SurfaceSign> sign_; ///< of meshes that are closed
    std::optional<SurfaceMaterial> material_;
};

/// With lists. Errors: those of build_topology, build_mesh_index, with_lists and
/// build_surface_sign; invalid_argument for materials that are not finite, negative, or of more
/// dynamic than static friction.
[[nodiscard]] Result<std::unique_ptr<const ContactBody>>
build_contact_body(TriangleMesh mesh, const TouchBodyOptions& options = {},
                   BodySearch search = BodySearch::index);

/// Of an index that is built or was saved, with the mesh and the shelves that it has. Errors also
/// those of mesh_of and check_edges.
[[nodiscard]] Result<std::unique_ptr<const ContactBody>>
build_contact_body(const MeshIndex& index, const TouchBodyOptions& options = {});

} // namespace proxima
