// The built-in ship: lofted parts, as fine as the size allows, and plating up to the exact count.
#include "base/progress.h"
#include "base/text.h"
#include "mesh/plating.h"
#include "mesh/spaceship_parts.h"
#include "mesh/unit_circle.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

using detail::Dice;
using detail::Direction;
using detail::Outline;
using detail::QuadSurface;
using detail::Section;
using detail::ShipPart;

constexpr double smooth_share = 0.4; ///< of the triangles, for the parts before plating

// A section's outline in units of its half sizes.
CirclePoint outline_point(Outline outline, std::uint32_t step, std::uint32_t count) noexcept
{
    const auto [c, s] = unit_circle(step, count);
    switch (outline) {
    case Outline::round:
        return {c, s};
    case Outline::box: {
        const double reach = std::max(std::abs(c), std::abs(s));
        return {c / reach, s / reach};
    }
    case Outline::chamfered:
        break;
    }
    const double c2 = c * c;
    const double s2 = s * s;
    const double reach = std::sqrt(std::sqrt(c2 * c2 + s2 * s2)); // x^4 + y^4 = 1
    return {c / reach, s / reach};
}

Vec3 position_on(const ShipPart& part, double along, double across, double lift) noexcept
{
    switch (part.direction) {
    case Direction::forward:
        return part.origin + Vec3(along, across, lift);
    case Direction::to_port:
        return part.origin + Vec3(across, along, lift);
    case Direction::to_starboard:
        return part.origin + Vec3(across, 0.0 - along, lift);
    case Direction::up:
        break;
    }
    return part.origin + Vec3(across, lift, along);
}

Section between(const Section& a, const Section& b, double t) noexcept
{
    const auto blend = [t](double from, double to) { return from + (to - from) * t; };
    return {blend(a.along, b.along), blend(a.across, b.across), blend(a.lift, b.lift),
            blend(a.half_across, b.half_across), blend(a.half_lift, b.half_lift)};
}

// Level n has n times the segments, and n rings where the drawing has one.
std::size_t lofted_triangles(const ShipPart& part, std::size_t level) noexcept
{
    const std::size_t rings = (part.sections.size() - 1) * level + 1;
    return std::size_t{2} * part.segments * level * rings;
}

std::size_t lofted_triangles(std::span<const ShipPart> parts, std::size_t level) noexcept
{
    std::size_t total = 0;
    for (const ShipPart& part : parts) total += lofted_triangles(part, level);
    return total;
}

// One closed component: rings of vertices, quads between them, a fan at either end.
class Loft {
public:
    Loft(QuadSurface& surface, const ShipPart& part, std::uint32_t level, Dice dice)
        : surface_(surface), part_(part), level_(level), segments_(part.segments * level),
          first_(static_cast<std::uint32_t>(surface.positions.size())), dice_(dice)
    {}

    /// False where `steps`, of triangles, asks to stop.
    bool add(StageSteps& steps)
    {
        const auto intervals = static_cast<std::uint32_t>(part_.sections.size() - 1);
        for (std::uint32_t interval = 0; interval < intervals; ++interval) {
            for (std::uint32_t step = 0; step < level_; ++step) {
                add_ring(between(part_.sections[interval], part_.sections[interval + 1],
                                 static_cast<double>(step) / static_cast<double>(level_)));
                if (!steps.done(segments_)) return false;
            }
        }
        add_ring(part_.sections.back());
        if (!add_quads(intervals, steps)) return false;
        add_caps(intervals * level_);
        return true;
    }

private:
    void add_ring(const Section& section)
    {
        for (std::uint32_t segment = 0; segment < segments_; ++segment) {
            const auto [across, lift] = outline_point(part_.outline, segment, segments_);
            surface_.positions.push_back(position_on(part_, section.along,
                                                     section.across + section.half_across * across,
                                                     section.lift + section.half_lift * lift));
        }
    }

    // Neighbouring quads share how much grows on them, by the cells of the drawing.
    bool add_quads(std::uint32_t intervals, StageSteps& steps)
    {
        for (std::uint32_t interval = 0; interval < intervals; ++interval) {
            std::vector<double> details(part_.segments);
            for (double& detail : details) detail = part_.detail * cell_detail();
            for (std::uint32_t ring = interval * level_; ring < (interval + 1) * level_; ++ring) {
                for (std::uint32_t segment = 0; segment < segments_; ++segment) {
                    surface_.quads.push_back(
                        {{vertex(ring, segment), vertex(ring, segment + 1),
                          vertex(ring + 1, segment + 1), vertex(ring + 1, segment)},
                         details[segment / level_]});
                    if (is_mirrored()) std::swap(last_corners()[1], last_corners()[3]);
                }
                if (!steps.done(segments_)) return false;
            }
        }
        return true;
    }

