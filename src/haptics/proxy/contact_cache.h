// Caches the triangles near a position from one tick to the next: a proxy queries them several times
// a tick, a thousand times a second, and hardly moves in between.
//
//     ball     the boxes of all groups of triangles within `reach` of `center`
//     query    inside the ball: by the groups whose boxes are near, in lanes of floats
//              (triangle_groups.h); otherwise a new ball is made
//     free     the surface's distance at a position, less the distance moved since then: often
//              enough to know that nothing is near without a query of the surface
//
// A proxy gets the same result, bit for bit, as by queries of the surface itself.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "haptics/surface/groups_along_segment.h"
#include "haptics/surface/triangle_groups.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Work counters, since the cache was made.
struct ContactWork {
    std::uint64_t distances = 0; ///< queries of the surface for its distance
    std::uint64_t gathers = 0;   ///< queries of the surface for near triangles
    std::uint64_t gathered = 0;  ///< triangles of these queries, or of their groups
    std::uint64_t scans = 0;     ///< queries answered by the cache
    std::uint64_t scanned = 0;   ///< boxes that these tested
    std::uint64_t passed = 0;    ///< triangles that passed the filter, to be tested in doubles

    friend ContactWork operator+(const ContactWork& a, const ContactWork& b) noexcept
    {
        return {a.distances + b.distances, a.gathers + b.gathers, a.gathered + b.gathered,
                a.scans + b.scans,         a.scanned + b.scanned, a.passed + b.passed};
    }
};

/// One thread. All but the constructor are noexcept and do not allocate.
class ContactCache {
public:
    ContactCache();

    /// Like surface.collect(): all triangles within the distance, and perhaps some farther ones.
    [[nodiscard]] std::size_t collect(const ContactSurface& surface, const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) noexcept;

    /// Like surface.collect_along(), of the segment from p to p + motion.
    [[nodiscard]] std::size_t collect_along(const ContactSurface& surface, const Vec3& p,
                                            const Vec3& motion, double distance,
                                            std::span<ContactTriangle> buffer) noexcept;

    /// Begins to collect along the segment part by part, for a motion that ends where it first
    /// touches something.
    void begin_sweep(const ContactSurface& surface, const Vec3& p, const Vec3& motion,
                     double distance) noexcept;

    /// Writes the triangles that may be near before `part` (0 to 1) of that segment and were not
    /// written yet, and perhaps some more. For each it writes to `times` a part of the segment
    /// before which the triangle is not near, 0 if none is known. Returns the number of triangles,
    /// or any number larger than the buffer if some are missing. \pre the same surface; as many
    /// times as triangles
    [[nodiscard]] std::size_t next_before(const ContactSurface& surface, double part,
                                          std::span<ContactTriangle> buffer,
                                          std::span<double> times) noexcept;

    /// Like surface.clearance_beyond().
    [[nodiscard]] double clearance(const ContactSurface& surface, const Vec3& p,
                                   double wanted) noexcept;

    /// Whether collect() would not query the surface.
    [[nodiscard]] bool covers(const ContactSurface& surface, const Vec3& p,
                              double distance) noexcept;

    /// A lower bound of the surface's distance without a query of it; negative where none is known.
    [[nodiscard]] double known_clearance(const ContactSurface& surface, const Vec3& p) noexcept;

    [[nodiscard]] const ContactWork& work() const noexcept { return work_; }

private:
    [[nodiscard]] bool update_edition(const ContactSurface& surface) noexcept;
    [[nodiscard]] bool fill(const ContactSurface& surface, const Vec3& p, double distance) noexcept;
    [[nodiscard]] std::size_t bypass(const ContactSurface& surface, const Vec3& p,
                                     const Vec3& motion, double distance,
                                     std::span<ContactTriangle> buffer) noexcept;
    [[nodiscard]] bool cover(const ContactSurface& surface, const Vec3& p, const Vec3& motion,
                             double distance) noexcept;
    [[nodiscard]] std::size_t scan(const ContactSurface& surface,
                                   std::span<const std::uint32_t> groups,
                                   std::span<ContactTriangle> buffer) noexcept;

    std::uint64_t edition_ = 0;
    Vec3 center_ = Vec3::Zero();
    double reach_ = -1; ///< negative: no ball
    double margin_ = 0; ///< a new ball's reach beyond that of its query
    double rounding_ = 0;
    std::vector<GroupBoxes> boxes_; ///< one element: of the ball
    GroupQuery query_;              ///< of the sweep
    std::vector<GroupsAlongSegment>
        near_;              ///< one element: groups of the sweep that were not scanned yet
    bool bypasses_ = false; ///< the sweep queries the surface itself
    std::vector<std::uint32_t> ranks_; ///< of triangles found
    std::vector<float> times_;         ///< of these, along a motion
    Vec3 free_center_ = Vec3::Zero();
    double free_ = -1; ///< negative: not known
    ContactWork work_;
};

} // namespace proxima
