// The triangles round a place, kept from one tick to the next: a proxy asks for what is near it
// several times a tick, a thousand times a second, and each time it is all but at the same place.
//
//     ball    the boxes of all groups of triangles within `reach` of `center` are kept
//     asked   within the ball: answered from the groups whose boxes are near, in lanes of floats
//             (triangle_groups.h); beyond it: a new ball
//     free    how far the surface was at a place, less the way since then: often enough to know
//             that nothing is near without asking
//
// What a proxy does with the answers is the same, bit for bit, as if it had asked the surface.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "haptics/surface/groups_along_segment.h"
#include "haptics/surface/triangle_groups.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// What was asked for, since the cache was made.
struct ContactWork {
    std::uint64_t distances = 0; ///< questions of the surface how far it is
    std::uint64_t gathers = 0;   ///< questions of the surface what is near
    std::uint64_t gathered = 0;  ///< triangles that these gave, or have in their groups
    std::uint64_t scans = 0;     ///< questions answered from what was kept
    std::uint64_t scanned = 0;   ///< boxes that these looked at
    std::uint64_t passed = 0;    ///< triangles that were given to be looked at in doubles

    friend ContactWork operator+(const ContactWork& a, const ContactWork& b) noexcept
    {
        return {a.distances + b.distances, a.gathers + b.gathers, a.gathered + b.gathered,
                a.scans + b.scans,         a.scanned + b.scanned, a.passed + b.passed};
    }
};

/// Of a thread. All but the constructor are noexcept and do not allocate.
class ContactCache {
public:
    ContactCache();

    /// As surface.collect(): all triangles within the distance, and perhaps some that are farther.
    [[nodiscard]] std::size_t collect(const ContactSurface& surface, const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) noexcept;

    /// The same of all triangles that come within `distance` of the straight way from p.
    [[nodiscard]] std::size_t collect_along(const ContactSurface& surface, const Vec3& p,
                                            const Vec3& way, double distance,
                                            std::span<ContactTriangle> buffer) noexcept;

    /// The same by and by, for who goes until something is met: begins to look along the straight
    /// way from p.
    void begin_sweep(const ContactSurface& surface, const Vec3& p, const Vec3& way,
                     double distance) noexcept;

    /// The triangles along that way which were not given yet and may be so near before `part` of
    /// it, 0 to 1, and perhaps some more. Also before which part of it nothing of each is: 0 where
    /// that is not known. Returns how many, or any number of more than the buffer's size where that
    /// is full: then some are missing. \pre the surface is the same, there is a time for each place
    /// of the buffer
    [[nodiscard]] std::size_t next_before(const ContactSurface& surface, double part,
                                          std::span<ContactTriangle> buffer,
                                          std::span<double> times) noexcept;

    /// Where it is more than `wanted`: some number that is, and no more than what
    /// surface.clearance() says; otherwise what that says.
    [[nodiscard]] double clearance(const ContactSurface& surface, const Vec3& p,
                                   double wanted) noexcept;

    /// Whether collect() would answer from what is kept.
    [[nodiscard]] bool covers(const ContactSurface& surface, const Vec3& p,
                              double distance) noexcept;

    /// No part of the surface is nearer to p than this, as is known without asking. Negative where
    /// nothing is.
    [[nodiscard]] double known_clearance(const ContactSurface& surface, const Vec3& p) noexcept;

    [[nodiscard]] const ContactWork& work() const noexcept { return work_; }

private:
    [[nodiscard]] bool keeps(const ContactSurface& surface) noexcept;
    [[nodiscard]] bool fill(const ContactSurface& surface, const Vec3& p, double distance) noexcept;
    [[nodiscard]] std::size_t ask(const ContactSurface& surface, const Vec3& p, const Vec3& way,
                                  double distance, std::span<ContactTriangle> buffer) noexcept;
    [[nodiscard]] bool reach_out(const ContactSurface& surface, const Vec3& p, const Vec3& way,
                                 double distance) noexcept;
    [[nodiscard]] std::size_t scan(const ContactSurface& surface,
                                   std::span<const std::uint32_t> groups,
                                   std::span<ContactTriangle> buffer) noexcept;

    std::uint64_t edition_ = 0;
    Vec3 center_ = Vec3::Zero();
    double reach_ = -1; ///< negative: no ball
    double margin_ = 0; ///< a new ball's reach beyond what is asked for
    double rounding_ = 0;
    std::vector<GroupBoxes> boxes_; ///< one: of the ball
    GroupQuery query_;              ///< what is looked for
    std::vector<GroupsAlongSegment>
        near_;                         ///< one: groups that may have it and were not looked at yet
    bool asks_ = false;                ///< of the surface itself
    std::vector<std::uint32_t> ranks_; ///< of triangles found
    std::vector<float> times_;         ///< of these, on a way
    Vec3 free_center_ = Vec3::Zero();
    double free_ = -1; ///< negative: not known
    ContactWork work_;
};

} // namespace proxima
