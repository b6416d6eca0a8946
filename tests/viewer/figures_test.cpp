// Figures of octrees and sums show what they must: their parts against the library and against slow
// oracles, and the colours of those parts in the picture. What figures there are.
#include "proxima/execution.h"
#include "viewer/figure_parts.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/figure_pages.h"
#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/octree_figures.h"
#include "viewer/figures/planar_panel.h"
#include "viewer/figures/voronoi_figures.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <map>
#include <set>

namespace proxima::figures_test {
namespace {

TEST(Figures, CirclesShowTheLeavesOfTheirQuadtrees)
{
    for (const Subdivision subdivision : {Subdivision::uniform, Subdivision::adaptive}) {
        const auto content = subdivision == Subdivision::uniform ? figure_2_3({}) : figure_2_4({});
        ASSERT_TRUE(content && content->drawing);
        std::array<std::size_t, 3> expected = {};
        for (const int depth : {2, 3, 4, 5}) {
            const auto tree = circle_quadtree(depth, subdivision);
            for (const QuadtreeLeaf& leaf : tree->leaves)
                ++expected[static_cast<std::size_t>(tree->type(leaf))];
        }
        const Figure& figure = *content->drawing;
        using namespace figure_colors;
        // One of each is the legend's.
        EXPECT_EQ(boxes_of(figure, outer_cell), expected[0] + 1);
        EXPECT_EQ(boxes_of(figure, inner_cell), expected[1] + 1);
        EXPECT_EQ(boxes_of(figure, boundary_cell), expected[2] + 1);
        // What the drawing holds is in the picture: cells far from lines have their colour.
        const Image image = figure_image(figure);
        std::size_t seen = 0;
        for (const FigureBox& box : figure.boxes) {
            if (box.color == faint) continue;
            const Vec2 center = 0.5 * (box.lower + box.upper);
            const bool near_line = std::ranges::any_of(figure.lines, [&](const FigureLine& line) {
                const Vec2 along = line.to - line.from;
                const double t = std::clamp((center - line.from).dot(along) /
                                                std::max(along.squaredNorm(), 1e-9),
                                            0.0, 1.0);
                return (line.from + t * along - center).norm() < 3.0;
            });
            if (near_line) continue;
            ++seen;
            EXPECT_EQ(image.pixel(static_cast<int>(center.x()), static_cast<int>(center.y())),
                      pixel_of(box.color));
        }
        EXPECT_GT(seen, 100U);
    }
}

TEST(Figures, PlanarSumsShowTheEdgesOfEachOperand)
{
    const auto sum = explained_planar_sum();
    ASSERT_TRUE(sum);
    EXPECT_EQ(sum->edges().size(), 7U);
    using namespace figure_colors;
    EXPECT_EQ(lines_of(*figure_3_4({})->drawing, red, 6.0), 3U);
    EXPECT_EQ(lines_of(*figure_3_6({})->drawing, blue, 6.0), 4U);
    EXPECT_EQ(lines_of(*figure_3_3({})->drawing, red, 6.0), 1U);
    EXPECT_EQ(lines_of(*figure_3_5({})->drawing, blue, 6.0), 1U);
    EXPECT_EQ(lines_of(*figure_3_2({})->drawing, ink, 4.0), sum->edges().size());
    // The bold outline is the convex hull of the points: none lies beyond a line of it.
    const auto figure = figure_3_2({});
    std::vector<FigureLine> hull;
    for (const FigureLine& line : figure->drawing->lines)
        if (line.color == ink && line.width == 4.0) hull.push_back(line);
    int corners = 0;
    for (const FigureLine& dot : figure->drawing->lines) {
        if (dot.from != dot.to || dot.color != ink) continue;
        ++corners;
        for (const FigureLine& line : hull) {
            // Pixels point down: the inside is to the right of a walk against the clock.
            const Vec2 along = (line.to - line.from).normalized();
            const Vec2 offset = dot.from - line.from;
            EXPECT_LE(along.x() * offset.y() - along.y() * offset.x(), 1e-6);
        }
    }
    EXPECT_EQ(corners, 12);
}

TEST(Figures, IndexTrackingShowsTheSameNumbersTwice)
{
    const auto content = figure_3_14({});
    ASSERT_TRUE(content);
    EXPECT_EQ(lines_of(*content->drawing, figure_colors::purple, 7.0), 2U);
    std::map<std::string, int> words;
    for (const FigureText& text : content->drawing->texts) ++words[text.text];
    for (int k = 0; k < 12; ++k) EXPECT_EQ(words[std::to_string(k)], 2) << k;
}

TEST(Figures, WordsKeepClearOfStrongLines)
{
    const auto is_strong = [](const FigureLine& line) {
        return line.color != figure_colors::faint && line.from != line.to;
    };
    for (const auto make : {figure_2_5, figure_3_1, figure_3_2, figure_3_3, figure_3_4, figure_3_5,
                            figure_3_6, figure_3_14, figure_4_1, figure_4_7}) {
        const auto content = make({});
        ASSERT_TRUE(content && content->drawing);
        const Figure& figure = *content->drawing;
        EXPECT_GT(figure.texts.size(), 3U);
        for (const FigureText& text : figure.texts) {
            const PlanarBox box = box_of(text);
            const auto through = std::ranges::count_if(figure.lines, [&](const FigureLine& line) {
                return is_strong(line) && crosses(line, box);
            });
            EXPECT_EQ(through, 0) << '"' << text.text << "\" in: " << content->caption;
        }
    }
}

TEST(Figures, EveryLeafThatListsFeaturesNamesThem)
{
    const auto tree = proximity_quadtree();
    const auto content = figure_4_1({});
    ASSERT_TRUE(tree && content);
    const auto& texts = content->drawing->texts;
    const std::size_t corners = tree->polygon.points().size();
    std::size_t listing = 0;
    for (const QuadtreeLeaf& leaf : tree->leaves) listing += leaf.sets.empty() ? 0 : 1;
    EXPECT_EQ(texts.size(), listing + 2 * corners) << "and the polygon's own names";
    for (std::size_t i = 0; i < texts.size(); ++i) {
        for (std::size_t k = i + 1; k < texts.size(); ++k) {
            EXPECT_FALSE(box_of(texts[i]).intersects(box_of(texts[k])))
                << texts[i].text << " over " << texts[k].text;
        }
    }
}

TEST(Figures, DetectsLinesThatCrossWordsByTheirWidth)
{
    const FigureText text = {{100, 50}, "xx", {20.0, 0, TextAnchor::middle}};
    const PlanarBox box = box_of(text);
    EXPECT_EQ(box.max().y(), 50.0);
    EXPECT_EQ(box.min().y(), 30.0);
    EXPECT_NEAR(box.center().x(), 100.0, 1e-9);
    EXPECT_TRUE(crosses({{0, 40}, {200, 40}, 0, 1.0}, box));
    EXPECT_TRUE(crosses({{0, 0}, {200, 80}, 0, 1.0}, box));
    EXPECT_FALSE(crosses({{0, 53}, {200, 53}, 0, 4.0}, box));
    EXPECT_TRUE(crosses({{0, 53}, {200, 53}, 0, 7.0}, box));
    EXPECT_FALSE(crosses({{0, 0}, {50, 80}, 0, 1.0}, box)) << "ends before";
    EXPECT_FALSE(crosses({{100, 60}, {100, 90}, 0, 1.0}, box));
}

TEST(Figures, SumsInSpaceShowFacetsByOrigin)
{
    struct Expectation {
        Result<FigureContent> (*make)(const Execution&);
        std::size_t normals;
        int channel; // of the colour that stands out
    };
    for (const auto& [make, normals, channel] :
         {Expectation{figure_3_8, 6, 0}, Expectation{figure_3_9, 8, 2},
          Expectation{figure_3_10, 12, 1}}) {
        const auto content = make({});
        ASSERT_TRUE(content);
        const ScenePanel& panel = scene_of(*content);
        EXPECT_EQ(surfaces_named(panel.scene, "normal").size(), normals);
        const Image image = picture_of(panel);
        std::array<int, 3> strong = {};
        for (const auto& [color, count] : pixels_by_color(image)) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (color[k] > 1.35 * color[(k + 1) % 3] && color[k] > 1.35 * color[(k + 2) % 3])
                    strong[k] += count;
            }
        }
        const int own = strong[static_cast<std::size_t>(channel)];
        EXPECT_GT(own, 20000);
        for (std::size_t k = 0; k < 3; ++k) {
            if (static_cast<int>(k) != channel) {
                EXPECT_LT(strong[k], own / 10);
            }
        }
    }
    const auto whole = figure_3_11({});
    ASSERT_TRUE(whole);
    EXPECT_EQ(surfaces_named(scene_of(*whole).scene, "normal").size(), 26U);
}