    void add_caps(std::uint32_t last_ring)
    {
        const auto [front, back] = std::pair(part_.sections.back(), part_.sections.front());
        surface_.positions.push_back(position_on(part_, back.along, back.across, back.lift));
        surface_.positions.push_back(position_on(part_, front.along, front.across, front.lift));
        const auto front_center = static_cast<std::uint32_t>(surface_.positions.size() - 1);
        const std::uint32_t back_center = front_center - 1;
        for (std::uint32_t segment = 0; segment < segments_; ++segment) {
            add_triangle({back_center, vertex(0, segment + 1), vertex(0, segment)});
            add_triangle(
                {front_center, vertex(last_ring, segment), vertex(last_ring, segment + 1)});
        }
    }

    void add_triangle(TriangleCorners corners)
    {
        if (is_mirrored()) std::swap(corners[1], corners[2]);
        surface_.triangles.push_back(corners);
    }

    // A left-handed frame reverses orientation, so every face is reversed as well.
    [[nodiscard]] bool is_mirrored() const noexcept
    {
        return part_.direction == Direction::to_port;
    }

    [[nodiscard]] std::array<std::uint32_t, 4>& last_corners() noexcept
    {
        return surface_.quads.back().corners;
    }

    [[nodiscard]] std::uint32_t vertex(std::uint32_t ring, std::uint32_t segment) const noexcept
    {
        return first_ + ring * segments_ + segment % segments_;
    }

    // Density is uneven on purpose, from bare plates to crowded ones, 1 : 64.
    [[nodiscard]] double cell_detail() noexcept
    {
        return std::ldexp(1.0, -static_cast<int>(dice_.next() % 7));
    }

    QuadSurface& surface_;
    const ShipPart& part_;
    std::uint32_t level_;
    std::uint32_t segments_;
    std::uint32_t first_;
    Dice dice_;
};

tl::unexpected<Error> making_cancelled(std::size_t triangles)
{
    return cancelled("making the mesh", concat("spaceship:", triangles));
}

Result<TriangleMesh> triangulated(QuadSurface surface, std::size_t triangles, StageSteps& steps)
{
    std::vector<TriangleCorners> corners = std::move(surface.triangles);
    corners.reserve(triangles);
    for (const auto& [quad, detail] : surface.quads) {
        corners.push_back({quad[0], quad[1], quad[2]});
        corners.push_back({quad[0], quad[2], quad[3]});
        if (!steps.done(2)) return making_cancelled(triangles);
    }
    return make_triangle_mesh(std::move(surface.positions), std::move(corners));
}

} // namespace

Result<TriangleMesh> make_spaceship(std::size_t triangles, const SampleOptions& options)
{
    if (triangles < min_spaceship_triangles || triangles % 2 != 0) {
        return fail(ErrorCode::invalid_argument,
                    concat("the ship is a closed surface and needs an even number of triangles, "
                           "at least ",
                           min_spaceship_triangles, ", not ", triangles),
                    concat("spaceship:", triangles));
    }
    if (triangles > max_sample_triangles) {
        return fail(
            ErrorCode::limit_exceeded,
            concat("the ship has at most ", max_sample_triangles, " triangles, not ", triangles),
            concat("spaceship:", triangles));
    }
    const std::vector<ShipPart> parts = detail::ship_parts();
    const auto smooth = static_cast<std::size_t>(smooth_share * static_cast<double>(triangles));
    std::uint32_t level = 1;
    while (lofted_triangles(parts, level + 1) <= smooth) ++level;

    // Most triangles are counted twice: when their quad grows, and when it is cut.
    StageSteps steps(options.execution.progress, "making mesh", 2 * triangles);
    QuadSurface surface;
    Dice dice(33000);
    for (const ShipPart& part : parts) {
        if (!Loft(surface, part, level, Dice(dice.next())).add(steps)) {
            return making_cancelled(triangles);
        }
    }
    if (!detail::grow_plating(surface, triangles, dice, steps)) return making_cancelled(triangles);
    return triangulated(std::move(surface), triangles, steps);
}

} // namespace proxima
