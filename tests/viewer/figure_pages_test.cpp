#include "viewer/figures/figure_pages.h"

#include "code_of.h"
#include "folder_test.h"
#include "proxima/execution.h"
#include "viewer/scene_shapes.h"

#include <fstream>
#include <iterator>

namespace proxima::figure_pages_test {
namespace {

class FigurePages : public FolderTest {
protected:
    [[nodiscard]] std::string text_of(const std::string& name) const
    {
        std::ifstream file(path(name));
        return {std::istreambuf_iterator<char>(file), {}};
    }
    std::unique_ptr<Renderer> renderer = make_software_renderer();
};

Result<FigureContent> two_panels(const Execution& /*context*/)
{
    FigureContent content;
    content.caption = "a < b & c";
    for (const unsigned color : {0xFF0000U, 0x0000FFU}) {
        ScenePanel panel{"panel", {}, {}, {.width = 60, .height = 40}};
        panel.scene.background_top = srgb(color);
        panel.scene.background_bottom = srgb(color);
        content.panels.emplace_back(panel);
    }
    return content;
}

Result<FigureContent> drawing(const Execution& /*context*/)
{
    FigureContent content;
    content.caption = "a drawing";
    content.drawing = Figure{.width = 30, .height = 20};
    return content;
}

Result<FigureContent> failing(const Execution& /*context*/)
{
    return fail(ErrorCode::broken_invariant, "no figure");
}

TEST_F(FigurePages, LongTitlesStayAboveTheirPanels)
{
    auto content = two_panels({});
    content->columns = 2;
    const auto ink_in_gap = [&](const std::string& title) {
        for (auto& panel : content->panels) std::get<ScenePanel>(panel).title = title;
        const auto picture = figure_picture(*content, *renderer);
        EXPECT_TRUE(picture);
        // Panels are at 12 to 72 and at 84 to 144, from 46 downward.
        int inked = 0;
        for (int y = 0; y < 46; ++y) {
            for (int x = 73; x < 84; ++x)
                if (picture->pixel(x, y) != picture->pixel(0, 0)) ++inked;
        }
        return inked;
    };
    EXPECT_EQ(ink_in_gap("a title of some forty letters, or of more"), 0);
}

TEST_F(FigurePages, PlacesPanelsBesideAndBelowEachOther)
{
    auto content = two_panels({});
    content->columns = 2;
    const auto beside = figure_picture(*content, *renderer);
    ASSERT_TRUE(beside);
    EXPECT_EQ(beside->pixel(12 + 30, 46 + 20), (std::array<std::uint8_t, 3>{255, 0, 0}));
    EXPECT_EQ(beside->pixel(84 + 30, 46 + 20), (std::array<std::uint8_t, 3>{0, 0, 255}));
    content->columns = 1;
    const auto below = figure_picture(*content, *renderer);
    ASSERT_TRUE(below);
    EXPECT_EQ(below->width, 60 + 24);
    EXPECT_EQ(below->pixel(12 + 30, 46 + 86 + 20), (std::array<std::uint8_t, 3>{0, 0, 255}));
}

TEST_F(FigurePages, WritesTwoFilesPerDrawingAndOnePerScene)
{
    const auto flat = write_figure_page({"9.1", "Flat", drawing}, folder(), *renderer, {});
    ASSERT_TRUE(flat);
    EXPECT_EQ(flat->files, (std::vector<std::string>{"figure_9_1.png", "figure_9_1.svg"}));
    const auto scenes = write_figure_page({"9.2", "Scenes", two_panels}, folder(), *renderer, {});
    ASSERT_TRUE(scenes);
    EXPECT_EQ(scenes->files, std::vector<std::string>{"figure_9_2.png"});
    EXPECT_EQ(entries(), 3);
    EXPECT_EQ(text_of("figure_9_1.png").substr(1, 3), "PNG");
    EXPECT_NE(text_of("figure_9_1.svg").find("<svg"), std::string::npos);
}

TEST_F(FigurePages, LeavesNoFileAfterAFailure)
{
    const auto page = write_figure_page({"9.3", "Failing", failing}, folder(), *renderer, {});
    ASSERT_FALSE(page);
    EXPECT_EQ(page.error().message, "no figure");
    Progress progress;
    progress.cancel();
    const auto stopped = make_software_renderer(&progress);
    const auto cancelled =
        write_figure_page({"9.2", "Scenes", two_panels}, folder(), *stopped, {{}, &progress});
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(code_of(cancelled), ErrorCode::cancelled);
    EXPECT_EQ(entries(), 0);
}

TEST_F(FigurePages, TheSheetShowsAllFiguresAndListsMissingOnes)
{
    const auto page = write_figure_page({"9.2", "Scenes", two_panels}, folder(), *renderer, {});
    ASSERT_TRUE(page);
    const std::vector<FigurePage> pages = {*page};
    const std::vector<MissingFigure> missing = {{"9.4", "A device", "A photograph."}};
    const std::string html = figure_sheet(pages, missing);
    EXPECT_NE(html.find("<img src=\"figure_9_2.png\""), std::string::npos);
    EXPECT_NE(html.find("a &lt; b &amp; c"), std::string::npos);
    EXPECT_NE(html.find("proxima figures --out DIR --only 9.2"), std::string::npos);
    EXPECT_NE(html.find("Figure 9.4. A device.</b> A photograph."), std::string::npos);
}

} // namespace
} // namespace proxima::figure_pages_test
