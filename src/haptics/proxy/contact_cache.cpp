#include "haptics/proxy/contact_cache.h"

#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// A new ball reaches so far beyond what was asked for, in mean edges, at first; then as far as
/// makes about so many groups: fewer are left too soon, more cost every scan.
constexpr double first_margin = 3;
constexpr std::size_t few_groups = 24;
constexpr std::size_t many_groups = 64;

/// A new ball on a way has its middle so far ahead, in parts of that margin.
constexpr double part_ahead = 0.6;

/// Of coordinates: more than differences of them and distances between are off by.
constexpr double coordinate_rounding = 0x1p-44;

} // namespace

ContactCache::ContactCache()
    : boxes_(1), near_(1), ranks_(GroupBoxes::capacity * TriangleGroup::width),
      times_(ranks_.size())
{}

bool ContactCache::keeps(const ContactSurface& surface) noexcept
{
    const std::uint64_t edition = surface.edition();
    if (edition == 0) return false;
    if (edition == edition_) return true;
    edition_ = edition;
    reach_ = -1;
    free_ = -1;
    margin_ = first_margin * surface.scale().mean_edge;
    return true;
}

bool ContactCache::fill(const ContactSurface& surface, const Vec3& p, double distance) noexcept
{
    constexpr int attempts = 6;
    reach_ = -1;
    GroupBoxes& boxes = boxes_.front();
    for (int attempt = 0; attempt < attempts; ++attempt) {
        const double reach = distance + margin_;
        surface.find_groups(p, reach, boxes);
        ++work_.gathers;
        work_.gathered += boxes.count * TriangleGroup::width;
        if (boxes.count > GroupBoxes::capacity) {
            margin_ /= 2;
            continue;
        }
        center_ = p;
        reach_ = reach;
        rounding_ = coordinate_rounding * (surface.scale().reach + p.cwiseAbs().maxCoeff() + reach);
        if (boxes.count < few_groups) margin_ *= 1.25;
        if (boxes.count > many_groups && margin_ > 0.5 * distance) margin_ *= 0.8;
        margin_ = std::min(margin_, surface.scale().extent);
        return true;
    }
    return false;
}

bool ContactCache::covers(const ContactSurface& surface, const Vec3& p, double distance) noexcept
{
    return keeps(surface) && (p - center_).norm() + distance + rounding_ <= reach_;
}

std::size_t ContactCache::ask(const ContactSurface& surface, const Vec3& p, const Vec3& way,
                              double distance, std::span<ContactTriangle> buffer) noexcept
{
    const std::size_t count = surface.collect_along(p, way, distance, buffer);
    ++work_.gathers;
    work_.gathered += count;
    work_.passed += count;
    return count;
}

std::size_t ContactCache::scan(const ContactSurface& surface, std::span<const std::uint32_t> groups,
                               std::span<ContactTriangle> buffer) noexcept
{
    const std::size_t count = scan_groups(surface.groups(), groups, query_, ranks_, times_);
    surface.read_triangles(std::span(ranks_).first(std::min(count, buffer.size())), buffer);
    work_.passed += count;
    return count;
}

/// Sees to it that the ball has all that is near a way. False where there is too much.
bool ContactCache::reach_out(const ContactSurface& surface, const Vec3& p, const Vec3& way,
                             double distance) noexcept
{
    const double length = way.norm();
    const Vec3 middle = p + 0.5 * way;
    const double around = distance + 0.5 * length;
    if (covers(surface, middle, around)) return true;
    // Who is on the way goes on.
    const Vec3 ahead =
        length > 0 ? Vec3(way * (part_ahead * margin_ / length)) : Vec3(Vec3::Zero());
    return fill(surface, middle + ahead, around) &&
           (covers(surface, middle, around) || fill(surface, middle, around));
}

std::size_t ContactCache::collect(const ContactSurface& surface, const Vec3& p, double distance,
                                  std::span<ContactTriangle> buffer) noexcept
{
    return collect_along(surface, p, Vec3::Zero(), distance, buffer);
}

std::size_t ContactCache::collect_along(const ContactSurface& surface, const Vec3& p,
                                        const Vec3& way, double distance,
                                        std::span<ContactTriangle> buffer) noexcept
{
    begin_sweep(surface, p, way, distance);
    if (asks_) return ask(surface, p, way, distance, buffer);
    const GroupsAlongSegment& near = near_.front();
    return scan(surface, std::span(near.ids).first(near.count), buffer);
}

void ContactCache::begin_sweep(const ContactSurface& surface, const Vec3& p, const Vec3& way,
                               double distance) noexcept
{
    query_ = surface.group_query(p);
    query_.way = way;
    query_.distance = distance;
    asks_ = !keeps(surface) || surface.groups().empty() || !reach_out(surface, p, way, distance);
    if (asks_) return;
    query_.rounding = rounding_;
    groups_along_segment(boxes_.front(), query_, near_.front());
    ++work_.scans;
    work_.scanned += boxes_.front().count;
}

std::size_t ContactCache::next_before(const ContactSurface& surface, double part,
                                      std::span<ContactTriangle> buffer,
                                      std::span<double> times) noexcept
{
    GroupsAlongSegment& near = near_.front();
    if (asks_) {
        near.count = 0;
        asks_ = false;
        const std::size_t count = ask(surface, query_.place, query_.way, query_.distance, buffer);
        for (std::size_t i = 0; i < std::min(count, buffer.size()); ++i) {
            times[i] =
                least_touch_time(buffer[i].corners, query_.distance, query_.place, query_.way);
        }
        return count;
    }
    // Those that are looked at now first.
    std::size_t now = 0;
    for (std::size_t i = 0; i < near.count; ++i) {
        if (near.times[i] > part) continue;
        std::swap(near.ids[i], near.ids[now]);
        std::swap(near.times[i], near.times[now++]);
    }
    if (now == 0) return 0;
    const std::size_t count = scan(surface, std::span(near.ids).first(now), buffer);
    std::copy_n(times_.begin(), std::min(count, buffer.size()), times.begin());
    near.count -= now;
    std::copy_n(near.ids.begin() + now, near.count, near.ids.begin());
    std::copy_n(near.times.begin() + now, near.count, near.times.begin());
    return count;
}

double ContactCache::known_clearance(const ContactSurface& surface, const Vec3& p) noexcept
{
    if (!keeps(surface) || !(free_ > 0)) return -1;
    const double rounding = coordinate_rounding * (surface.scale().reach + p.cwiseAbs().maxCoeff());
    return free_ - (p - free_center_).norm() - rounding;
}

double ContactCache::clearance(const ContactSurface& surface, const Vec3& p, double wanted) noexcept
{
    const double known = known_clearance(surface, p);
    if (known > std::max(wanted, 0.0)) return known;
    ++work_.distances;
    const double clearance = surface.clearance_beyond(p, wanted);
    if (keeps(surface)) {
        free_center_ = p;
        free_ = clearance;
    }
    return clearance;
}

} // namespace proxima
