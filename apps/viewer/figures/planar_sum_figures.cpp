// Figures 3.1 to 3.6: the Minkowski sum of a triangle and a rectangle by pushing lines.
#include "proxima/execution.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/planar_panel.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>

namespace proxima {
namespace {

using namespace figure_colors;

constexpr std::size_t first_triangle_line = 0;  // n1
constexpr std::size_t first_rectangle_line = 3; // n4
constexpr double normal_length = 0.55;
constexpr double line_reach = 2.6; // of a pushed line, to each side

unsigned line_color(FacetOrigin origin)
{
    return origin == FacetOrigin::b ? red : blue;
}

PlanarPanel whole_panel(Figure& figure)
{
    figure.width = 900;
    figure.height = 720;
    return {figure, {Vec2(30, 30), Vec2(870, 690)}, {Vec2(-2.9, -2.1), Vec2(2.9, 2.3)}};
}

std::string point_name(int k)
{
    return fmt::format("v{}", k);
}

/// Corners of the sum in order.
std::vector<Vec2> outline_of(const PlanarSum& sum)
{
    std::vector<Vec2> corners;
    for (const PlanarEdge& edge : sum.edges())
        corners.push_back(sum.points()[static_cast<std::size_t>(edge.from)]);
    return corners;
}

/// The triangle, a copy of the rectangle at each of its corners, and all their corners.
void draw_copies(PlanarPanel& panel, const PlanarSum& sum)
{
    const auto& rectangle = sum.a().corners;
    const auto& triangle = sum.b().corners;
    panel.fill(triangle, red_tint);
    for (const Vec2& corner : triangle) {
        std::vector<Vec2> copy;
        copy.reserve(rectangle.size());
        for (const Vec2& point : rectangle) copy.emplace_back(corner + point);
        panel.fill(copy, blue_tint);
        panel.outline(copy, blue, 1.5);
    }
    panel.outline(triangle, red, 1.5);
    for (const Vec2& corner : triangle) panel.dot(corner, 7, red);
}

void name_points(PlanarPanel& panel, const PlanarSum& sum)
{
    for (std::size_t k = 0; k < sum.points().size(); ++k) {
        const Vec2 from_copy = sum.a().corners[k % sum.a().corners.size()];
        panel.words(sum.points()[k], point_name(static_cast<int>(k)),
                    {from_copy.x() > 0 ? 20.0 : -20.0, from_copy.y() > 0 ? 14.0 : -14.0}, 13, ink);
    }
}

void draw_points(PlanarPanel& panel, const PlanarSum& sum)
{
    for (const Vec2& point : sum.points()) panel.dot(point, 8, ink);
    name_points(panel, sum);
}

Result<FigureContent> pushing_figure(std::size_t number)
{
    const auto sum = explained_planar_sum();
    if (!sum) return tl::unexpected(sum.error());
    const PushedLine& line = sum->lines()[number];
    const auto ends = end_points(*sum, line);
    Figure figure;
    PlanarPanel panel = whole_panel(figure);
    draw_copies(panel, *sum);
    panel.words(Vec2::Zero(), "0", {-14, -14}, 14, ink);
    panel.words(0.4 * line.offset * line.normal, fmt::format("n{}", number + 1), {26, 4}, 16,
                green);
    name_points(panel, *sum);
    const Vec2 along(-line.normal.y(), line.normal.x());
    // From the origin outward in four steps, the last where it comes to rest.
    constexpr int steps = 4;
    for (int i = 0; i <= steps; ++i) {
        const Vec2 middle = line.offset * i / steps * line.normal;
        panel.dashes(middle - line_reach * along, middle + line_reach * along,
                     i == steps ? ink : faint, i == steps ? 2.5 : 1.5);
    }
    panel.line(sum->points()[static_cast<std::size_t>(ends[0])],
               sum->points()[static_cast<std::size_t>(ends[1])], line_color(line.origin), 6.0);
    panel.arrow(Vec2::Zero(), line.offset * line.normal, green, 2.5);
    panel.dot(Vec2::Zero(), 9, ink);
    for (const Vec2& point : sum->points()) panel.dot(point, 8, ink);
    FigureContent content;
    content.caption = fmt::format(
        "A line with the normal n{} of the {} is pushed from the origin along it until it rests on "
        "the farthest of the {} points, {:.3f} away: {} of them. The edge e{} of the sum joins {} "
        "and {}.",
        number + 1, line.origin == FacetOrigin::b ? "triangle" : "rectangle", sum->points().size(),
        line.offset, sum->touched(line).size(), number + 1, point_name(ends[0]),
        point_name(ends[1]));
    content.drawing = std::move(figure);
    return content;
}

Result<FigureContent> parallel_figure(FacetOrigin origin)
{
    const auto sum = explained_planar_sum();
    if (!sum) return tl::unexpected(sum.error());
    Figure figure;
    PlanarPanel panel = whole_panel(figure);
    draw_copies(panel, *sum);
    panel.outline(outline_of(*sum), faint, 1.5);
    int count = 0;
    for (std::size_t i = 0; i < sum->lines().size(); ++i) {
        const PushedLine& line = sum->lines()[i];
        if (line.origin != origin || !line.spans_edge) continue;
        ++count;
        const auto ends = end_points(*sum, line);
        const Vec2& from = sum->points()[static_cast<std::size_t>(ends[0])];
        const Vec2& to = sum->points()[static_cast<std::size_t>(ends[1])];
        panel.line(from, to, line_color(origin), 6.0);
        const Vec2 middle = 0.5 * (from + to);
        panel.words(middle, fmt::format("e{}", i + 1), 26.0 * Vec2(line.normal), 16,
                    line_color(origin));
    }
    draw_points(panel, *sum);
    const bool is_triangle = origin == FacetOrigin::b;
    FigureContent content;
    content.caption = fmt::format(
        "The {} edges of the Minkowski sum that are parallel to edges of the {}; thin, the whole "
        "sum of {} edges.",
        count, is_triangle ? "triangle" : "rectangle", sum->edges().size());
    content.drawing = std::move(figure);
    return content;
}

} // namespace

std::array<int, 2> end_points(const PlanarSum& sum, const PushedLine& line)
{
    const Vec2 along(-line.normal.y(), line.normal.x());
    const auto touched = sum.touched(line);
    const auto before = [&](int a, int b) {
        return along.dot(sum.points()[static_cast<std::size_t>(a)]) <
               along.dot(sum.points()[static_cast<std::size_t>(b)]);
    };
    return {*std::ranges::min_element(touched, before), *std::ranges::max_element(touched, before)};
}

Result<PlanarSum> explained_planar_sum()
{
    const std::array rectangle = {Vec2(-0.6, -0.4), Vec2(0.6, -0.4), Vec2(0.6, 0.4),
                                  Vec2(-0.6, 0.4)};
    const std::array triangle = {Vec2(-1.5, -1.0), Vec2(1.6, -0.45), Vec2(-0.2, 1.4)};
    const auto a = convex_polygon(rectangle);
    if (!a) return tl::unexpected(a.error());
    const auto b = convex_polygon(triangle);
    if (!b) return tl::unexpected(b.error());
    return planar_sum(*a, *b);
}

Result<FigureContent> figure_3_1(const Execution& /*context*/)
{
    const auto sum = explained_planar_sum();
    if (!sum) return tl::unexpected(sum.error());
    Figure figure{.width = 1200, .height = 620};
    const PlanarBox shown(Vec2(-2.2, -1.8), Vec2(2.2, 2.1));
    PlanarPanel left(figure, {Vec2(20, 60), Vec2(590, 600)}, shown);
    PlanarPanel right(figure, {Vec2(610, 60), Vec2(1180, 600)}, shown);
    left.title("triangle T");
    right.title("rectangle R");
    const auto draw = [&](PlanarPanel& panel, const std::vector<Vec2>& corners, unsigned color,
                          unsigned tint, const char* corner_name, std::size_t first_line) {
        panel.fill(corners, tint);
        panel.outline(corners, color, 3.0);
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const PushedLine& line = sum->lines()[first_line + i];
            const auto edge = static_cast<std::size_t>(line.source_edge);
            const Vec2 middle = 0.5 * (corners[edge] + corners[(edge + 1) % corners.size()]);
            const Vec2 tip = middle + normal_length * line.normal;
            panel.arrow(middle, tip, color, 2.5);
            panel.words(tip, fmt::format("n{}", first_line + i + 1), 22.0 * Vec2(line.normal), 16,
                        color);
            const Vec2 away = corners[i].normalized();
            panel.dot(corners[i], 8, ink);
            panel.words(corners[i], fmt::format("{}{}", corner_name, i), 24.0 * away, 14, ink);
        }
        panel.dot(Vec2::Zero(), 8, faint);
        panel.words(Vec2::Zero(), "0", {12, -14}, 14, faint);
    };
    draw(left, sum->b().corners, red, red_tint, "t", first_triangle_line);
    draw(right, sum->a().corners, blue, blue_tint, "r", first_rectangle_line);
    FigureContent content;
    content.caption = fmt::format(
        "A triangle of {} and a rectangle of {} edges with their outward normals, n1 to n{}, and "
        "the origin. The next figures sum them.",
        sum->b().corners.size(), sum->a().corners.size(), sum->lines().size());
    content.drawing = std::move(figure);
    return content;
}

