// The triangles that the collision loop hands to the servo loop (thesis 5.1.1), and the surface that
// a proxy sees of them.
//
//     metric   all triangles within R of the device:
//              R >= 2 v (T + latency) + |device - proxy| + proxy radius       v: fastest hand
//     rings    triangles within so many rings of the closest feature          the thesis's
//
// A metric patch has all triangles that a proxy can meet before the next patch comes: the distance
// of proxy and device grows by at most twice the device's displacement. Rings guarantee nothing on
// meshes of uneven triangles: a hand may leave them within a collision tick.
//
// A metric patch names groups of the surface's triangles and has a tree over their boxes. It copies
// no triangles, so it is made quickly, however many there are, and a proxy reads no more memory
// than of the whole surface. Rings are copied.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "haptics/surface/near_groups.h"
#include "haptics/surface/patch_groups.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace proxima {

/// Triangles near a position: some of a surface's, or copies. Memory is allocated once, so that it
/// can be filled in a loop. Copies are independent.
class ContactPatch {
public:
    static constexpr std::size_t most = 8192; ///< triangles, by default

    ContactPatch() : ContactPatch(most) {}
    /// Has a capacity of so many triangles of a surface, in whole blocks of 64, 4 bytes each, and of
    /// as many copies up to `most`, 124 bytes each.
    explicit ContactPatch(std::size_t triangles)
        : near_(triangles), copies_(std::min(triangles, most)), groups_(copies_.size())
    {}

    /// Takes all triangles of a surface within `distance` of p, with their neighbours, or those
    /// within the longest reach that fits the capacity. Refers to the surface. noexcept, no
    /// allocation. \pre p is finite, distance >= 0
    void refer(const IndexContactSurface& surface, const Vec3& p, double distance) noexcept;

    /// The buffer into which triangles are copied, for use_copies().
    [[nodiscard]] std::span<ContactTriangle> copies() noexcept { return copies_; }
    /// Takes the first triangles of copies(). `extent` is the whole surface's. noexcept, no
    /// allocation. \pre triangles <= copies().size()
    void use_copies(std::size_t triangles, double extent) noexcept;

    [[nodiscard]] std::size_t count() const noexcept { return count_; }
    /// A new number whenever it is filled, as ContactSurface::edition().
    [[nodiscard]] std::uint64_t edition() const noexcept { return edition_; }

    /// The tree over the triangles, whose groups group() numbers. \pre count() > 0
    [[nodiscard]] TriangleTree tree() const noexcept
    {
        return surface_ != nullptr ? near_.tree() : groups_.tree();
    }
    /// The index in groups() of a group of tree().
    [[nodiscard]] std::uint32_t group(std::uint32_t of_tree) const noexcept
    {
        return surface_ != nullptr ? near_.group(of_tree) : of_tree;
    }
    [[nodiscard]] std::span<const TriangleGroup> groups() const noexcept
    {
        return surface_ != nullptr ? surface_->groups() : groups_.groups();
    }
    [[nodiscard]] GroupQuery group_query(const Vec3& p) const noexcept
    {
        return surface_ != nullptr ? surface_->group_query(p) : groups_.query(p);
    }
    /// The triangles of these ranks in groups(). \pre triangles has an element for each rank
    void read_triangles(std::span<const std::uint32_t> ranks,
                        std::span<ContactTriangle> triangles) const noexcept;

    /// All triangles. \pre triangles has count() elements
    void read(std::span<ContactTriangle> triangles) const noexcept;

    bool complete = true; ///< no triangle is missing for want of capacity
    double reach = 0;     ///< of a metric patch: all triangles so near to the centre are there
    Vec3 center = Vec3::Zero(); ///< the device's position that it was made for
    double clearance = 0;       ///< no part of the whole surface is nearer to the centre
    std::uint64_t made_at = 0;  ///< the servo tick whose state it was made for

private:
    const IndexContactSurface* surface_ = nullptr; ///< null where triangles are copies
    NearGroups near_;
    std::vector<ContactTriangle> copies_;
    PatchGroups groups_; ///< of the copies
    std::size_t count_ = 0;
    std::uint64_t edition_ = 0;
};

/// The reach that a metric patch needs. Lengths in one unit, times in seconds.
[[nodiscard]] constexpr double patch_radius(double speed, double collision_seconds,
                                            double latency_seconds, double device_to_proxy,
                                            double proxy_radius) noexcept
{
    return 2 * speed * (collision_seconds + latency_seconds) + device_to_proxy + proxy_radius;
}

/// Fills a patch with all triangles within a radius of the device, or within a shorter one where
/// they exceed its capacity: then it is complete for slower hands. The patch refers to the surface.
/// noexcept, no allocation; half a nanosecond per triangle. \pre finite, radius >= 0
void fill_metric_patch(ContactPatch& patch, const IndexContactSurface& surface, const Vec3& device,
                       double radius) noexcept;

/// Makes the thesis's patches of rings; one thread.
class RingPatches {
public:
    /// Refers to all three, which must outlive it.
    RingPatches(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology);

    /// Fills a patch with the triangles within `depth` rings of the device's closest feature.
    /// noexcept, no allocation. \pre device is finite, depth >= 0
    void fill(ContactPatch& patch, const Vec3& device, int depth) noexcept;

    /// Like fill, around a closest feature that the caller has found.
    void fill(ContactPatch& patch, const Vec3& device, const ClosestFeature& closest,
              int depth) noexcept;

private:
    const MeshIndex& index_;
    const TriangleMesh& mesh_;
    const Topology& topology_;
    double extent_;
    NeighbourhoodScratch scratch_;
    std::vector<TriangleId> ids_;
};

/// The latest patch as a proxy's surface. Queries cost as much as those of the whole surface.
/// Without a patch it is empty.
class PatchContactSurface final : public ContactSurface {
public:
    /// The scale is the whole surface's, so that proxies of both behave alike.
    explicit PatchContactSurface(const SurfaceScale& scale) : scale_(scale) {}
    /// Its exits are the whole surface's too, which must outlive it.
    explicit PatchContactSurface(const ContactSurface& whole)
        : scale_(whole.scale()), whole_(&whole)
    {}

    /// Uses this patch, which must not change until the next call. One thread.
    void use(const ContactPatch* patch) noexcept { patch_ = patch; }

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    /// By boxes of groups, then of triangles.
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override;
    /// By the patch's clearance and the distance from its centre.
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;
    [[nodiscard]] Vec3 nearest_exit(const Vec3& p) const noexcept override
    {
        return whole_ == nullptr ? p : whole_->nearest_exit(p);
    }
    [[nodiscard]] std::uint64_t edition() const noexcept override
    {
        return patch_ == nullptr ? 0 : patch_->edition();
    }
    [[nodiscard]] std::span<const TriangleGroup> groups() const noexcept override;
    [[nodiscard]] GroupQuery group_query(const Vec3& p) const noexcept override;
    void find_groups(const Vec3& p, double distance, GroupBoxes& boxes) const noexcept override;
    void read_triangles(std::span<const std::uint32_t> ranks,
                        std::span<ContactTriangle> triangles) const noexcept override;

private:
    [[nodiscard]] bool is_empty() const noexcept
    {
        return patch_ == nullptr || patch_->count() == 0;
    }

    SurfaceScale scale_;
    const ContactSurface* whole_ = nullptr; ///< null where no exits are known
    const ContactPatch* patch_ = nullptr;
};

} // namespace proxima
