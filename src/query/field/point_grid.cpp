#include "base/text.h"
#include "proxima/distance_field.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace proxima {

namespace {

tl::unexpected<Error> bad_grid(std::string what, const char* where)
{
    return fail(ErrorCode::invalid_argument, std::move(what), where);
}

} // namespace

Result<PointGrid> grid_around(const Box& box, const GridOptions& options)
{
    if (box.empty() || !box.lower.allFinite() || !box.upper.allFinite() ||
        !box.extent().allFinite())
        return bad_grid("the box is empty or not finite", "box");
    if (!(options.margin >= 0) || !std::isfinite(options.margin))
        return bad_grid("the margin is no finite number from 0 up", "margin");
    if (!(options.spacing >= 0) || !std::isfinite(options.spacing))
        return bad_grid("the spacing is no finite number from 0 up", "spacing");
    if (options.spacing == 0 && options.resolution < 2)
        return bad_grid("a resolution below 2 has no spacing", "resolution");
    const double longest = box.extent().maxCoeff();
    const Vec3 extent = box.extent() + Vec3::Constant(2 * options.margin * longest);
    if (!extent.allFinite()) return bad_grid("the margin makes the grid endless", "margin");
    PointGrid grid;
    grid.spacing =
        options.spacing > 0 ? options.spacing : extent.maxCoeff() / (options.resolution - 1.0);
    if (!(grid.spacing > 0)) return bad_grid("the box is too small: give a spacing", "spacing");
    double points = 1;
    std::array<double, 3> counts{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // One that a resolution divides evenly must not round to one point more.
        const double steps = extent[static_cast<Eigen::Index>(axis)] / grid.spacing;
        counts[axis] = std::max(std::ceil(steps * (1 - 0x1p-40)), 1.0) + 1;
        points *= counts[axis];
    }
    const bool by_spacing = options.spacing > 0;
    const char* const chosen = by_spacing ? "spacing" : "resolution";
    if (!(points <= static_cast<double>(max_grid_points))) {
        const std::string given = by_spacing ? concat(options.spacing) : concat(options.resolution);
        return bad_grid(
            concat("a ", chosen, " of ", given, " makes ", points, " points: 2^40 are the most"),
            chosen);
    }
    const Vec3 middle = box.center();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        if (counts[axis] > 0x1p31) return bad_grid("more than 2^31 points along an axis", chosen);
        grid.size[axis] = static_cast<std::uint32_t>(counts[axis]);
        grid.origin[k] = middle[k] - 0.5 * grid.spacing * (counts[axis] - 1);
    }
    return grid;
}

} // namespace proxima