Result<FigureContent> figure_3_2(const Execution& /*context*/)
{
    const auto sum = explained_planar_sum();
    if (!sum) return tl::unexpected(sum.error());
    Figure figure;
    PlanarPanel panel = whole_panel(figure);
    const auto outline = outline_of(*sum);
    panel.fill(outline, 0xF3F4F6);
    draw_copies(panel, *sum);
    panel.outline(outline, ink, 4.0);
    draw_points(panel, *sum);
    FigureContent content;
    content.caption = fmt::format(
        "A copy of the rectangle at each corner of the triangle: {} points v_k, k = i + {} j for "
        "corner i of the rectangle and j of the triangle. Their convex hull, bold, is the "
        "Minkowski "
        "sum: {} edges.",
        sum->points().size(), sum->a().corners.size(), sum->edges().size());
    content.drawing = std::move(figure);
    return content;
}

Result<FigureContent> figure_3_3(const Execution& /*context*/)
{
    return pushing_figure(first_triangle_line);
}

Result<FigureContent> figure_3_4(const Execution& /*context*/)
{
    return parallel_figure(FacetOrigin::b);
}

Result<FigureContent> figure_3_5(const Execution& /*context*/)
{
    return pushing_figure(first_rectangle_line);
}

Result<FigureContent> figure_3_6(const Execution& /*context*/)
{
    return parallel_figure(FacetOrigin::a);
}

