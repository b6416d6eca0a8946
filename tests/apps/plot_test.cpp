#include "cli/list_histogram.h"
#include "cli/plot.h"
#include "code_of.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <iterator>
#include <set>

namespace proxima::plot_test {
namespace {

bool has(const Figure& figure, const std::string& words)
{
    return std::ranges::find(figure.texts, words, &FigureText::text) != figure.texts.end();
}

void expect_words(const Figure& figure, const std::vector<std::string>& expected)
{
    for (const std::string& words : expected) EXPECT_TRUE(has(figure, words)) << words;
}

TEST(PlotScale, GoesBetweenRoundNumbersAroundTheValues)
{
    EXPECT_EQ(logarithmic_scale(1, 9).ticks, (std::vector<double>{1, 2, 5, 10}));
    EXPECT_EQ(logarithmic_scale(3, 3).ticks, (std::vector<double>{2, 5}));
    EXPECT_EQ(logarithmic_scale(0.02, 1.1).ticks,
              (std::vector<double>{0.02, 0.05, 0.1, 0.2, 0.5, 1, 2}));
    EXPECT_EQ(linear_scale(40).ticks, (std::vector<double>{0, 8, 16, 24, 32, 40}));
    EXPECT_EQ(linear_scale(40).is_logarithmic, false);
}

TEST(Plot, PlacesValuesBetweenTheEndsOfItsScales)
{
    const Plot plot(logarithmic_scale(1, 100), linear_scale(10), {.title = "t", .series = {"s"}});
    const Vec2 lower = plot.at(1, 0);
    const Vec2 upper = plot.at(100, 10);
    EXPECT_LT((plot.at(10, 5) - 0.5 * (lower + upper)).norm(), 1e-9);
    EXPECT_LT(lower.x(), upper.x());
    EXPECT_GT(lower.y(), upper.y()) << "values rise upwards";
    // All words are in the picture, none over another.
    for (const FigureText& text : plot.figure.texts) {
        EXPECT_GT(text.at.y(), text.style.size);
        EXPECT_LT(text.at.y(), plot.figure.height);
    }
}

TEST(Plot, BreaksALegendThatIsTooLongAndMakesRoomForIt)
{
    std::vector<std::string> names;
    for (int i = 0; i < 9; ++i)
        names.push_back("a series with a long name, number " + std::to_string(i));
    const Plot few(linear_scale(1), linear_scale(1), {.series = {names[0]}});
    const Plot many(linear_scale(1), linear_scale(1), {.series = names});
    EXPECT_GT(many.figure.height, few.figure.height + 60);
    expect_words(many.figure, names);
    for (const FigureText& text : many.figure.texts) {
        if (text.style.anchor != TextAnchor::start) continue;
        EXPECT_LE(text.at.x() + text_length(text.text, text.style.size), many.figure.width);
        EXPECT_LT(text.at.y(), many.at(0, 1).y()) << "above the curves";
    }
}

TEST(LogPlot, JoinsThePointsOfEachSeriesAndSaysWhatTheyAre)
{
    const std::vector<PlotSeries> series = {{"one", {{1, 10}, {10, 100}, {100, 1000}}},
                                            {"two", {{2, 20}}}};
    const Figure figure = log_plot(series, {"title", {"a note"}, "x words", "y words", {"unused"}});
    expect_words(figure, {"title", "a note", "x words", "y words", "one", "two", "1", "1000"});
    EXPECT_FALSE(has(figure, "unused"));
    // On two logarithmic scales these three points lie on a line, equally far from each other.
    std::vector<FigureLine> strokes;
    std::ranges::copy_if(figure.lines, std::back_inserter(strokes), [](const FigureLine& line) {
        return line.color == plot_color(0) && line.width == 3.0;
    });
    ASSERT_EQ(strokes.size(), 2);
    EXPECT_LT(((strokes[0].to - strokes[0].from) - (strokes[1].to - strokes[1].from)).norm(), 1e-9);
    EXPECT_EQ(std::ranges::count(figure.boxes, plot_color(0), &FigureBox::color), 3);
    EXPECT_EQ(std::ranges::count(figure.boxes, plot_color(1), &FigureBox::color), 1);
}

TEST(ListHistogram, SaysWhatItShows)
{
    const std::vector<std::uint32_t> lengths = {3, 5, 5};
    const std::vector<double> volumes = {1, 1, 2};
    const std::vector<HistogramSeries> leaves = {{4, list_statistics(lengths, volumes)}};
    const Figure of_leaves =
        histogram_figure(leaves, HistogramOf::leaves, {"a title", "a subtitle"});
    expect_words(of_leaves, {"a title", "a subtitle", "triangles in the list of a leaf",
                             "share of the root's volume, percent", "depth 4: mean 4.5, 3 leaves"});
    // Two of three cells list five features.
    const std::vector<HistogramSeries> cells = {{1, {}}, {2, list_statistics(lengths)}};
    const Figure of_cells = histogram_figure(cells, HistogramOf::outer_cells, {});
    expect_words(of_cells, {"features in the list of a cell", "share of the outer cells, percent",
                            "depth 1: no outer cell", "depth 2: mean 4.3, 3 cells"});
    double highest = of_cells.height;
    for (const FigureLine& line : of_cells.lines) {
        if (line.color == plot_color(1) && line.width == 3.0)
            highest = std::min({highest, line.from.y(), line.to.y()});
    }
    const Plot same(logarithmic_scale(1, 10), linear_scale(75),
                    {.series = {"depth 1: no outer cell", "depth 2: mean 4.3, 3 cells"}});
    EXPECT_NEAR(highest, same.at(1, 100 * 2.0 / 3).y(), 1e-6);
}

TEST(PlotFile, IsATableOrADrawing)
{
    for (const char* const name : {"a.csv", "a.svg", "a.PDF", "a.png"})
        EXPECT_TRUE(check_plot_format(name)) << name;
    for (const char* const name : {"a.gif", "a", "-"})
        EXPECT_EQ(code_of(check_plot_format(name)), ErrorCode::unsupported_format) << name;
}

} // namespace
} // namespace proxima::plot_test
