// The triangles that the collision loop hands to the servo loop (thesis 5.1.1), and the surface that
// a proxy sees of them: those within so many rings of the closest feature.
//
// Rings guarantee nothing: a hand may leave them before the next patch comes. Who wants all that a
// hand can touch queries the whole surface.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "haptics/surface/patch_groups.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/topology.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Copies of triangles near a position. Memory is allocated once, so that it can be filled in a loop.
/// Copies of a patch are independent.
class ContactPatch {
public:
    static constexpr std::size_t most = 8192; ///< triangles

    ContactPatch() : copies_(most), groups_(most) {}

    /// The buffer into which triangles are copied, for use_copies().
    [[nodiscard]] std::span<ContactTriangle> copies() noexcept { return copies_; }
    /// Takes the first triangles of copies(). `extent` is the whole surface's. noexcept, no
    /// allocation. \pre triangles <= copies().size()
    void use_copies(std::size_t triangles, double extent) noexcept;

    [[nodiscard]] std::size_t count() const noexcept { return count_; }
    /// A new number whenever it is filled, as ContactSurface::edition().
    [[nodiscard]] std::uint64_t edition() const noexcept { return edition_; }

    /// The tree over the triangles, whose groups are groups(). \pre count() > 0
    [[nodiscard]] TriangleTree tree() const noexcept { return groups_.tree(); }
    [[nodiscard]] std::span<const TriangleGroup> groups() const noexcept
    {
        return groups_.groups();
    }
    [[nodiscard]] GroupQuery group_query(const Vec3& p) const noexcept { return groups_.query(p); }
    /// The triangles of these ranks in groups(). \pre triangles has an element for each rank
    void read_triangles(std::span<const std::uint32_t> ranks,
                        std::span<ContactTriangle> triangles) const noexcept;

    /// All triangles.
    [[nodiscard]] std::span<const ContactTriangle> triangles() const noexcept
    {
        return std::span(copies_).first(count_);
    }

    bool complete = true;       ///< no triangle is missing for want of capacity
    Vec3 center = Vec3::Zero(); ///< the device's position that it was made for
    double clearance = 0;       ///< no part of the whole surface is nearer to the centre
    std::uint64_t made_at = 0;  ///< the servo tick whose state it was made for

private:
    std::vector<ContactTriangle> copies_;
    PatchGroups groups_;
    std::size_t count_ = 0;
    std::uint64_t edition_ = 0;
};

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
