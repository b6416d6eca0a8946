// What a proxy touches: the triangles near a place, by whichever structure knows them.
//
//     direct mode   the mesh index itself: the servo loop asks it for what is near
//     patch mode    the triangles handed over by the collision loop (contact_patch.h)
//     brute force   all triangles of the mesh: slow, a reference that the others are compared with
//
// All members are noexcept, do not allocate, and may be called from any thread, but for those of a
// scene (touch_scene.h), which keeps what is near, and of a patch's surface: by one thread.
#pragma once

#include "haptics/surface/contact_triangle.h"
#include "haptics/surface/triangle_groups.h"
#include "index/triangle_tree.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// The place and size of a surface, in its own unit.
struct SurfaceScale {
    double extent = 1;    ///< the longest edge of the box about it
    double reach = 1;     ///< the largest |coordinate|
    double mean_edge = 1; ///< the side of equal triangles that had its area
};

[[nodiscard]] SurfaceScale scale_of(const TriangleMesh& mesh);

/// Triangles by place. Immutable while it is asked.
class ContactSurface {
public:
    ContactSurface() = default;
    ContactSurface(const ContactSurface&) = delete;
    ContactSurface& operator=(const ContactSurface&) = delete;
    virtual ~ContactSurface() = default;

    [[nodiscard]] virtual const SurfaceScale& scale() const noexcept = 0;

    /// Writes all triangles within `distance` of p, in any order, and perhaps some that are
    /// farther. Returns how many it wrote, or any number of more than the buffer's size where that
    /// is full: then some are missing. \pre p is finite, distance >= 0
    [[nodiscard]] virtual std::size_t collect(const Vec3& p, double distance,
                                              std::span<ContactTriangle> buffer) const noexcept = 0;

    /// The same of all triangles that come within `distance` of the straight way from p.
    [[nodiscard]] virtual std::size_t
    collect_along(const Vec3& p, const Vec3& way, double distance,
                  std::span<ContactTriangle> buffer) const noexcept
    {
        return collect(p + 0.5 * way, distance + 0.5 * way.norm(), buffer);
    }

    /// No part of the surface is nearer to p than this. 0 says nothing. \pre p is finite
    [[nodiscard]] virtual double clearance(const Vec3& p) const noexcept = 0;

    /// The same, in a bounded time: perhaps less than clearance() says. \pre p is finite
    [[nodiscard]] virtual double least_clearance(const Vec3& p) const noexcept
    {
        return clearance(p);
    }

    /// Where it is more than `wanted`: some number that is, and no more than what clearance() says;
    /// otherwise what that says. \pre p is finite
    [[nodiscard]] virtual double clearance_beyond(const Vec3& p, double wanted) const noexcept
    {
        const double least = least_clearance(p);
        return least > wanted ? least : clearance(p);
    }

    /// While this is the same, so are all answers: they may be kept (contact_cache.h). Of no other
    /// surface. 0: keep nothing.
    [[nodiscard]] virtual std::uint64_t edition() const noexcept { return 0; }

    /// Its groups, where it has any: then the three below answer as well.
    [[nodiscard]] virtual std::span<const TriangleGroup> groups() const noexcept { return {}; }
    /// The units of their boxes, as a query of p.
    [[nodiscard]] virtual GroupQuery group_query(const Vec3& p) const noexcept
    {
        return {.place = p};
    }
    /// The boxes of all groups that have a triangle within the distance of p, and of some more.
    virtual void find_groups(const Vec3& /*p*/, double /*distance*/,
                             GroupBoxes& boxes) const noexcept
    {
        boxes.count = 0;
    }
    /// The triangles of these ranks. \pre there is room
    virtual void read_triangles(std::span<const std::uint32_t> /*ranks*/,
                                std::span<ContactTriangle> /*triangles*/) const noexcept
    {}
};

/// A number that no surface had before. Wait-free; any thread.
[[nodiscard]] std::uint64_t new_edition() noexcept;

/// The surface of a mesh index, whose storage it shares.
class IndexContactSurface final : public ContactSurface {
public:
    /// O(triangles). \pre the index is not empty, and no larger than 1e150
    explicit IndexContactSurface(MeshIndex index);

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    /// About 1 us and 15 ns per triangle written.
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override;
    /// The distance of the closest feature, less its rounding.
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;
    /// Like clearance() where the index lists what is near, else two thirds of it or more by boxes
    /// alone.
    [[nodiscard]] double least_clearance(const Vec3& p) const noexcept override;
    [[nodiscard]] std::uint64_t edition() const noexcept override { return edition_; }
    [[nodiscard]] std::span<const TriangleGroup> groups() const noexcept override
    {
        return groups_;
    }
    /// Of the groups' boxes.
    [[nodiscard]] const TriangleTree& tree() const noexcept { return tree_; }
    [[nodiscard]] GroupQuery group_query(const Vec3& p) const noexcept override;
    /// About 0.5 us.
    void find_groups(const Vec3& p, double distance, GroupBoxes& boxes) const noexcept override;
    void read_triangles(std::span<const std::uint32_t> ranks,
                        std::span<ContactTriangle> triangles) const noexcept override;

private:
    MeshIndex index_;
    TriangleTree tree_; ///< eight rows to a group
    SurfaceScale scale_;
    std::uint64_t edition_ = new_edition();
    std::vector<TriangleGroup> groups_; ///< 40 bytes per triangle
};

/// All triangles of a mesh, which must outlive this, each looked at every time.
class MeshContactSurface final : public ContactSurface {
public:
    explicit MeshContactSurface(const TriangleMesh& mesh) : mesh_(&mesh), scale_(scale_of(mesh)) {}

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    /// O(triangles).
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override;
    /// The distance of the nearest triangle, less its rounding. O(triangles).
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;

private:
    const TriangleMesh* mesh_;
    SurfaceScale scale_;
};

} // namespace proxima
