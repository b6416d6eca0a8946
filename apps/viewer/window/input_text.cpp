#include "viewer/window/input_text.h"

#include <imgui.h>

namespace proxima {

bool input_text(const std::string& id, std::string& text, int flags)
{
    const auto grow = [](ImGuiInputTextCallbackData* data) {
        if (data->EventFlag != ImGuiInputTextFlags_CallbackResize) return 0;
        auto& grown = *static_cast<std::string*>(data->UserData);
        grown.resize(static_cast<std::size_t>(data->BufTextLen));
        data->Buf = grown.data();
        return 0;
    };
    return ImGui::InputText(id.c_str(), text.data(), text.capacity() + 1,
                            flags | ImGuiInputTextFlags_CallbackResize, grow, &text);
}

} // namespace proxima
