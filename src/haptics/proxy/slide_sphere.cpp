#include "haptics/proxy/slide_sphere.h"

#include "haptics/proxy/contact_planes.h"
#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace proxima {

namespace {

/// More than what places are off by from rounding: the thickness of the skin in which triangles
/// count as touched.
double skin_of(const SurfaceScale& scale) noexcept
{
    return 0x1p-42 * scale.reach;
}

/// A move is at most so long, in mean edges: a few dozen triangles are along it.
constexpr double reach_in_edges = 2;

/// Most moves end within this part of it: what lies beyond is looked at where they do not.
constexpr double first_part = 0.125;

// What is kept and looked at later always has room.
static_assert(SlideScratch::triangles >= GroupBoxes::capacity * TriangleGroup::width);

} // namespace

double safety_gap(const SurfaceScale& scale) noexcept
{
    return std::max(0x1p-30 * scale.extent, 0x1p-38 * scale.reach);
}

/// One slide: see slide_sphere.h.
class Slide {
public:
    Slide(const ContactSurface& surface, double radius, Vec3 to, SlideScratch& scratch) noexcept
        : surface_(surface), gap_(safety_gap(surface.scale())), radius_(std::max(radius, gap_)),
          skin_(skin_of(surface.scale())), to_(std::move(to)), scratch_(scratch)
    {}

    SlideResult run(const Vec3& from, SlideStart start, std::size_t max_moves) noexcept
    {
        result_.center = from;
        scratch_.begin_path(from);
        if (start == SlideStart::touching || !reach_freely()) {
            result_.end = SlideEnd::limited;
            while (result_.moves < max_moves && move()) {
            }
            if (result_.end == SlideEnd::limited) {
                hold_where_it_is();
            } else if (result_.contact_count > 0 && !(radius_ > gap_)) {
                result_.anchor = anchor_at_surface();
            }
        }
        return result_;
    }

private:
    /// Goes straight where nothing can be near.
    bool reach_freely() noexcept
    {
        const double way = (to_ - result_.center).norm();
        const double wanted = way + radius_ + skin_;
        const double clearance = scratch_.cache_.clearance(surface_, result_.center, wanted);
        touches_nothing_ = clearance > radius_ + skin_;
        if (clearance <= wanted) return false;
        result_.anchor = to_;
        if (way > 0) go(to_);
        return true;
    }

    /// Out of moves: what it touches there holds it back, and there it is. The last goal, of planes
    /// that a sphere among details has left behind, may be anywhere.
    void hold_where_it_is() noexcept
    {
        if (find_touches()) (void)choose_goal(scratch_.touched_.contacts());
        result_.anchor = result_.center;
    }

    void go(const Vec3& place) noexcept
    {
        result_.center = place;
        ++result_.moves;
        scratch_.path_[scratch_.path_size_++] = place;
    }

    /// One goal and the way there. False when the slide is over.
    bool move() noexcept
    {
        const Vec3 p = result_.center;
        if (!find_touches()) return end(SlideEnd::overloaded);
        const std::span<const Contact> touched = scratch_.touched_.contacts();
        const Vec3 goal = choose_goal(touched);

        Vec3 way = goal - p;
        const double length = way.norm();
        if (length <= 0.25 * skin_) return end(SlideEnd::settled);
        double reach = std::min(length, reach_in_edges * surface_.scale().mean_edge);
        if (!collect_way(way / length, reach)) return end(SlideEnd::overloaded);
        const bool whole = reach == length;
        if (!whole) way *= reach / length;
        const double t = sweep(way, touched);
        if (!(t > 0)) return end(SlideEnd::limited); // planes that no double satisfies
        touches_nothing_ = false;
        if (t == 1 && whole) {
            go(goal);
            // Nothing held it back: it is there.
            if (result_.contact_count == 0) return end(SlideEnd::settled);
        } else {
            go(p + t * way);
        }
        return true;
    }

    /// What is touched where it is. False where there is no room.
    bool find_touches() noexcept
    {
        if (touches_nothing_) {
            scratch_.touched_.clear();
            return true;
        }
        // At the end of a move, what is near was on the way.
        if (result_.moves > 0) {
            const auto near = std::span<const ContactTriangle>(scratch_.near_).first(near_count_);
            return scratch_.touched_.find_among(near, surface_, result_.center, radius_ + skin_,
                                                0.25 * skin_);
        }
        return scratch_.touched_.find(scratch_.cache_, surface_, result_.center, radius_ + skin_,
                                      0.25 * skin_, scratch_.near_);
    }

    /// Triangles along the first part of the first `reach` of a direction; a shorter reach where
    /// there are too many.
    bool collect_way(const Vec3& direction, double& reach) noexcept
    {
        for (int attempt = 0; attempt < 12; ++attempt) {
            scratch_.cache_.begin_sweep(surface_, result_.center, reach * direction,
                                        radius_ + 2 * skin_);
            near_count_ =
                scratch_.cache_.next_before(surface_, first_part, scratch_.near_, scratch_.times_);
            if (near_count_ <= scratch_.near_.size()) return true;
            reach /= 2;
        }
        return false;
    }

    bool end(SlideEnd how) noexcept
    {
        result_.end = how;
        if (result_.contact_count == 0) result_.anchor = result_.center;
        return false;
    }

