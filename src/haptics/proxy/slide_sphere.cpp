#include "haptics/proxy/slide_sphere.h"

#include "haptics/proxy/contact_planes.h"
#include "haptics/proxy/corner_ways.h"
#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace proxima {

namespace {

/// The thickness of the skin in which triangles count as touched: more than the rounding of
/// positions.
double skin_of(const SurfaceScale& scale) noexcept
{
    return 0x1p-42 * scale.reach;
}

/// The longest move, in mean edges: it passes a few dozen triangles.
constexpr double reach_in_edges = 2;

/// Most moves end within this part of them; triangles beyond it are collected only if needed.
constexpr double first_part = 0.125;

/// Friction holds what would slip by no more than this part of what it allows: a slide over curved
/// parts comes to rest within a few moves.
constexpr double friction_rounding = 0x1p-14;

/// The least cosine of a way out of a corner and the spring's pull: a slope of one degree.
constexpr double least_slope = 0x1p-6;

// The scratch memory takes all triangles that a cache holds.
static_assert(SlideScratch::triangles >= GroupBoxes::capacity * TriangleGroup::width);

} // namespace

double safety_gap(const SurfaceScale& scale) noexcept
{
    return std::max(0x1p-30 * scale.extent, 0x1p-38 * scale.reach);
}

/// One slide: see slide_sphere.h.
class Slide {
public:
    Slide(const ContactSurface& surface, double radius, Vec3 to, SlideScratch& scratch,
          double friction = 0) noexcept
        : surface_(surface), gap_(safety_gap(surface.scale())), radius_(std::max(radius, gap_)),
          skin_(skin_of(surface.scale())), to_(std::move(to)), friction_(friction),
          scratch_(scratch)
    {}

    SlideResult run(const Vec3& from, SlideStart start, std::size_t max_moves) noexcept
    {
        result_.center = from;
        scratch_.begin_path(from);
        if (start == SlideStart::touching || !go_straight()) {
            result_.end = SlideEnd::limited;
            while (result_.moves < max_moves && move()) {
            }
            if (result_.end == SlideEnd::limited) {
                stop_in_place();
            } else if (result_.contact_count > 0) {
                const Vec3 allowed = result_.anchor;
                if (!(radius_ > gap_)) result_.anchor = anchor_at_surface();
                if (friction_ > 0) result_.anchor = result_.center + (result_.anchor - allowed);
            }
        }
        return result_;
    }

    /// Finds what holds the sphere back where it is.
    SlideResult pull(const Vec3& at) noexcept
    {
        result_.center = result_.anchor = at;
        if (find_contacts()) {
            (void)choose_goal(scratch_.contacts_.contacts());
            result_.center = result_.anchor;
            if (result_.contact_count > 0 && !(radius_ > gap_))
                result_.anchor = anchor_at_surface();
        } else {
            result_.end = SlideEnd::overloaded;
        }
        return result_;
    }

private:
    /// Goes straight to the end where nothing can be near.
    bool go_straight() noexcept
    {
        const double distance = (to_ - result_.center).norm();
        const double wanted = distance + radius_ + skin_;
        const double clearance = scratch_.cache_.clearance(surface_, result_.center, wanted);
        touches_nothing_ = clearance > radius_ + skin_;
        if (clearance <= wanted) return false;
        result_.anchor = to_;
        if (distance > 0) go(to_);
        return true;
    }

    /// Ends a slide that is out of moves: its contacts hold it back where it is. The last goal may
    /// be anywhere, for the sphere may have left its planes behind.
    void stop_in_place() noexcept
    {
        if (find_contacts()) (void)choose_goal(scratch_.contacts_.contacts());
        result_.anchor = result_.center;
    }

    void go(const Vec3& position) noexcept
    {
        result_.center = position;
        ++result_.moves;
        scratch_.path_[scratch_.path_size_++] = position;
    }

