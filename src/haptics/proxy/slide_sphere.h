// Moves a sphere towards a wanted position, sliding along a surface: one tick of a proxy.
//
//     contacts  with triangles within the radius, up to a skin that is thicker than rounding
//     planes    tangent planes at the nearest points: faces, cylinders and spheres of
//               [ruspini-1997]; the nearest position that they allow is the next goal
//     sweep     the path to the goal, up to the first contact (swept_sphere.h)
//     repeat    until the goal is reached: all constraints of a tick in that tick
//
// The centre never comes nearer to any triangle than the radius, but for the skin, and never passes
// one: every move is swept. So the result does not depend on how triangles are oriented, whether
// the surface is closed, or how thin a wall is. Every move comes nearer to the wanted position; the
// slide ends at a local minimum, where none does. A point, which is a sphere as thick as the safety
// gap, leaves corners that only its thickness holds it at (corner_ways.h), and comes as near as an
// eighth of the gap on that one move.
//
// With friction every move is along the contacts, and shorter: the slide ends where the rest of the
// way along them is no more than a part of their push.
//
// The result does not depend on further triangles that a query returns, nor on their order.
#pragma once

#include "haptics/proxy/contact_cache.h"
#include "haptics/proxy/contact_planes.h"
#include "haptics/proxy/sphere_contacts.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// Limits of RenderOptions::max_moves; no slide has more moves.
inline constexpr std::size_t least_slide_moves = 4;
inline constexpr std::size_t max_slide_moves = 48;

struct SlideResult {
    Vec3 center = Vec3::Zero();
    Vec3 anchor = Vec3::Zero();      ///< nearest allowed position of the centre, with friction the
                                     ///< centre; of a sphere no larger than the gap, once settled,
                                     ///< on the surface
    std::array<Contact, 3> contacts; ///< that hold the sphere back; none on a free path
    std::size_t contact_count = 0;
    std::size_t moves = 0;         ///< positions on the path after the first
    std::size_t first_contact = 0; ///< index on the path of the first contact
    SlideEnd end = SlideEnd::settled;
};

/// Memory for a slide, allocated once; one per thread.
class SlideScratch {
public:
    static constexpr std::size_t triangles = 4096; ///< capacity, near one move

    SlideScratch() : near_(triangles), times_(triangles), planes_(max_contact_planes) {}

    /// The centre's positions in the last slide from its start on, with straight moves between them.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return std::span(path_).first(path_size_);
    }

    /// Begins a path of one position.
    void begin_path(const Vec3& position) noexcept
    {
        path_[0] = position;
        path_size_ = 1;
    }

    /// Keeps only the first moves of the path.
    void cut_path(std::size_t moves) noexcept { path_size_ = std::min(path_size_, moves + 1); }

    /// Work counters of all slides.
    [[nodiscard]] const ContactWork& work() const noexcept { return cache_.work(); }

private:
    friend class Slide;
    friend std::optional<Contact> nearest_contact(const ContactSurface& surface, const Vec3& p,
                                                  double distance, SlideScratch& scratch) noexcept;
    ContactCache cache_;
    std::vector<ContactTriangle> near_;
    std::vector<double> times_; ///< of near_: parts of the move before which it is not touched
    SphereContacts contacts_;
    std::vector<ContactPlane> planes_;
    std::array<Vec3, max_slide_moves + 1> path_;
    std::size_t path_size_ = 0;
};

/// The least radius, which keeps a point proxy off the surface: a billionth of the surface's extent,
/// more where it lies far from the origin.
[[nodiscard]] double safety_gap(const SurfaceScale& scale) noexcept;

/// The nearest point of the surface within a distance, with the normal towards p.
/// \pre p is finite, distance > 0
[[nodiscard]] std::optional<Contact> nearest_contact(const ContactSurface& surface, const Vec3& p,
                                                     double distance,
                                                     SlideScratch& scratch) noexcept;

/// What is known of the start of a slide.
enum class SlideStart : std::uint8_t {
    anywhere, ///< queries the surface's distance first: long free paths take one move
    touching  ///< something is near: that query would not help
};

/// Slides a sphere of max(radius, safety gap) from `from` towards `to`. noexcept, no allocation, no
/// lock: at most max_slide_moves queries of the surface, usually one to three of about 1 us.
/// `friction`: tangential over normal force that holds the sphere.
/// \pre at `from` nothing is nearer than the sphere's radius; all finite; radius >= 0; max_moves is
/// 1 to max_slide_moves; friction >= 0
[[nodiscard]] SlideResult slide_sphere(const ContactSurface& surface, double radius,
                                       const Vec3& from, const Vec3& to, SlideScratch& scratch,
                                       SlideStart start = SlideStart::anywhere,
                                       std::size_t max_moves = max_slide_moves,
                                       double friction = 0) noexcept;

/// The nearest position to `to` that the contacts of a sphere at rest allow: `center` of the result,
/// and `anchor` as of a slide. The sphere stays at `at`; center - to is the push of its contacts, and
/// center - at the way along them. No contacts: nothing holds it back. One query of the surface, none
/// where the last slide with this scratch memory ended at `at`. \pre as slide_sphere()
[[nodiscard]] SlideResult pull_sphere(const ContactSurface& surface, double radius, const Vec3& at,
                                      const Vec3& to, SlideScratch& scratch) noexcept;

} // namespace proxima
