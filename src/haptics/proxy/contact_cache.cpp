#include "haptics/proxy/contact_cache.h"

#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// The margin of a new ball beyond its query, in mean edges, at first. Later it adapts to a number of
/// groups in this range: the proxy leaves smaller balls too soon, larger ones slow every scan.
constexpr double first_margin = 3;
constexpr std::size_t few_groups = 24;
constexpr std::size_t many_groups = 64;

/// The middle of a new ball is so far ahead of a motion, in parts of that margin.
constexpr double part_ahead = 0.6;

/// More than the error of differences and distances, in parts of coordinates.
constexpr double coordinate_rounding = 0x1p-44;

} // namespace

ContactCache::ContactCache()
    : boxes_(1), near_(1), ranks_(GroupBoxes::capacity * TriangleGroup::width),
      times_(ranks_.size())
{}

/// Forgets what was cached of another edition. False where nothing may be cached.
bool ContactCache::update_edition(const ContactSurface& surface) noexcept
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
    return update_edition(surface) && (p - center_).norm() + distance + rounding_ <= reach_;
}

std::size_t ContactCache::bypass(const ContactSurface& surface, const Vec3& p, const Vec3& motion,
                                 double distance, std::span<ContactTriangle> buffer) noexcept
{
    const std::size_t count = surface.collect_along(p, motion, distance, buffer);
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

/// Makes the ball cover a motion. False where there are too many groups.
bool ContactCache::cover(const ContactSurface& surface, const Vec3& p, const Vec3& motion,
                         double distance) noexcept
{
    const double length = motion.norm();
    const Vec3 middle = p + 0.5 * motion;
    const double around = distance + 0.5 * length;
    if (covers(surface, middle, around)) return true;
    // The motion will probably go on.
    const Vec3 ahead =
        length > 0 ? Vec3(motion * (part_ahead * margin_ / length)) : Vec3(Vec3::Zero());
    return fill(surface, middle + ahead, around) &&
           (covers(surface, middle, around) || fill(surface, middle, around));
}

std::size_t ContactCache::collect(const ContactSurface& surface, const Vec3& p, double distance,
                                  std::span<ContactTriangle> buffer) noexcept
{
    return collect_along(surface, p, Vec3::Zero(), distance, buffer);
}

std::size_t ContactCache::collect_along(const ContactSurface& surface, const Vec3& p,
                                        const Vec3& motion, double distance,
                                        std::span<ContactTriangle> buffer) noexcept
{
    begin_sweep(surface, p, motion, distance);
    if (bypasses_) return bypass(surface, p, motion, distance, buffer);
    const GroupsAlongSegment& near = near_.front();
    return scan(surface, std::span(near.ids).first(near.count), buffer);
}

void ContactCache::begin_sweep(const ContactSurface& surface, const Vec3& p, const Vec3& motion,
                               double distance) noexcept
{
    query_ = surface.group_query(p);
    query_.motion = motion;
    query_.distance = distance;
    bypasses_ = !update_edition(surface) || surface.groups().empty() ||
                !cover(surface, p, motion, distance);
    if (bypasses_) return;
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
    if (bypasses_) {
        near.count = 0;
        bypasses_ = false;
        const std::size_t count =
            bypass(surface, query_.position, query_.motion, query_.distance, buffer);
        for (std::size_t i = 0; i < std::min(count, buffer.size()); ++i) {
            times[i] = least_touch_time(buffer[i].corners, query_.distance, query_.position,
                                        query_.motion);
        }
        return count;
    }
    // Move the groups that are due to the front.
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
    if (!update_edition(surface) || !(free_ > 0)) return -1;
    const double rounding = coordinate_rounding * (surface.scale().reach + p.cwiseAbs().maxCoeff());
    return free_ - (p - free_center_).norm() - rounding;
}

double ContactCache::clearance(const ContactSurface& surface, const Vec3& p, double wanted) noexcept
{
    const double known = known_clearance(surface, p);
    if (known > std::max(wanted, 0.0)) return known;
    ++work_.distances;
    const double clearance = surface.clearance_beyond(p, wanted);
    if (update_edition(surface)) {
        free_center_ = p;
        free_ = clearance;
    }
    return clearance;
}

} // namespace proxima