TEST(Figures, SumsOfTwoSizesHaveTheSameFacets)
{
    const auto content = figure_3_13({});
    ASSERT_TRUE(content);
    const auto facets = [&](std::size_t panel) {
        return surfaces_named(scene_of(*content, panel).scene, "facet");
    };
    ASSERT_EQ(facets(0).size(), facets(1).size());
    for (std::size_t i = 0; i < facets(0).size(); ++i)
        EXPECT_TRUE((facets(0)[i]->color == facets(1)[i]->color).all());
}

TEST(Figures, DegenerateTrianglesDifferInTheirInterior)
{
    const auto content = figure_3_15({});
    ASSERT_TRUE(content);
    const std::string& words = content->caption;
    EXPECT_NE(words.find("goes through the volume: touches the closed cube, meets its inside"),
              std::string::npos)
        << words;
    EXPECT_NE(words.find("lies in the face: touches the closed cube, misses its inside"),
              std::string::npos);
    EXPECT_NE(words.find("stays outside: touches the closed cube, misses its inside"),
              std::string::npos);
}

TEST(Figures, AreNumberedOnceAndInOrder)
{
    std::set<std::string_view> numbers;
    for (const ThesisFigure& figure : thesis_figures())
        EXPECT_TRUE(numbers.insert(figure.number).second);
    EXPECT_EQ(numbers.size(), 37U);
    for (const MissingFigure& figure : missing_figures())
        EXPECT_TRUE(numbers.insert(figure.number).second);
    // 7 in chapter 2, 16 in 3, 9 in 4 and 8 in 5.
    EXPECT_EQ(numbers.size(), 40U);
}

} // namespace
} // namespace proxima::figures_test
