#include "mesh/triangulate_polygon.h"

#include "base/check.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

// Twice the polygon's area along its normal, from its first corner (Newell).
Vec3 area_vector(std::span<const std::uint32_t> corners, std::span<const Vec3> positions)
{
    const Vec3& origin = positions[corners[0]];
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 2; i < corners.size(); ++i) {
        area += (positions[corners[i - 1]] - origin).cross(positions[corners[i]] - origin);
    }
    return area;
}

bool is_fan(std::span<const std::uint32_t> corners, std::span<const Vec3> positions,
            const Vec3& area)
{
    const Vec3& origin = positions[corners[0]];
    for (std::size_t i = 2; i < corners.size(); ++i) {
        const Vec3 normal =
            (positions[corners[i - 1]] - origin).cross(positions[corners[i]] - origin);
        if (!(normal.dot(area) > 0)) return false;
    }
    return true;
}

// Positive where a, b, c turn counter-clockwise.
double orientation(const Vec2& a, const Vec2& b, const Vec2& c) noexcept
{
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

} // namespace

bool PolygonTriangulator::triangulate(std::span<const std::uint32_t> corners,
                                      std::span<const Vec3> positions,
                                      std::span<TriangleCorners> triangles)
{
    PROXIMA_CHECK_GE(corners.size(), 3U);
    PROXIMA_CHECK_EQ(triangles.size() + 2, corners.size());
    double extent = 0;
    for (const std::uint32_t corner : corners) {
        extent =
            std::max(extent, (positions[corner] - positions[corners[0]]).cwiseAbs().maxCoeff());
    }
    // Products of four lengths are compared.
    const bool has_products = extent > 0x1p-200 && extent < 0x1p200;
    if (corners.size() == 3 || has_products || !(extent > 0) || !std::isfinite(extent))
        return triangulate_scaled(corners, positions, triangles);
    const double scale = std::ldexp(1.0, std::clamp(-std::ilogb(extent), -1000, 1000));
    std::vector<Vec3> scaled;
    std::vector<std::uint32_t> numbers;
    for (const std::uint32_t corner : corners) {
        numbers.push_back(static_cast<std::uint32_t>(numbers.size()));
        scaled.emplace_back((positions[corner] - positions[corners[0]]) * scale);
    }
    if (!triangulate_scaled(numbers, scaled, triangles)) return false;
    for (TriangleCorners& triangle : triangles)
        for (std::uint32_t& corner : triangle) corner = corners[corner];
    return true;
}

/// \pre the polygon's extent is such that products of four lengths are doubles
bool PolygonTriangulator::triangulate_scaled(std::span<const std::uint32_t> corners,
                                             std::span<const Vec3> positions,
                                             std::span<TriangleCorners> triangles)
{
    const Vec3 area = area_vector(corners, positions);
    const bool has_area = area.allFinite() && !area.isZero(0);
    if (corners.size() == 3 || !has_area || is_fan(corners, positions, area)) {
        for (std::size_t i = 2; i < corners.size(); ++i) {
            triangles[i - 2] = {corners[0], corners[i - 1], corners[i]};
        }
        return true;
    }
    if (corners.size() > max_concave_corners) return false;

    flatten(corners, positions, area);
    std::size_t head = 0;
    for (TriangleCorners& triangle : triangles) {
        std::uint32_t ear = 0;
        bool found = false;
        while (!found && head < queue_.size()) {
            ear = queue_[head++];
            ring_[ear].waiting = false;
            found = !ring_[ear].removed && is_ear(ear);
        }
        if (!found) ear = corner_of_last_resort();
        const std::uint32_t previous = ring_[ear].previous;
        const std::uint32_t next = ring_[ear].next;
        triangle = {corners[previous], corners[ear], corners[next]};
        remove(ear);
    }
    return true;
}

// Drops the axis along which the polygon's plane is steepest, keeping its orientation.
void PolygonTriangulator::flatten(std::span<const std::uint32_t> corners,
                                  std::span<const Vec3> positions, const Vec3& area)
{
    Eigen::Index dropped = 0;
    area.cwiseAbs().maxCoeff(&dropped);
    Eigen::Index first = (dropped + 1) % 3;
    Eigen::Index second = (dropped + 2) % 3;
    if (area[dropped] < 0) std::swap(first, second);

    const auto count = static_cast<std::uint32_t>(corners.size());
    const Vec3& origin = positions[corners[0]];
    ring_.assign(count, {});
    queue_.clear();
    blockers_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 from_origin = positions[corners[i]] - origin;
        ring_[i].position = {from_origin[first], from_origin[second]};
        ring_[i].previous = i == 0 ? count - 1 : i - 1;
        ring_[i].next = i + 1 == count ? 0 : i + 1;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        ring_[i].blocks = !(turn(i) > 0);
        if (ring_[i].blocks) blockers_.push_back(i);
        enqueue(i);
    }
}

double PolygonTriangulator::turn(std::uint32_t corner) const noexcept
{
    const Corner& middle = ring_[corner];
    return orientation(ring_[middle.previous].position, middle.position,
                       ring_[middle.next].position);
}

bool PolygonTriangulator::is_ear(std::uint32_t corner)
{
    if (!(turn(corner) > 0)) return false;
    const Vec2& a = ring_[ring_[corner].previous].position;
    const Vec2& b = ring_[corner].position;
    const Vec2& c = ring_[ring_[corner].next].position;
    const auto blocks = [&](std::uint32_t other) {
        const Vec2& p = ring_[other].position;
        // Corners at equal positions, such as those of a bridge to a hole, touch the ear and do not
        // block it.
        if (p == a || p == b || p == c) return false;
        return orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0;
    };
    return std::ranges::none_of(
        blockers_, [&](std::uint32_t other) { return ring_[other].blocks && blocks(other); });
}

// Where no ear is left the polygon is not simple, or rounding hides its ears. A corner without area
// does the least harm; a convex one the next least.
std::uint32_t PolygonTriangulator::corner_of_last_resort() const noexcept
{
    std::uint32_t first = 0;
    while (ring_[first].removed) ++first;
    std::uint32_t convex = first;
    std::uint32_t corner = first;
    do {
        const double area = turn(corner);
        if (area == 0) return corner;
        if (area > 0 && !(turn(convex) > 0)) convex = corner;
        corner = ring_[corner].next;
    } while (corner != first);
    return convex;
}

// The two neighbours may be ears now. Where they became convex they no longer block other ears.
void PolygonTriangulator::remove(std::uint32_t corner)
{
    const std::uint32_t previous = ring_[corner].previous;
    const std::uint32_t next = ring_[corner].next;
    ring_[corner].removed = true;
    ring_[corner].blocks = false;
    ring_[previous].next = next;
    ring_[next].previous = previous;
    for (const std::uint32_t neighbour : {previous, next}) {
        ring_[neighbour].blocks = !(turn(neighbour) > 0);
        enqueue(neighbour);
    }
}

void PolygonTriangulator::enqueue(std::uint32_t corner)
{
    if (ring_[corner].waiting) return;
    ring_[corner].waiting = true;
    queue_.push_back(corner);
}

} // namespace proxima
