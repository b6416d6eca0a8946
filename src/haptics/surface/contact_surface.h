// The surface that a proxy touches: queries for the triangles near a position.
//
//     direct mode   of the mesh index itself, which the servo loop queries
//     patch mode    of the triangles handed over by the collision loop (contact_patch.h)
//     brute force   of all triangles of the mesh: slow, the reference for the others
//
// All members are noexcept, do not allocate, and may be called from any thread, but for those of a
// scene (touch_scene.h), which caches near triangles, and of a patch's surface: by one thread.
#pragma once

#include "haptics/surface/contact_triangle.h"
#include "haptics/surface/triangle_groups.h"
#include "haptics/surface/triangle_tree.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace proxima {

/// The size of a surface and its distance from the origin, in its own unit.
struct SurfaceScale {
    double extent = 1;    ///< the longest edge of the box about it
    double reach = 1;     ///< the largest |coordinate|
    double mean_edge = 1; ///< the side of as many equilateral triangles of the same area, but no
                          ///< less than least_edge
};

/// In extents: a mean edge for how far a slide goes in one move. Surfaces without an area, of needles,
/// or of small parts far apart, must not slow the hand down.
inline constexpr double least_edge = 0x1p-10;

[[nodiscard]] SurfaceScale scale_of(const TriangleMesh& mesh);

/// A lower bound of the distance of p that was computed as this.
[[nodiscard]] double less_rounding(double distance, const SurfaceScale& scale,
                                   const Vec3& p) noexcept;

/// Triangles by position. Immutable during queries.
class ContactSurface {
public:
    ContactSurface() = default;
    ContactSurface(const ContactSurface&) = delete;
    ContactSurface& operator=(const ContactSurface&) = delete;
    virtual ~ContactSurface() = default;

    [[nodiscard]] virtual const SurfaceScale& scale() const noexcept = 0;

    /// Writes all triangles within `distance` of p, in any order, and perhaps some that are
    /// farther. Returns how many it wrote, or any number that is more than the buffer's size, where
    /// some are missing. \pre p is finite, distance >= 0
    [[nodiscard]] virtual std::size_t collect(const Vec3& p, double distance,
                                              std::span<ContactTriangle> buffer) const noexcept = 0;

    /// Like collect(), of all triangles within `distance` of the segment from p to p + motion.
    [[nodiscard]] virtual std::size_t
    collect_along(const Vec3& p, const Vec3& motion, double distance,
                  std::span<ContactTriangle> buffer) const noexcept
    {
        return collect(p + 0.5 * motion, distance + 0.5 * motion.norm(), buffer);
    }

    /// A lower bound of the surface's distance from p, perhaps 0 or less. \pre p is finite
    [[nodiscard]] virtual double clearance(const Vec3& p) const noexcept = 0;

    /// A lower bound in a bounded time, at most clearance(). \pre p is finite
    [[nodiscard]] virtual double least_clearance(const Vec3& p) const noexcept
    {
        return clearance(p);
    }

    /// clearance(), or where that is more than `wanted` any number between the two. \pre p is finite
    [[nodiscard]] virtual double clearance_beyond(const Vec3& p, double wanted) const noexcept
    {
        const double least = least_clearance(p);
        return least > wanted ? least : clearance(p);
    }

    /// p, or where closed bodies contain it a position at the surface of one of them, outside of all
    /// unless many overlap. p where the surface does not know its inside. \pre p is finite
    [[nodiscard]] virtual Vec3 nearest_exit(const Vec3& p) const noexcept { return p; }

    /// A number of this surface alone. While it stays the same so do all answers, which may be
    /// cached (contact_cache.h). 0: cache nothing.
    [[nodiscard]] virtual std::uint64_t edition() const noexcept { return 0; }

    /// Its groups. Where it has any, the three functions below answer too.
    [[nodiscard]] virtual std::span<const TriangleGroup> groups() const noexcept { return {}; }
    /// A query at p, in the units of their boxes.
    [[nodiscard]] virtual GroupQuery group_query(const Vec3& p) const noexcept
    {
        return {.position = p};
    }
    /// The boxes of all groups that have a triangle within the distance of p, and of some more.
    virtual void find_groups(const Vec3& /*p*/, double /*distance*/,
                             GroupBoxes& boxes) const noexcept
    {
        boxes.count = 0;
    }
    /// The triangles of these ranks. \pre triangles has an element for each rank
    virtual void read_triangles(std::span<const std::uint32_t> /*ranks*/,
                                std::span<ContactTriangle> /*triangles*/) const noexcept
    {}
};

/// An edition that no surface had before. Wait-free; any thread.
[[nodiscard]] std::uint64_t new_edition() noexcept;

/// The surface of a mesh index, whose storage it shares.
class IndexContactSurface final : public ContactSurface {
public:
    /// O(triangles). \pre make() has no error
    explicit IndexContactSurface(const MeshIndex& index);
    /// Errors: those of mesh_of and build_triangle_tree. O(triangles).
    [[nodiscard]] static Result<std::unique_ptr<const IndexContactSurface>>
    make(const MeshIndex& index);

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    /// About 1 us and 15 ns per triangle written.
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override;
    /// The distance of the closest feature, less its rounding.
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;
    /// clearance() where the index lists the near triangles, else two thirds of it or more, by boxes
    /// alone.
    [[nodiscard]] double least_clearance(const Vec3& p) const noexcept override;
    /// Knows its inside where the index tells it everywhere (with_exits). One signed distance.
    [[nodiscard]] Vec3 nearest_exit(const Vec3& p) const noexcept override;
    [[nodiscard]] std::uint64_t edition() const noexcept override { return edition_; }
    [[nodiscard]] std::span<const TriangleGroup> groups() const noexcept override
    {
        return groups_;
    }
    /// The tree of the groups' boxes.
    [[nodiscard]] const TriangleTree& tree() const noexcept { return tree_; }
    [[nodiscard]] GroupQuery group_query(const Vec3& p) const noexcept override;
    /// About 0.5 us.
    void find_groups(const Vec3& p, double distance, GroupBoxes& boxes) const noexcept override;
    void read_triangles(std::span<const std::uint32_t> ranks,
                        std::span<ContactTriangle> triangles) const noexcept override;

private:
    struct Parts {
        TriangleTree tree;
        SurfaceScale scale;
    };
    [[nodiscard]] static Result<Parts> build_parts(const MeshIndex& index);
    IndexContactSurface(const MeshIndex& index, Parts parts);

    MeshIndex index_;
    TriangleTree tree_; ///< eight rows to a group
    SurfaceScale scale_;
    std::uint64_t edition_ = new_edition();
    std::vector<TriangleGroup> groups_; ///< 40 bytes per triangle
};

/// All triangles of a mesh, which must outlive this. Each query tests every triangle.
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
