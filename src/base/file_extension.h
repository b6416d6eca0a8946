// How files tell their format by name.
#pragma once

#include <filesystem>
#include <string>

namespace proxima {

/// ".png" of "A.PNG"; empty where there is none. Letters A to Z alone change.
[[nodiscard]] inline std::string lower_case_extension(const std::filesystem::path& path)
{
    std::string text = path.extension().string();
    for (char& letter : text) {
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
    }
    return text;
}

} // namespace proxima
