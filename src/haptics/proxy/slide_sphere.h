// Moves a sphere towards a place as far as a surface lets it, sliding along: one tick of a proxy.
//
//     touches   triangles within the radius, up to a skin that is thicker than rounding
//     planes    their tangent planes at the nearest points: faces, cylinders and spheres of
//               [ruspini-1997]; the nearest place that they allow is the next goal
//     sweep     the way there, up to what is touched first (swept_sphere.h)
//     repeat    until the goal is reached: all constraints of a tick in that tick
//
// The centre never comes nearer to any triangle than the radius, but for the skin, and never
// passes one: every move is swept. So it does not matter which way triangles face, whether the
// surface is closed, or how thin a wall is. Every move comes nearer to the wanted place, so it ends
// where none does: at the local minimum that the sphere slides to.
//
// The result does not depend on which other triangles the surface offers or in what order.
#pragma once

#include "haptics/proxy/contact_cache.h"
#include "haptics/proxy/contact_planes.h"
#include "haptics/proxy/touched_places.h"
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

/// No slide has more moves.
inline constexpr std::size_t max_slide_moves = 48;

struct SlideResult {
    Vec3 center = Vec3::Zero();
    Vec3 anchor = Vec3::Zero();      ///< where the wanted place is held back to: the centre; of
                                     ///< a sphere no larger than the gap, once settled, the surface
    std::array<Contact, 3> contacts; ///< that hold it back; none on a free way, out of moves
    std::size_t contact_count = 0;
    std::size_t moves = 0;         ///< places on the path without the first
    std::size_t first_contact = 0; ///< the first of them at which something held it back
    SlideEnd end = SlideEnd::settled;
};

/// Memory for a slide, allocated once; one per thread.
class SlideScratch {
public:
    static constexpr std::size_t triangles = 4096; ///< near at a time

    SlideScratch() : near_(triangles), times_(triangles), planes_(max_contact_planes) {}

    /// The centre's places in the last slide, from its start on, straight moves between.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return std::span(path_).first(path_size_);
    }

    /// A path that stays at a place.
    void begin_path(const Vec3& place) noexcept
    {
        path_[0] = place;
        path_size_ = 1;
    }

    /// Leaves only the first so many moves of the path.
    void cut_path(std::size_t moves) noexcept { path_size_ = std::min(path_size_, moves + 1); }

    /// What all slides asked the surface for.
    [[nodiscard]] const ContactWork& work() const noexcept { return cache_.work(); }

private:
    friend class Slide;
    friend std::optional<Contact> nearest_contact(const ContactSurface& surface, const Vec3& p,
                                                  double distance, SlideScratch& scratch) noexcept;
    ContactCache cache_;
    std::vector<ContactTriangle> near_;
    std::vector<double> times_; ///< of near_: nothing of it is touched before
    TouchedPlaces touched_;
    std::vector<ContactPlane> planes_;
    std::array<Vec3, max_slide_moves + 1> path_;
    std::size_t path_size_ = 0;
};

/// The least radius: a proxy that is a point keeps so far from the surface. A billionth of the
/// surface's extent, more where it lies far from the origin.
[[nodiscard]] double safety_gap(const SurfaceScale& scale) noexcept;

/// The nearest place of the surface within a distance, with the normal towards p.
/// \pre p is finite, distance > 0
[[nodiscard]] std::optional<Contact> nearest_contact(const ContactSurface& surface, const Vec3& p,
                                                     double distance,
                                                     SlideScratch& scratch) noexcept;

/// What is known of the place at which a slide begins.
enum class SlideStart : std::uint8_t {
    anywhere, ///< the surface is asked how far it is: long free ways in one move
    touching  ///< something is near: that question would be in vain
};

/// Slides a sphere of max(radius, safety gap) from `from` towards `to`. noexcept, no allocation, no
/// lock: at most max_slide_moves questions of the surface, usually one to three of about 1 us.
/// \pre at `from` nothing is nearer than the sphere's radius; all finite; radius >= 0; max_moves is
/// 1 to max_slide_moves
[[nodiscard]] SlideResult slide_sphere(const ContactSurface& surface, double radius,
                                       const Vec3& from, const Vec3& to, SlideScratch& scratch,
                                       SlideStart start = SlideStart::anywhere,
                                       std::size_t max_moves = max_slide_moves) noexcept;

} // namespace proxima