    /// One goal and the move towards it. False when the slide is over.
    bool move() noexcept
    {
        const Vec3 p = result_.center;
        if (!find_contacts()) return end(SlideEnd::overloaded);
        const std::span<const Contact> contacts = scratch_.contacts_.contacts();
        const Vec3 goal = choose_goal(contacts);

        Vec3 motion = goal - p;
        bool whole = true;
        if (friction_ > 0 && result_.contact_count > 0) {
            motion *= part_beyond_friction();
            whole = false;
        }
        const double length = motion.norm();
        if (length <= 0.25 * skin_) return leave_corner() || end(SlideEnd::settled);
        double reach = std::min(length, reach_in_edges * surface_.scale().mean_edge);
        if (!collect_path(motion / length, reach)) return end(SlideEnd::overloaded);
        if (reach < length) {
            motion *= reach / length;
            whole = false;
        }
        const double t = sweep(motion, contacts);
        if (!(t > 0)) return end(SlideEnd::limited); // planes that no double satisfies
        touches_nothing_ = false;
        if (t == 1 && whole) {
            go(goal);
            // Without contacts it has arrived.
            if (result_.contact_count == 0) return end(SlideEnd::settled);
        } else {
            go(p + t * motion);
        }
        return true;
    }

    /// Goes on where three faces at a corner hold the sphere only because of its size, though it is a
    /// point. False where it is at rest.
    bool leave_corner() noexcept
    {
        if (radius_ > gap_ || result_.contact_count < 3) return false;
        const Vec3& p = result_.center;
        const double length = corner_way * radius_;
        const double distance = (to_ - p).norm();
        if (!(distance > 2 * length)) return false;
        const std::size_t count =
            scratch_.cache_.collect(surface_, p, length + 2 * radius_, scratch_.near_);
        if (count > scratch_.near_.size()) return false;
        const double held = friction_ / std::sqrt(1 + friction_ * friction_);
        const auto motion =
            way_from_corner(std::span<const ContactTriangle>(scratch_.near_).first(count), p,
                            (to_ - p) / distance, held + least_slope, radius_);
        if (!motion) return false;
        near_count_ = count;
        go(p + *motion);
        return true;
    }

    /// The part of the way to the goal after which friction holds the sphere.
    [[nodiscard]] double part_beyond_friction() const noexcept
    {
        const double slip = (result_.anchor - result_.center).norm();
        const double trail = friction_ * (result_.anchor - to_).norm();
        return slip > trail * (1 + friction_rounding) ? 1 - trail / slip : 0.0;
    }

    /// Finds the contacts at the centre. False where there are too many.
    bool find_contacts() noexcept
    {
        if (touches_nothing_) {
            scratch_.contacts_.clear();
            return true;
        }
        // What is near the end of a move was collected for the move.
        if (result_.moves > 0) {
            const auto near = std::span<const ContactTriangle>(scratch_.near_).first(near_count_);
            return scratch_.contacts_.find_among(near, surface_, result_.center, radius_ + skin_,
                                                 0.25 * skin_);
        }
        return scratch_.contacts_.find(scratch_.cache_, surface_, result_.center, radius_ + skin_,
                                       0.25 * skin_, scratch_.near_);
    }

    /// Collects triangles along the first part of a path of length `reach`, which is shortened where
    /// there are too many.
    bool collect_path(const Vec3& direction, double& reach) noexcept
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

    /// The nearest position to the wanted one that the contacts allow; notes the active contacts.
    Vec3 choose_goal(std::span<const Contact> contacts) noexcept
    {
        result_.contact_count = 0;
        result_.anchor = to_;
        const auto used = std::span(scratch_.planes_).first(contacts.size());
        plane_count_ = contacts.size();
        for (std::size_t i = 0; i < contacts.size(); ++i) {
            const Contact& contact = contacts[i];
            used[i] = {contact.normal, contact.normal.dot(to_ - contact.point) - radius_};
        }
        const PlaneSolution solution = nearest_allowed(used, skin_);
        if (solution.count == 0) return to_;
        for (std::size_t i = 0; i < solution.count; ++i) {
            Contact& contact = result_.contacts[i];
            contact = contacts[solution.active[i]];
            contact.pressure = solution.pressure[i];
        }
        result_.contact_count = solution.count;
        Vec3 goal = to_ + solution.shift;
        result_.anchor = goal;
        if (!has_contact_) {
            has_contact_ = true;
            result_.first_contact = result_.moves;
        }
        const bool goes_round = radius_ > gap_ && !(friction_ > 0);
        if (solution.count == 1 && contacts.size() == 1 && goes_round)
            return around(result_.contacts[0], goal);
        return goal;
    }

