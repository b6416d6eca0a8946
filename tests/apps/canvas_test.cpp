#include "cli/canvas.h"
#include "code_of.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>

namespace proxima::canvas_test {
namespace {

using Pixel = std::array<std::uint8_t, 3>;

const Color red = srgb(0xFF0000);
const Color blue = srgb(0x0000FF);
constexpr Pixel red_pixel = {255, 0, 0};
constexpr Pixel blue_pixel = {0, 0, 255};
constexpr Pixel white_pixel = {255, 255, 255};

/// A right triangle that covers the upper left half of a 20x20 canvas.
std::array<ScreenVertex, 3> half(const Color& color, double nearness)
{
    return {{{{0, 0, nearness}, color}, {{20, 0, nearness}, color}, {{0, 20, nearness}, color}}};
}

TEST(Canvas, IsMadeWithinABudget)
{
    const auto made = make_canvas(1000, 1000, {}, nullptr, {.bytes = 110'000'000});
    ASSERT_TRUE(made);
    const auto refused = make_canvas(8192, 8192, {}, nullptr, {.bytes = 110'000'000});
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::budget_exceeded);
}

TEST(Canvas, ColoursSurviveConversionToLinearLightAndBack)
{
    for (const unsigned hex : {0x000000U, 0x123456U, 0x808080U, 0xFEDCBAU, 0xFFFFFFU}) {
        const Canvas canvas(1, 1, {srgb(hex), srgb(hex)});
        const Pixel expected = {static_cast<std::uint8_t>(hex >> 16U),
                                static_cast<std::uint8_t>(hex >> 8U & 0xFFU),
                                static_cast<std::uint8_t>(hex & 0xFFU)};
        EXPECT_EQ(canvas.image().pixel(0, 0), expected);
    }
}

TEST(Canvas, FillsTrianglesOfEitherOrientation)
{
    for (const bool turned : {false, true}) {
        Canvas canvas(20, 20);
        auto triangle = half(red, 1.0);
        if (turned) std::swap(triangle[0], triangle[1]);
        canvas.draw_triangle(triangle);
        const Image image = canvas.image();
        EXPECT_EQ(image.pixel(0, 0), red_pixel);
        EXPECT_EQ(image.pixel(18, 0), red_pixel);
        EXPECT_EQ(image.pixel(12, 12), white_pixel);
        // The slanted edge is smoothed: half of the pixel that it cuts.
        EXPECT_GT(image.pixel(10, 9)[1], 50);
        EXPECT_LT(image.pixel(10, 9)[1], 230);
    }
}

/// How far within a triangle a point lies: 0 on its border, negative outside.
double depth_within(const std::array<ScreenVertex, 3>& triangle, const Vec2& point)
{
    const auto turn = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
    const auto corner = [&](std::size_t k) -> Vec2 {
        return {triangle[k % 3].point.x, triangle[k % 3].point.y};
    };
    const double side = turn(corner(1) - corner(0), corner(2) - corner(0)) > 0 ? 1.0 : -1.0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2 along = corner(k + 1) - corner(k);
        least = std::min(least, side * turn(along, point - corner(k)) / along.norm());
    }
    return least;
}

TEST(Canvas, FillsEverySampleOfATriangleAndNoOther)
{
    constexpr unsigned seed = 5;
    constexpr int side = 24;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        // Small and large ones, slivers among them.
        const double reach = i % 3 == 0 ? 3.0 : i % 3 == 1 ? 30.0 : 3e5;
        const Vec2 middle(12 + 12 * any(random), 12 + 12 * any(random));
        std::array<ScreenVertex, 3> triangle;
        for (ScreenVertex& vertex : triangle) {
            vertex = {{middle.x() + reach * any(random), middle.y() + reach * any(random), 1.0},
                      red};
        }
        if (i % 5 == 0) triangle[2].point.y = triangle[1].point.y; // level
        if (i % 7 == 0) triangle[2].point.x = triangle[0].point.x; // upright
        Canvas canvas(side, side);
        canvas.draw_triangle(triangle);
        const Image image = canvas.image();
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                double least = std::numeric_limits<double>::infinity();
                double most = -least;
                for (const Vec2& at : {Vec2(x + 0.25, y + 0.25), Vec2(x + 0.75, y + 0.25),
                                       Vec2(x + 0.25, y + 0.75), Vec2(x + 0.75, y + 0.75)}) {
                    least = std::min(least, depth_within(triangle, at));
                    most = std::max(most, depth_within(triangle, at));
                }
                constexpr double rounding = 1e-9;
                if (least > rounding) {
                    EXPECT_EQ(image.pixel(x, y), red_pixel) << "seed " << seed << " " << i;
                } else if (most < -rounding) {
                    EXPECT_EQ(image.pixel(x, y), white_pixel) << "seed " << seed << " " << i;
                }
            }
        }
    }
}

