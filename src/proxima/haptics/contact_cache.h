// The triangles round a place, kept from one tick to the next: a proxy asks for what is near it
// several times a tick, a thousand times a second, and each time it is all but at the same place.
//
//     ball    all triangles within `reach` of `center` are kept, as doubles and as lanes of floats
//     asked   within the ball: answered by a scan of the lanes; beyond it: a new ball
//     free    how far the surface was at a place, less the way since then: often enough to know
//             that nothing is near without asking
//
// Lanes leave out only what is farther than asked for by more than their rounding, so what a proxy
// does with the answers is the same, bit for bit, as if it had asked the surface.
#pragma once

#include "proxima/haptics/contact_surface.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// What was asked for, since the cache was made.
struct ContactWork {
    std::uint64_t distances = 0; ///< questions of the surface how far it is
    std::uint64_t gathers = 0;   ///< questions of the surface what is near
    std::uint64_t gathered = 0;  ///< triangles that these gave
    std::uint64_t scans = 0;     ///< questions answered from what was kept
    std::uint64_t scanned = 0;   ///< triangles in lanes that these looked at
    std::uint64_t passed = 0;    ///< triangles that were given to be looked at in doubles

    friend ContactWork operator+(const ContactWork& a, const ContactWork& b) noexcept
    {
        return {a.distances + b.distances, a.gathers + b.gathers, a.gathered + b.gathered,
                a.scans + b.scans,         a.scanned + b.scanned, a.passed + b.passed};
    }
};

/// Triangles as lanes of floats: corners from the ball's centre over its reach, axis by axis.
struct TriangleFloats {
    static constexpr std::size_t room = 1024;
    std::array<std::array<float, room>, 3> corners[3]; ///< of corner, by axis
    std::array<float, room> margin; ///< more than distances are off by; infinite where floats say
                                    ///< nothing
};

/// Of a thread. All but the constructor are noexcept and do not allocate.
class ContactCache {
public:
    ContactCache();

    /// As surface.collect(), which is asked only if the ball is spent.
    [[nodiscard]] std::size_t collect(const ContactSurface& surface, const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) noexcept;

    /// The same of all triangles that come within `distance` of the straight way from p.
    [[nodiscard]] std::size_t collect_along(const ContactSurface& surface, const Vec3& p,
                                            const Vec3& way, double distance,
                                            std::span<ContactTriangle> buffer) noexcept;

    /// Where it is more than `wanted`: some number that is, and no more than what
    /// surface.clearance() says; otherwise what that says.
    [[nodiscard]] double clearance(const ContactSurface& surface, const Vec3& p,
                                   double wanted) noexcept;

    [[nodiscard]] const ContactWork& work() const noexcept { return work_; }

private:
    [[nodiscard]] bool keeps(const ContactSurface& surface) noexcept;
    [[nodiscard]] bool covers(const ContactSurface& surface, const Vec3& p,
                              double distance) noexcept;
    [[nodiscard]] bool fill(const ContactSurface& surface, const Vec3& p, double distance) noexcept;
    [[nodiscard]] bool keep(const ContactSurface& surface, const Vec3& center, double reach,
                            std::size_t given) noexcept;
    [[nodiscard]] std::size_t ask(const ContactSurface& surface, const Vec3& p, double distance,
                                  std::span<ContactTriangle> buffer) noexcept;
    [[nodiscard]] std::size_t give(std::size_t count, std::span<ContactTriangle> buffer) noexcept;
    [[nodiscard]] std::array<float, 3> in_units(const Vec3& length) const noexcept;

    std::uint64_t edition_ = 0;
    Vec3 center_ = Vec3::Zero();
    double reach_ = -1; ///< negative: no ball
    double margin_ = 0; ///< a new ball's reach beyond what is asked for
    double rounding_ = 0;
    std::size_t count_ = 0;
    std::vector<ContactTriangle> triangles_; ///< as the surface gave them
    std::vector<TriangleFloats> floats_;     ///< one: of those that are within the ball
    std::vector<std::uint16_t> places_;      ///< where these are in triangles_
    std::vector<std::uint16_t> found_;   ///< places of the kept triangles
    Vec3 free_center_ = Vec3::Zero();
    double free_ = -1; ///< negative: not known
    ContactWork work_;
};

} // namespace proxima