    /// The nearest position that the last planes allow without the safety gap.
    [[nodiscard]] Vec3 anchor_at_surface() const noexcept
    {
        const auto planes = std::span(scratch_.planes_).first(plane_count_);
        for (ContactPlane& plane : planes) plane.gap += radius_;
        return to_ + nearest_allowed(planes, skin_).shift;
    }

    /// The goal of a slide round a single corner or side: straight above the point where it will
    /// end, which repeated projections onto tangent planes would approach slowly.
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
        // On the axis itself there is no way round.
        if (!(rise > 0.5 * size && rise > skin_)) return goal;
        return contact.point + along + outward * (radius_ / rise);
    }

    /// The part of the motion that is free: 1 for all.
    double sweep(const Vec3& motion, std::span<const Contact> contacts) noexcept
    {
        for (const Contact& contact : contacts) {
            if (contact.normal.dot(motion) < -3 * skin_) return 0;
        }
        double free = 1;
        sweep_from(0, motion, free);
        if (free > first_part) {
            const std::size_t before = near_count_;
            near_count_ += scratch_.cache_.next_before(surface_, free,
                                                       std::span(scratch_.near_).subspan(before),
                                                       std::span(scratch_.times_).subspan(before));
            sweep_from(before, motion, free);
        }
        // Keep what may be near the end of the motion.
        std::size_t kept = 0;
        for (std::size_t i = 0; i < near_count_; ++i) {
            if (scratch_.times_[i] <= free) scratch_.near_[kept++] = scratch_.near_[i];
        }
        near_count_ = kept;
        return free;
    }

    /// Tests the triangles that were collected from `first` on.
    void sweep_from(std::size_t first, const Vec3& motion, double& free) noexcept
    {
        // The triangle that may be touched soonest mostly is the one that is touched first.
        const auto times = std::span<const double>(scratch_.times_).first(near_count_);
        std::size_t soonest = near_count_;
        for (std::size_t i = first; i < near_count_; ++i) {
            if (times[i] > 0 && (soonest == near_count_ || times[i] < times[soonest])) soonest = i;
        }
        if (soonest < near_count_) test_triangle(soonest, motion, free);
        for (std::size_t i = first; i < near_count_; ++i)
            if (times[i] <= free && i != soonest) test_triangle(i, motion, free);
    }

    /// Ends the free part of the motion where a triangle is touched.
    void test_triangle(std::size_t i, const Vec3& motion, double& free) noexcept
    {
        const ContactTriangle& near = scratch_.near_[i];
        // The motion leaves its contacts or slides along them. But of several contacts at one point
        // only one is kept, and the motion may enter another face that is almost coplanar.
        const double least = scratch_.contacts_.has(near.id) ? radius_ - 4 * skin_ : radius_;
        const auto t = touch_time(near.corners, least, result_.center, motion, skin_);
        if (t && *t < free) free = *t;
    }

    const ContactSurface& surface_;
    double gap_;
    double radius_;
    double skin_;
    Vec3 to_;
    double friction_;
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

SlideResult pull_sphere(const ContactSurface& surface, double radius, const Vec3& at,
                        const Vec3& to, SlideScratch& scratch) noexcept
{
    return Slide(surface, radius, to, scratch).pull(at);
}

SlideResult slide_sphere(const ContactSurface& surface, double radius, const Vec3& from,
                         const Vec3& to, SlideScratch& scratch, SlideStart start,
                         std::size_t max_moves, double friction) noexcept
{
    return Slide(surface, radius, to, scratch, friction).run(from, start, max_moves);
}

} // namespace proxima