TEST(Canvas, LongThinTrianglesTakeWorkForWhatTheyCoverAlone)
{
    // Of two samples' width and 2000 rows; within a row it moves by one more.
    constexpr std::uint64_t most = 2000 * 8;
    Canvas canvas(1000, 1000);
    for (const double at : {10.0, 19.5, 69.9}) {
        EXPECT_LT(canvas.draw_triangle(
                      {{{{at, 0, 1}, red}, {{at + 1, 0, 1}, red}, {{at + 900, 1000, 1}, red}}}),
                  most);
    }
    EXPECT_NE(canvas.image().pixel(10, 0), white_pixel);
}

TEST(Canvas, NearerTrianglesHideFartherOnesInAnyOrder)
{
    for (const bool near_first : {false, true}) {
        Canvas canvas(20, 20);
        canvas.draw_triangle(half(near_first ? red : blue, near_first ? 2.0 : 1.0));
        canvas.draw_triangle(half(near_first ? blue : red, near_first ? 1.0 : 2.0));
        EXPECT_EQ(canvas.image().pixel(3, 3), red_pixel);
    }
}

TEST(Canvas, NearerTrianglesAndPanesHideLines)
{
    const ScreenPoint left{0, 5, 1.0};
    const ScreenPoint right{20, 5, 1.0};
    const LineStyle style{.width = 3.0};
    const auto panes = [](double nearness) {
        return std::array<ScreenPoint, 3>{{{0, 0, nearness}, {20, 0, nearness}, {0, 20, nearness}}};
    };
    Canvas free(20, 20);
    free.hide_lines_behind(panes(0.5));
    free.draw_line(left, right, blue, style);
    EXPECT_EQ(free.image().pixel(3, 5), blue_pixel);
    EXPECT_EQ(free.image().pixel(3, 10), white_pixel);

    Canvas behind_pane(20, 20);
    behind_pane.hide_lines_behind(panes(2.0));
    behind_pane.draw_line(left, right, blue, style);
    EXPECT_EQ(behind_pane.image().pixel(3, 5), white_pixel);
    EXPECT_EQ(behind_pane.image().pixel(18, 5), blue_pixel);

    Canvas behind_triangle(20, 20);
    behind_triangle.draw_triangle(half(red, 2.0));
    behind_triangle.draw_line(left, right, blue, style);
    EXPECT_EQ(behind_triangle.image().pixel(3, 5), red_pixel);
}

TEST(Canvas, AcceptsCoordinatesOutsideThePictureAndNotANumber)
{
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    Canvas canvas(20, 20);
    for (const double far : {-1e30, -30.0, 50.0, 1e30}) {
        canvas.draw_line({far, far, 1.0}, {far, far + 1, 1.0}, blue, {});
        canvas.draw_triangle(
            {{{{far, far, 1}, red}, {{far + 1, far, 1}, red}, {{far, far + 1, 1}, red}}});
    }
    canvas.draw_line({nan, 0, 1.0}, {1, nan, 1.0}, blue, {});
    canvas.draw_triangle({{{{nan, 0, 1}, red}, {{1, 0, 1}, red}, {{0, 1, 1}, red}}});
    EXPECT_EQ(canvas.image().pixel(10, 10), white_pixel);
    canvas.draw_triangle({{{{-1e6, -1e6, 1}, red}, {{1e6, -1e6, 1}, red}, {{0, 1e6, 1}, red}}});
    EXPECT_EQ(canvas.image().pixel(10, 10), red_pixel);
}

TEST(Canvas, DarkensCreasesAndNotPlanes)
{
    const auto drawn = [](double middle) {
        Canvas canvas(40, 40);
        const Color grey = srgb(0xB0B0B0);
        // Two walls that meet along x = 20 with this nearness.
        for (const double side : {0.0, 40.0}) {
            canvas.draw_triangle(
                {{{{side, 0, 1.0}, grey}, {{20, 0, middle}, grey}, {{20, 40, middle}, grey}}});
            canvas.draw_triangle(
                {{{{side, 0, 1.0}, grey}, {{20, 40, middle}, grey}, {{side, 40, 1.0}, grey}}});
        }
        canvas.darken_creases(6.0, 0.6F);
        return canvas.image().pixel(20, 20)[0];
    };
    EXPECT_EQ(drawn(1.0), 0xB0);
    EXPECT_LT(drawn(0.8), 0xA8);
}

} // namespace
} // namespace proxima::canvas_test
