#include "cli/figure.h"

#include "cli/legend.h"
#include "code_of.h"
#include "proxima/geometry.h"

#include <gtest/gtest.h>
#include <set>

namespace proxima::figure_test {
namespace {

Image drawn(const std::string& text, const TextStyle& style)
{
    Figure figure{.width = 120, .height = 80};
    figure.texts.push_back({{60, 40}, text, style});
    return figure_image(figure);
}

/// The box of all pixels that are not white; empty where all are.
Box ink_of(const Image& image)
{
    Box box;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x)
            if (image.pixel(x, y)[0] < 128) box.extend(Vec3(x, y, 0));
    }
    return box;
}

TEST(FigureText, EveryPrintableLetterIsDrawnAndDiffersFromAllOthers)
{
    std::set<std::string> seen;
    for (char letter = '!'; letter <= '~'; ++letter) {
        const Image image = drawn(std::string(1, letter), {.size = 40});
        seen.insert(std::string(image.bytes.begin(), image.bytes.end()));
    }
    EXPECT_EQ(seen.size(), static_cast<std::size_t>('~' - '!' + 1));
    EXPECT_TRUE(ink_of(drawn(" ", {})).empty());
}

TEST(FigureText, OtherScriptsAreDrawnAndWhatIsNoUtf8IsAQuestionMark)
{
    const auto bytes = [](const char* text) { return drawn(text, {.size = 20}).bytes; };
    EXPECT_NE(bytes("\xD0\xB6"), bytes("\xD1\x8F")) << "Cyrillic";
    EXPECT_NE(bytes("\xCE\xB1"), bytes("?")) << "Greek";
    for (const char* const broken : {"\xFF", "\x01", "\n", "\xC3"})
        EXPECT_EQ(bytes(broken), bytes("?")) << +broken[0];
    EXPECT_EQ(bytes("\xC3\xA9\xFF"), bytes("\xC3\xA9?"));
}

TEST(FigureText, IsPlacedByItsAnchorAndAsHighAsCapitals)
{
    const double length = text_length("HEH", 20);
    EXPECT_NEAR(length, 2 * text_length("HEH", 10), 0.01);
    EXPECT_DOUBLE_EQ(text_length("", 20), 0.0);
    // Letters have some space to either side.
    constexpr double space = 4;
    const Box start = ink_of(drawn("HEH", {.size = 20}));
    EXPECT_NEAR(start.lower.x(), 60, space);
    EXPECT_NEAR(start.upper.x(), 60 + length, space);
    EXPECT_NEAR(start.lower.y(), 20, 1);
    EXPECT_NEAR(start.upper.y(), 40, 1);
    const Box middle = ink_of(drawn("HEH", {.size = 20, .anchor = TextAnchor::middle}));
    EXPECT_NEAR(middle.center().x(), 60, 1);
    const Box end = ink_of(drawn("HEH", {.size = 20, .anchor = TextAnchor::end}));
    EXPECT_NEAR(end.upper.x(), 60, space);
    const Box upward =
        ink_of(drawn("HEH", {.size = 20, .anchor = TextAnchor::middle, .turn = TextTurn::upward}));
    EXPECT_NEAR(upward.center().y(), 40, 1);
    EXPECT_NEAR(upward.upper.x(), 60, 1);
    EXPECT_NEAR(upward.extent().y(), length, 2 * space);
}

TEST(Figure, IsDrawnOverThePartOfAPictureThatItCovers)
{
    const Image white = figure_image({.width = 30, .height = 20});
    Figure red{.width = 10, .height = 10};
    red.boxes = {{{0, 0}, {10, 10}, 0xFF0000, 0.5}};
    for (const int left : {-30, -5, 0, 13, 25, 40}) {
        for (const int top : {-10, -3, 4, 15, 20}) {
            Image image = white;
            draw_over(image, red, left, top);
            for (int y = 0; y < image.height; ++y) {
                for (int x = 0; x < image.width; ++x) {
                    const bool covered = x >= left && x < left + 10 && y >= top && y < top + 10;
                    const auto pixel = image.pixel(x, y);
                    EXPECT_EQ(pixel[0], 255);
                    EXPECT_NEAR(pixel[1], covered ? 127 : 255, covered ? 1 : 0) << x << ' ' << y;
                    EXPECT_EQ(pixel[1], pixel[2]);
                }
            }
        }
    }
}

TEST(Legend, NamesEachColourInTheUpperRightCorner)
{
    const Image blue = [] {
        Figure all{.width = 300, .height = 200};
        all.boxes = {{{0, 0}, {300, 200}, 0x0000FF}};
        return figure_image(all);
    }();
    Image image = blue;
    draw_legend(image, {});
    EXPECT_EQ(image.bytes, blue.bytes);
    draw_legend(image,
                {.title = "",
                 .entries = {{0xFF0000, "words that are surely wider than half of the picture"},
                             {0, "-"},
                             {0, "-"}}});
    EXPECT_EQ(image.bytes, blue.bytes);
    draw_legend(image, {.title = "depth", .entries = {{0xFF0000, "one"}, {0x00FF00, "two"}}});
    Box changed;
    int red = 0;
    int green = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto pixel = image.pixel(x, y);
            if (pixel != blue.pixel(x, y)) changed.extend(Vec3(x, y, 0));
            red += pixel == std::array<std::uint8_t, 3>{255, 0, 0} ? 1 : 0;
            green += pixel == std::array<std::uint8_t, 3>{0, 255, 0} ? 1 : 0;
        }
    }
    EXPECT_EQ(changed.upper.x(), 292);
    EXPECT_EQ(changed.lower.y(), 7);
    EXPECT_GT(changed.lower.x(), 200);
    EXPECT_EQ(red, 49);
    EXPECT_EQ(green, 49);
}

TEST(Figure, DrawsLinesOverBoxesAndLaterBoxesOverEarlierOnes)
{
    Figure figure{.width = 20, .height = 20};
    figure.boxes = {{{0, 0}, {20, 20}, 0xFF0000}, {{0, 0}, {10, 20}, 0x0000FF}};
    figure.lines = {{{0, 10}, {20, 10}, 0x00FF00, 4}};
    const Image image = figure_image(figure);
    EXPECT_EQ(image.pixel(15, 3), (std::array<std::uint8_t, 3>{255, 0, 0}));
    EXPECT_EQ(image.pixel(5, 3), (std::array<std::uint8_t, 3>{0, 0, 255}));
    EXPECT_EQ(image.pixel(5, 10), (std::array<std::uint8_t, 3>{0, 255, 0}));
}

TEST(Figure, RefusesOtherFileFormats)
{
    EXPECT_EQ(code_of(write_figure({}, "a.gif")), ErrorCode::unsupported_format);
}

} // namespace
} // namespace proxima::figure_test
