// ImGui's text field for strings of any length.
#pragma once

#include <string>

namespace proxima {

/// As ImGui::InputText; the flags are its own.
[[nodiscard]] bool input_text(const std::string& id, std::string& text, int flags = 0);

} // namespace proxima
