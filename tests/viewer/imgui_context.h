// ImGui without a window: frames can be begun and ended, and nothing is shown.
#pragma once

#include <imgui.h>

namespace proxima::testing {

class ImguiContext {
public:
    ImguiContext()
    {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {800, 600};
        unsigned char* pixels = nullptr;
        int width = 0;
        int height = 0;
        io.Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
    }
    ImguiContext(const ImguiContext&) = delete;
    ImguiContext& operator=(const ImguiContext&) = delete;
    ~ImguiContext() { ImGui::DestroyContext(); }
};

} // namespace proxima::testing
