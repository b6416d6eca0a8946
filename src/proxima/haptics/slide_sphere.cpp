#include "proxima/haptics/slide_sphere.h"

#include "proxima/haptics/swept_sphere.h"

#include <algorithm>
#include <cmath>
#include <optional>

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

/// The touching point as a plane, or nothing where the triangle is beyond `limit`.
std::optional<Contact> contact_with(const ContactTriangle& triangle, const Vec3& p, double limit,
                                    double rounding) noexcept
{
    const Vec3 face = unit_normal(triangle.corners);
    const double height = face.dot(p - triangle.corners[0]);
    if (std::abs(height) > limit) return std::nullopt;
    const TrianglePoint closest = closest_point(triangle.corners, p);
    const Vec3 away = p - closest.point;
    const double distance = away.norm();
    if (distance > limit) return std::nullopt;
    Contact contact;
    contact.point = closest.point;
    contact.triangle = triangle.id;
    contact.part = closest.part;
    // Straight above, the face's normal is more exact than the difference of two near points.
    const double aside = std::sqrt(std::max(0.0, distance * distance - height * height));
    if (closest.part == TrianglePart::inside || aside <= rounding || !(distance > 0)) {
        contact.part = TrianglePart::inside;
        contact.normal = height >= 0 ? face : Vec3(-face);
    } else {
        contact.normal = away / distance;
        if (closest.part >= TrianglePart::side_0) {
            const int k = static_cast<int>(closest.part) - static_cast<int>(TrianglePart::side_0);
            contact.side = (triangle.corners[(k + 1) % 3] - triangle.corners[k]).normalized();
        }
    }
    return contact;
}

/// What is touched at one place, by triangle id; contacts of several triangles at the same vertex
/// or edge once.
class Touches {
public:
    /// \pre there is room
    Touches(std::span<Contact> room, double rounding) noexcept : contacts_(room), rounding_(rounding)
    {}

    /// False where there is no room.
    [[nodiscard]] bool add(const Contact& contact) noexcept
    {
        for (std::size_t i = 0; i < count_; ++i) {
            if (!is_same(contacts_[i], contact)) continue;
            if (replaces(contact, contacts_[i])) contacts_[i] = contact;
            return true;
        }
        if (count_ == contacts_.size()) return false;
        contacts_[count_++] = contact;
        return true;
    }
    void sort() noexcept
    {
        const std::span<Contact> used = contacts_.first(count_);
        std::sort(used.begin(), used.end(),
                  [](const Contact& a, const Contact& b) { return a.triangle < b.triangle; });
    }
    [[nodiscard]] std::span<const Contact> contacts() const noexcept
    {
        return contacts_.first(count_);
    }

private:
    [[nodiscard]] bool is_same(const Contact& a, const Contact& b) const noexcept
    {
        if (a.part == TrianglePart::inside && b.part == TrianglePart::inside) {
            return a.normal.cross(b.normal).squaredNorm() < 1e-29 && a.normal.dot(b.normal) > 0;
        }
        return (a.point - b.point).squaredNorm() <= rounding_ * rounding_;
    }
    /// Faces before sides and corners, then by id.
    [[nodiscard]] static bool replaces(const Contact& a, const Contact& b) noexcept
    {
        const bool a_inside = a.part == TrianglePart::inside;
        const bool b_inside = b.part == TrianglePart::inside;
        return a_inside != b_inside ? a_inside : a.triangle < b.triangle;
    }

    std::span<Contact> contacts_;
    double rounding_;
    std::size_t count_ = 0;
};

} // namespace

double safety_gap(const SurfaceScale& scale) noexcept
{
    return std::max(0x1p-30 * scale.extent, 0x1p-38 * scale.reach);
}

/// One slide: see slide_sphere.h.
class Slide {
public:
    Slide(const ContactSurface& surface, double radius, const Vec3& to, SlideRoom& room) noexcept
        : surface_(surface), gap_(safety_gap(surface.scale())), radius_(std::max(radius, gap_)),
          skin_(skin_of(surface.scale())), to_(to), room_(room)
    {}

