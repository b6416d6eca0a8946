// The panel that opens models, drawn by ImGui without a window.
#include "viewer/window/file_panel.h"

#include "folder_test.h"
#include "viewer/imgui_context.h"

#include <algorithm>
#include <chrono>
#include <imgui.h>
#include <thread>

namespace proxima::file_panel_test {
namespace {

class FilePanelTest : public FolderTest {
protected:
    void SetUp() override
    {
        FolderTest::SetUp();
        before_ = std::filesystem::current_path();
        std::filesystem::current_path(folder());
    }
    void TearDown() override
    {
        std::filesystem::current_path(before_);
        FolderTest::TearDown();
    }

    /// One frame: what is to be opened.
    std::optional<std::string> draw()
    {
        ImGui::NewFrame();
        widgets.clear();
        auto chosen = panel.draw(0, 0, 500, 500, widgets);
        ImGui::Render();
        return chosen;
    }

    /// Opens the panel and types into its field.
    void type(const char* text)
    {
        panel.open();
        for (int frame = 0; frame < 3; ++frame) EXPECT_EQ(draw(), std::nullopt);
        ImGui::GetIO().AddInputCharactersUTF8(text);
        for (int frame = 0; frame < 3; ++frame) EXPECT_EQ(draw(), std::nullopt);
    }

    /// Draws until the list shows `name`, and says where it stands.
    WidgetBounds found(const std::string& name)
    {
        for (;;) {
            EXPECT_EQ(draw(), std::nullopt);
            const auto at = std::ranges::find(widgets, name, &WidgetBounds::name);
            if (at != widgets.end()) return *at;
            std::this_thread::sleep_for(std::chrono::milliseconds(1)); // a thread lists the folder
        }
    }

    FilePanel panel{[] {}};
    std::vector<WidgetBounds> widgets; ///< of the last frame

private:
    testing::ImguiContext context_;
    std::filesystem::path before_;
};

TEST_F(FilePanelTest, OpensABuiltInWhateverFoldersThereAre)
{
    std::filesystem::create_directory("cube");
    type("cube");
    panel.enter();
    EXPECT_EQ(draw(), "cube");
}

TEST_F(FilePanelTest, EntersAFolderAndOpensAFile)
{
    std::filesystem::create_directory("cubes");
    type("cubes");
    panel.enter();
    EXPECT_EQ(draw(), std::nullopt);
    panel.close();
    EXPECT_EQ(draw(), std::nullopt);
    type((path("cubes") / "a.obj").c_str());
    panel.enter();
    EXPECT_EQ(draw(), (path("cubes") / "a.obj").string());
}

TEST_F(FilePanelTest, ShowsTheListAtOnePlaceHoweverLongTheFoldersNameIs)
{
    panel.open();
    const float short_name = found("../").y;
    const std::filesystem::path folder = path(std::string(150, 'a')) / std::string(150, 'b') /
                                         "\u00e4\u00f6\u00fc" / std::string(200, 'c');
    std::filesystem::create_directories(folder / "last");
    panel.go_to(folder);
    EXPECT_EQ(found("last/").y, short_name + ImGui::GetTextLineHeightWithSpacing());
    EXPECT_EQ(found("../").y, short_name);
}

TEST_F(FilePanelTest, ForgetsAnEnterAsItCloses)
{
    for (const bool is_drawn_closed : {false, true}) {
        type("a.obj");
        panel.enter();
        panel.close();
        if (is_drawn_closed) {
            EXPECT_EQ(draw(), std::nullopt);
        }
        panel.open();
        EXPECT_EQ(draw(), std::nullopt) << is_drawn_closed;
        panel.close();
        panel.enter();
        panel.open();
        EXPECT_EQ(draw(), std::nullopt) << "of a panel that is closed";
        panel.close();
        EXPECT_EQ(draw(), std::nullopt);
    }
}

} // namespace
} // namespace proxima::file_panel_test
