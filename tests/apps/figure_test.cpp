#include "cli/figure.h"

#include "cli/lettering.h"
#include "proxima/geometry.h"

#include <gtest/gtest.h>
#include <set>

namespace proxima {
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
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (image.pixel(x, y)[0] < 128) box.extend(Vec3(x, y, 0));
    return box;
}

TEST(Lettering, EveryPrintableLetterIsDrawnAndDiffersFromAllOthers)
{
    std::set<std::string> seen;
    for (char letter = '!'; letter <= '~'; ++letter) {
        const Image image = drawn(std::string(1, letter), {.size = 40});
        seen.insert(std::string(image.bytes.begin(), image.bytes.end()));
    }
    // The letter O and the digit 0 are alike.
    EXPECT_EQ(seen.size(), static_cast<std::size_t>('~' - '!' + 1 - 1));
    EXPECT_TRUE(ink_of(drawn(" ", {})).empty());
    EXPECT_FALSE(ink_of(drawn("\xFF", {})).empty());
}

TEST(Lettering, PlacesTextByItsAnchor)
{
    const double length = text_length("HEH", 20);
    EXPECT_NEAR(length, (3 * 8 + 2 * 3) * 20 / 12.0, 1e-12);
    const Box start = ink_of(drawn("HEH", {.size = 20}));
    EXPECT_NEAR(start.lower.x(), 60, 2);
    EXPECT_NEAR(start.upper.x(), 60 + length, 2);
    EXPECT_NEAR(start.lower.y(), 20, 2);
    EXPECT_NEAR(start.upper.y(), 40, 2);
    const Box middle = ink_of(drawn("HEH", {.size = 20, .anchor = TextAnchor::middle}));
    EXPECT_NEAR(middle.center().x(), 60, 1);
    const Box end = ink_of(drawn("HEH", {.size = 20, .anchor = TextAnchor::end}));
    EXPECT_NEAR(end.upper.x(), 60, 2);
    const Box upward =
        ink_of(drawn("HEH", {.size = 20, .anchor = TextAnchor::middle, .turn = TextTurn::upward}));
    EXPECT_NEAR(upward.center().y(), 40, 1);
    EXPECT_NEAR(upward.upper.x(), 60, 2);
    EXPECT_NEAR(upward.extent().y(), length, 3);
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

TEST(Figure, EscapesTextInSvg)
{
    Figure figure;
    figure.texts.push_back({{1, 2}, "a < b & \"c\" > \x01\xC3\xA9\xFF", {}});
    const std::string svg = figure_svg(figure);
    EXPECT_NE(svg.find(">a &lt; b &amp; \"c\" &gt; ?\xC3\xA9?</text>"), std::string::npos) << svg;
}

TEST(Figure, RefusesOtherFileFormats)
{
    EXPECT_EQ(write_figure({}, "a.gif").error().code, ErrorCode::unsupported_format);
}

} // namespace
} // namespace proxima