    /// The nearest place to the wanted one that the contacts allow; notes what holds it back.
    Vec3 choose_goal(std::span<const Contact> touched) noexcept
    {
        result_.contact_count = 0;
        result_.anchor = to_;
        const auto used = std::span(scratch_.planes_).first(touched.size());
        plane_count_ = touched.size();
        for (std::size_t i = 0; i < touched.size(); ++i) {
            const Contact& contact = touched[i];
            used[i] = {contact.normal, contact.normal.dot(to_ - contact.point) - radius_};
        }
        const PlaneSolution solution = nearest_allowed(used, skin_);
        if (solution.count == 0) return to_;
        for (std::size_t i = 0; i < solution.count; ++i) {
            Contact& contact = result_.contacts[i];
            contact = touched[solution.active[i]];
            contact.pressure = solution.pressure[i];
        }
        result_.contact_count = solution.count;
        Vec3 goal = to_ + solution.shift;
        result_.anchor = goal;
        if (!has_contact_) {
            has_contact_ = true;
            result_.first_contact = result_.moves;
        }
        if (solution.count == 1 && touched.size() == 1 && radius_ > gap_)
            return around(result_.contacts[0], goal);
        return goal;
    }

    /// What the last planes allow without the safety gap.
    [[nodiscard]] Vec3 anchor_at_surface() const noexcept
    {
        const auto planes = std::span(scratch_.planes_).first(plane_count_);
        for (ContactPlane& plane : planes) plane.gap += radius_;
        return to_ + nearest_allowed(planes, skin_).shift;
    }

    /// Round a single corner or side, the goal straight above the place where the slide will end:
    /// repeated projections onto tangent planes would come there slowly.
    [[nodiscard]] Vec3 around(const Contact& contact, const Vec3& goal) const noexcept
    {
        if (contact.part == TrianglePart::inside) return goal;
        const Vec3 apart = to_ - contact.point;
        Vec3 along = Vec3::Zero();
        if (contact.part >= TrianglePart::side_0) {
            along = contact.side * contact.side.dot(apart);
        }
        const Vec3 outward = apart - along;
        const double size = outward.norm();
        const double rise = outward.dot(contact.normal);
        if (!(rise > 0.5 * size)) return goal;
        return contact.point + along + outward * (radius_ / rise);
    }

    /// How much of the way is free: 1 for all.
    double sweep(const Vec3& way, std::span<const Contact> touched) noexcept
    {
        for (const Contact& contact : touched) {
            if (contact.normal.dot(way) < -3 * skin_) return 0;
        }
        double free = 1;
        sweep_from(0, way, free);
        if (free > first_part) {
            const std::size_t before = near_count_;
            near_count_ += scratch_.cache_.next_before(surface_, free,
                                                       std::span(scratch_.near_).subspan(before),
                                                       std::span(scratch_.times_).subspan(before));
            sweep_from(before, way, free);
        }
        // What may be near at the end of the way.
        std::size_t kept = 0;
        for (std::size_t i = 0; i < near_count_; ++i) {
            if (scratch_.times_[i] <= free) scratch_.near_[kept++] = scratch_.near_[i];
        }
        near_count_ = kept;
        return free;
    }

    /// Of triangles that were collected from `first` on.
    void sweep_from(std::size_t first, const Vec3& way, double& free) noexcept
    {
        // What may be touched soonest mostly is, and nothing else before it.
        const auto times = std::span<const double>(scratch_.times_).first(near_count_);
        std::size_t soonest = near_count_;
        for (std::size_t i = first; i < near_count_; ++i) {
            if (times[i] > 0 && (soonest == near_count_ || times[i] < times[soonest])) soonest = i;
        }
        if (soonest < near_count_) look_at(soonest, way, free);
        for (std::size_t i = first; i < near_count_; ++i)
            if (times[i] <= free && i != soonest) look_at(i, way, free);
    }

    /// Ends the free part of the way where a triangle is touched.
    void look_at(std::size_t i, const Vec3& way, double& free) noexcept
    {
        const ContactTriangle& near = scratch_.near_[i];
        // What is touched already is left or gone along. Of contacts at one place one alone is
        // kept, and where two faces are all but flat the other may still be gone into.
        const double least = scratch_.touched_.has(near.id) ? radius_ - 4 * skin_ : radius_;
        const auto t = touch_time(near.corners, least, result_.center, way);
        if (t && *t < free) free = *t;
    }

    const ContactSurface& surface_;
    double gap_;
    double radius_;
    double skin_;
    Vec3 to_;
    SlideScratch& scratch_;
    std::size_t near_count_ = 0;
    std::size_t plane_count_ = 0; ///< of the last goal
    bool touches_nothing_ = false;
    bool has_contact_ = false;
    SlideResult result_;
};

std::optional<Contact> nearest_contact(const ContactSurface& surface, const Vec3& p,
                                       double distance, SlideScratch& scratch) noexcept
{
    const std::span<ContactTriangle> near = scratch.near_;
    const std::size_t count = std::min(surface.collect(p, distance, near), near.size());
    std::optional<Contact> best;
    for (const ContactTriangle& triangle : near.first(count)) {
        const auto contact = contact_with(triangle, p, distance, 0);
        if (!contact) continue;
        const double squared = (contact->point - p).squaredNorm();
        const double least = best ? (best->point - p).squaredNorm() : distance * distance;
        if (squared < least || (best && squared == least && contact->triangle < best->triangle))
            best = contact;
    }
    return best;
}

SlideResult slide_sphere(const ContactSurface& surface, double radius, const Vec3& from,
                         const Vec3& to, SlideScratch& scratch, SlideStart start,
                         std::size_t max_moves) noexcept
{
    return Slide(surface, radius, to, scratch).run(from, start, max_moves);
}

} // namespace proxima
