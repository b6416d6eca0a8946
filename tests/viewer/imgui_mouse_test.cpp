// Clicks of the mouse as ImGui sees them, without a window, however slow its frames are.
#include "viewer/window/imgui_mouse.h"

#include "viewer/imgui_context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>
#include <string>
#include <utility>
#include <vector>

namespace proxima::imgui_mouse_test {
namespace {

using ::testing::ElementsAre;
using Seconds = ImguiMouse::Seconds;

constexpr float frame = 0.4F; // seconds: longer than a double-click may take

class ImguiMouseTest : public ::testing::Test {
protected:
    ImguiMouseTest() { ImGui::GetIO().DeltaTime = frame; }

    void add(int button, bool is_down, double seconds, Seconds deaf = Seconds(0.0))
    {
        mouse.add(button, is_down, {10, 20}, at(seconds), deaf);
    }
    void click(double seconds, Seconds deaf = Seconds(0.0))
    {
        add(0, true, seconds, deaf);
        add(0, false, seconds, deaf);
    }

    /// Draws a frame, and returns what ImGui saw of the left and the right button in it.
    std::string draw()
    {
        ImGuiIO& io = ImGui::GetIO();
        io.MousePos = {400, 300}; // as the backend sets it
        mouse.set(io);
        ImGui::NewFrame();
        std::string seen;
        for (const int button : {0, 1}) {
            if (ImGui::IsMouseClicked(button)) seen += button == 0 ? "press" : "right press";
            if (ImGui::IsMouseDoubleClicked(button)) seen += " again";
            if (ImGui::IsMouseReleased(button)) seen += button == 0 ? "release" : "right release";
        }
        EXPECT_EQ(io.MousePos.x, seen.empty() ? 400.0F : 10.0F) << seen;
        ImGui::Render();
        return seen;
    }

    /// Draws frames until ImGui has seen all that was added, and returns what it saw in each.
    std::vector<std::string> draw_all()
    {
        std::vector<std::string> seen;
        do seen.push_back(draw());
        while (mouse.has_more());
        return seen;
    }

    ImguiMouse mouse;

private:
    testing::ImguiContext context_;

    static ImguiMouse::Time at(double seconds)
    {
        return ImguiMouse::Time(
            std::chrono::duration_cast<ImguiMouse::Time::duration>(Seconds(1000.0 + seconds)));
    }
};

TEST_F(ImguiMouseTest, GivesEachPressAndReleaseItsFrame)
{
    EXPECT_THAT(draw_all(), ElementsAre(""));
    click(0.0);
    click(0.0);
    EXPECT_THAT(draw_all(), ElementsAre("press", "release", "press again", "release"));
    EXPECT_EQ(draw(), "");
    add(0, true, 1.0);
    add(1, true, 1.0);
    add(1, false, 1.0);
    EXPECT_THAT(draw_all(), ElementsAre("press", "right press", "right release"));
    EXPECT_TRUE(ImGui::IsMouseDown(0));
    EXPECT_EQ(draw(), "");
    EXPECT_TRUE(ImGui::IsMouseDown(0));
    add(0, false, 1.1);
    EXPECT_EQ(draw(), "release");
}

TEST_F(ImguiMouseTest, TakesTwoClicksForOneByWhenTheyCame)
{
    struct Case {
        double apart;
        double deaf;
        bool is_double;
    };
    double begin = 0.0;
    for (const Case& c : {Case{0.0, 0.0, true}, Case{0.29, 0.0, true}, Case{0.31, 0.0, false},
                          Case{0.55, 0.3, true}, Case{0.65, 0.3, false}, Case{5.0, 4.0, false}}) {
        click(begin);
        EXPECT_THAT(draw_all(), ElementsAre("press", "release"));
        click(begin + c.apart, Seconds(c.deaf));
        EXPECT_THAT(draw_all(), ElementsAre(c.is_double ? "press again" : "press", "release"))
            << c.apart << " s apart, " << c.deaf << " s deaf";
        begin += 100.0;
    }
}

TEST_F(ImguiMouseTest, LeavesOutButtonsThatImGuiLacks)
{
    for (const int button : {-1, 5, 7}) {
        add(button, true, 0.0);
        EXPECT_FALSE(mouse.has_more()) << button;
    }
}

} // namespace
} // namespace proxima::imgui_mouse_test
