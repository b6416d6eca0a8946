#include "haptics/proxy/sphere_contacts.h"

#include "haptics/proxy/contact_planes.h"
#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

bool is_same(const Contact& a, const Contact& b, double rounding) noexcept
{
    if (a.part == TrianglePart::inside && b.part == TrianglePart::inside)
        return a.normal.cross(b.normal).squaredNorm() < 1e-29 && a.normal.dot(b.normal) > 0;
    return (a.point - b.point).squaredNorm() <= rounding * rounding;
}

/// Faces before sides and corners, then by id.
bool replaces(const Contact& a, const Contact& b) noexcept
{
    const bool a_inside = a.part == TrianglePart::inside;
    const bool b_inside = b.part == TrianglePart::inside;
    return a_inside != b_inside ? a_inside : a.triangle < b.triangle;
}

/// Whether a centre that slides along the face comes no nearer than `least` to the side or corner.
bool covers(const Contact& face, const Contact& edge, const Vec3& p, double least) noexcept
{
    return face.part == TrianglePart::inside && edge.part != TrianglePart::inside &&
           face.normal.dot(p - edge.point) >= least;
}

/// Whether the triangle's box is beyond. `limit` includes the rounding of coordinate differences.
bool is_beyond(const Triangle& triangle, const Vec3& p, double limit) noexcept
{
    const Vec3 lower = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]);
    const Vec3 upper = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
    return ((lower - p).cwiseMax(p - upper).array() > limit).any();
}

constexpr std::size_t touched_triangles = 4096;

/// In roundings: the limit less this is what a slide lets come near (slide_sphere.cpp) but for two of
/// its skins.
constexpr double cover = 12;

} // namespace

std::optional<Contact> contact_with(const ContactTriangle& triangle, const Vec3& p, double limit,
                                    double rounding) noexcept
{
    const TrianglePlane plane(triangle.corners);
    if (plane.is_beyond(p, Vec3::Zero(), limit)) return std::nullopt;
    if (least_touch_time(triangle.corners, limit, p, Vec3::Zero()) > 0) return std::nullopt;
    const Vec3 face = plane.normal();
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
    // Above the face its normal is more accurate than the difference of two near points.
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

SphereContacts::SphereContacts() : contacts_(max_contact_planes), touched_(touched_triangles) {}

void SphereContacts::clear() noexcept
{
    count_ = 0;
    touched_count_ = 0;
    edition_ = 0;
}

bool SphereContacts::has(TriangleId id) const noexcept
{
    const auto touched = std::span(touched_).first(touched_count_);
    return std::ranges::binary_search(touched, id, {}, &Contact::triangle);
}

bool SphereContacts::add(const Contact& contact, double rounding) noexcept
{
    for (Contact& other : std::span(contacts_).first(count_)) {
        if (!is_same(other, contact, rounding)) continue;
        if (replaces(contact, other)) other = contact;
        return true;
    }
    if (count_ == contacts_.size()) return false;
    contacts_[count_++] = contact;
    return true;
}

/// A centre that rounding leaves too low over a face meets the side of the next face, and by the
/// square root of that rounding. Where both faces are almost coplanar that side is no edge, and its
/// tilted normal must not hold the centre back.
void SphereContacts::drop_covered(const Vec3& p, double least) noexcept
{
    const auto all = std::span(contacts_).first(count_);
    const auto is_covered = [&](const Contact& contact) {
        return std::ranges::any_of(
            all, [&](const Contact& face) { return covers(face, contact, p, least); });
    };
    // Faces, which cover, must not move until all sides and corners are tested. (The algorithms of
    // ranges that return subranges do not compile with clang 14.)
    const auto edges = std::partition(all.begin(), all.end(), [](const Contact& contact) {
        return contact.part == TrianglePart::inside;
    });
    count_ = static_cast<std::size_t>(std::remove_if(edges, all.end(), is_covered) - all.begin());
}

bool SphereContacts::is_known(const ContactSurface& surface, const Vec3& p,
                              double limit) const noexcept
{
    const std::uint64_t edition = surface.edition();
    return edition != 0 && edition == edition_ && p == position_ && limit == limit_;
}

bool SphereContacts::find(ContactCache& cache, const ContactSurface& surface, const Vec3& p,
                          double limit, double rounding, std::span<ContactTriangle> near) noexcept
{
    if (is_known(surface, p, limit)) return true;
    clear();
    const std::size_t found = cache.collect(surface, p, limit, near);
    return found <= near.size() && find_among(near.first(found), surface, p, limit, rounding);
}

bool SphereContacts::find_among(std::span<const ContactTriangle> near,
                                const ContactSurface& surface, const Vec3& p, double limit,
                                double rounding) noexcept
{
    if (is_known(surface, p, limit)) return true;
    clear();
    for (const ContactTriangle& triangle : near) {
        if (is_beyond(triangle.corners, p, limit)) continue;
        const auto contact = contact_with(triangle, p, limit, rounding);
        if (!contact) continue;
        if (touched_count_ == touched_.size()) return false;
        touched_[touched_count_++] = *contact;
    }
    // Which contacts merge depends on their order: sort by id, whatever the order of `near`.
    const auto touched = std::span(touched_).first(touched_count_);
    std::ranges::sort(touched, {}, &Contact::triangle);
    for (const Contact& contact : touched)
        if (!add(contact, rounding)) return false;
    drop_covered(p, limit - cover * rounding);
    std::ranges::sort(std::span(contacts_).first(count_), {}, &Contact::triangle);
    position_ = p;
    limit_ = limit;
    edition_ = surface.edition();
    return true;
}

} // namespace proxima
