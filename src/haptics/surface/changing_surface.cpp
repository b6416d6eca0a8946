#include "haptics/surface/changing_surface.h"

#include "geometry/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

void ChangingSurface::set(const ChangingParts& parts, double part) noexcept
{
    parts_ = parts;
    part_ = part;
    edition_ = new_edition();
}

Triangle ChangingSurface::triangle(TriangleId id) const noexcept
{
    const TriangleCorners& corners = parts_.to->triangles()[to_index(id)];
    Triangle result;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& to = parts_.to->positions()[corners[k]];
        const Vec3& from = parts_.from->positions()[corners[k]];
        result.vertices[k] = part_ < 1 ? Vec3(from + part_ * (to - from)) : to;
    }
    return result;
}

std::size_t ChangingSurface::collect(const Vec3& p, double distance,
                                     std::span<ContactTriangle> buffer) const noexcept
{
    std::size_t count = 0;
    const auto offer = [&](TriangleId id) noexcept {
        const Triangle there = triangle(id);
        const Box box = bounding_box(there);
        const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
        if (gap.squaredNorm() > distance * distance) return;
        if (count < buffer.size()) buffer[count] = {there, id};
        ++count;
    };
    if (parts_.tree == nullptr) {
        for (std::uint32_t id = 0; id < parts_.to->triangle_count(); ++id) offer(TriangleId{id});
        return count;
    }
    visit_within(*parts_.tree, {p, p}, distance * distance, [&](RowRange ranks) noexcept {
        for (const TriangleId id : parts_.order.subspan(ranks.first, ranks.count)) offer(id);
        return count > buffer.size() ? Flow::stop : Flow::proceed;
    });
    return count;
}

double ChangingSurface::clearance(const Vec3& p) const noexcept
{
    double least = std::numeric_limits<double>::infinity();
    const auto offer = [&](TriangleId id) noexcept {
        least = std::min(least, (closest_point(triangle(id), p).point - p).squaredNorm());
    };
    if (parts_.tree == nullptr) {
        for (std::uint32_t id = 0; id < parts_.to->triangle_count(); ++id) offer(TriangleId{id});
    } else {
        visit_nearest(*parts_.tree, p, least, [&](RowRange ranks) noexcept {
            for (const TriangleId id : parts_.order.subspan(ranks.first, ranks.count)) offer(id);
            return least;
        });
    }
    return less_rounding(std::sqrt(least), scale(), p);
}

} // namespace proxima