namespace {

/// Of a point's number, in pixels: where no side of either size goes through it.
Vec2 number_offset(const PlanarSum& sum, int point)
{
    const CornerPair pair = sum.pair(point);
    const Vec2& of_rectangle = sum.a().corners[static_cast<std::size_t>(pair.a)];
    const Vec2& of_triangle = sum.b().corners[static_cast<std::size_t>(pair.b)];
    if (of_rectangle.x() > 0) return {16.0, of_rectangle.y() > 0 ? 14.0 : -14.0};
    if (of_rectangle.y() > 0) return {-18.0, 14.0};
    // Sides run to the left of the upper copy and below the others.
    return of_triangle.y() > 0 ? Vec2(-2.0, -17.0) : Vec2(-18.0, 0.0);
}

} // namespace

Result<FigureContent> figure_3_14(const Execution& /*context*/)
{
    const auto sum = explained_planar_sum();
    if (!sum) return tl::unexpected(sum.error());
    // The first edge that comes from the triangle is followed from size to size.
    const auto edges = sum->edges();
    const auto followed = std::ranges::find(edges, FacetOrigin::b, &PlanarEdge::origin);
    const CornerPair pair = sum->pair(followed->support);
    Figure figure{.width = 1400, .height = 640};
    for (const int depth : {0, 1}) {
        const PlanarScales scales = {.a = depth == 0 ? 1.0 : 0.5};
        const double left = 20.0 + 690.0 * depth;
        PlanarPanel panel(figure, {Vec2(left, 60), Vec2(left + 670, 620)},
                          {Vec2(-2.9, -2.1), Vec2(2.9, 2.3)});
        panel.title(depth == 0 ? "(a) the rectangle" : "(b) half its size, one level deeper");
        std::vector<Vec2> corners;
        for (const PlanarEdge& edge : edges) corners.push_back(sum->point(edge.from, scales));
        panel.fill(corners, 0xF3F4F6);
        panel.fill(sum->b().corners, red_tint);
        for (int j = 0; j < static_cast<int>(sum->b().corners.size()); ++j) {
            std::vector<Vec2> copy;
            copy.reserve(sum->a().corners.size());
            for (int i = 0; i < static_cast<int>(sum->a().corners.size()); ++i)
                copy.push_back(sum->point(sum->index({i, j}), scales));
            panel.fill(copy, blue_tint);
            panel.outline(copy, blue, 1.5);
        }
        panel.outline(sum->b().corners, red, 1.5);
        panel.outline(corners, ink, 2.0);
        panel.line(sum->point(followed->from, scales), sum->point(followed->to, scales), purple,
                   7.0);
        for (int k = 0; k < static_cast<int>(sum->points().size()); ++k) {
            const Vec2 point = sum->point(k, scales);
            panel.dot(point, 8, k == followed->support ? purple : ink);
            panel.words(point, fmt::format("{}", k), number_offset(*sum, k), 13, ink);
        }
    }
    FigureContent content;
    content.caption = fmt::format(
        "Index tracking. The points of both sums are numbered in the same order, and the violet "
        "edge joins points {0} and {1} in both. Its support is v_{2}: with i = {2} mod {3} = {4} "
        "and j = {2} div {3} = {5} it is corner {4} of the rectangle plus corner {5} of the "
        "triangle at every size. The line's offset is {6:.4f} in (a) and, from the same two "
        "corners, {7:.4f} in (b).",
        followed->from, followed->to, followed->support, sum->a().corners.size(), pair.a, pair.b,
        sum->offset(*followed, {.a = 1.0}), sum->offset(*followed, {.a = 0.5}));
    content.drawing = std::move(figure);
    return content;
}

} // namespace proxima