    SlideResult run(const Vec3& from, SlideStart start) noexcept
    {
        result_.center = from;
        room_.path_[0] = from;
        room_.path_size_ = 1;
        if (start == SlideStart::touching || !reach_freely()) {
            result_.end = SlideEnd::limited;
            while (result_.moves < max_slide_moves && move()) {
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
        const double clearance = room_.cache_.clearance(surface_, result_.center, wanted);
        touches_nothing_ = clearance > radius_ + skin_;
        if (clearance <= wanted) return false;
        result_.held = to_;
        if (way > 0) go(to_);
        return true;
    }

    void go(const Vec3& place) noexcept
    {
        result_.center = place;
        ++result_.moves;
        room_.path_[room_.path_size_++] = place;
    }

    /// One goal and the way there. False when the slide is over.
    bool move() noexcept
    {
        const Vec3 p = result_.center;
        Touches touches(room_.contacts_, 0.25 * skin_);
        if (!collect_touches(touches)) return end(SlideEnd::overloaded);
        const Vec3 goal = choose_goal(touches.contacts());

        Vec3 way = goal - p;
        const double length = way.norm();
        if (length <= 0.25 * skin_) return end(SlideEnd::settled);
        double reach = std::min(length, reach_in_edges * surface_.scale().mean_edge);
        if (!collect_way(way / length, reach)) return end(SlideEnd::overloaded);
        const bool whole = reach == length;
        if (!whole) way *= reach / length;
        const double t = sweep(way, touches.contacts());
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
    bool collect_touches(Touches& touches) noexcept
    {
        touched_count_ = 0;
        if (touches_nothing_) return true;
        const double limit = radius_ + skin_;
        const std::size_t count = room_.cache_.collect(surface_, result_.center, limit, room_.near_);
        if (count > room_.near_.size()) return false;
        for (const ContactTriangle& triangle : std::span(room_.near_).first(count)) {
            const auto contact = contact_with(triangle, result_.center, limit, 0.25 * skin_);
            if (!contact) continue;
            room_.touched_[touched_count_++] = triangle.id;
            if (!touches.add(*contact)) return false;
        }
        touches.sort();
        return true;
    }

    /// Triangles along the first `reach` of a direction; a shorter reach where there are too many.
    bool collect_way(const Vec3& direction, double& reach) noexcept
    {
        for (int attempt = 0; attempt < 12; ++attempt) {
            const Vec3 middle = result_.center + 0.5 * reach * direction;
            const double distance = radius_ + 2 * skin_ + 0.5 * reach;
            near_count_ = room_.cache_.collect(surface_, middle, distance, room_.near_);
            if (near_count_ <= room_.near_.size()) return true;
            reach /= 2;
        }
        return false;
    }

    bool end(SlideEnd how) noexcept
    {
        result_.end = how;
        if (result_.contact_count == 0) result_.held = result_.center;
        return false;
    }

    /// The nearest place to the wanted one that the contacts allow; notes what holds it back.
    Vec3 choose_goal(std::span<const Contact> touched) noexcept
    {
        result_.contact_count = 0;
        result_.held = to_;
        std::array<ContactPlane, max_contact_planes> planes; // NOLINT
        for (std::size_t i = 0; i < touched.size(); ++i) {
            const Contact& contact = touched[i];
            planes[i] = {contact.normal, contact.normal.dot(to_ - contact.point) - radius_};
        }
        const auto used = std::span(planes).first(touched.size());
        const PlaneSolution solution = nearest_allowed(used, skin_);
        if (solution.count == 0) return to_;
        for (std::size_t i = 0; i < solution.count; ++i) {
            Contact& contact = result_.contacts[i];
            contact = touched[solution.active[i]];
            contact.pressure = solution.pressure[i];
        }
        result_.contact_count = solution.count;
        Vec3 goal = to_ + solution.shift;
        result_.held = radius_ > gap_ ? goal : held_at_surface(used);
        if (!has_contact_) {
            has_contact_ = true;
            result_.first_contact = result_.moves;
        }
        if (solution.count == 1 && touched.size() == 1 && radius_ > gap_)
            return around(result_.contacts[0], goal);
        return goal;
    }

    /// What the planes allow without the safety gap.
    [[nodiscard]] Vec3 held_at_surface(std::span<ContactPlane> planes) const noexcept
    {
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
        const auto touched_ids = std::span(room_.touched_).first(touched_count_);
        double free = 1;
        for (const ContactTriangle& near : std::span(room_.near_).first(near_count_)) {
            const auto t = touch_time(near.corners, radius_, result_.center, way);
            if (!t || *t >= free) continue;
            // What is touched already is left or gone along.
            if (std::find(touched_ids.begin(), touched_ids.end(), near.id) != touched_ids.end())
                continue;
            free = *t;
        }
        return free;
    }

    const ContactSurface& surface_;
    double gap_;
    double radius_;
    double skin_;
    Vec3 to_;
    SlideRoom& room_;
    std::size_t near_count_ = 0;
    std::size_t touched_count_ = 0;
    bool touches_nothing_ = false;
    bool has_contact_ = false;
    SlideResult result_;
};

std::optional<Contact> nearest_contact(const ContactSurface& surface, const Vec3& p,
                                       double distance, SlideRoom& room) noexcept
{
    const std::span<ContactTriangle> near = room.near_;
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
                         const Vec3& to, SlideRoom& room, SlideStart start) noexcept
{
    return Slide(surface, radius, to, room).run(from, start);
}

} // namespace proxima
