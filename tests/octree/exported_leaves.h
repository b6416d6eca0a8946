// What other software finds in exported files.
#pragma once

#include "base/text.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <sys/wait.h>
#include <vector>

namespace proxima::testing {

/// What a program printed for each file, and how it ended.
struct Output {
    std::vector<std::vector<std::string>> files;
    std::string last_line;
    int status = 0;
};

/// Runs the Python of the system, the one that Debian's VTK belongs to.
inline Output read_by_python(const std::vector<std::filesystem::path>& files)
{
    std::string command =
        "/usr/bin/python3 '" PROXIMA_SOURCE_DIR "/tests/octree/read_exported_leaves.py'";
    for (const auto& file : files) command += concat(" '", file.string(), "'");
    command += " 2>&1";
    Output output;
    FILE* const pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return {{}, "no shell", -1};
    std::array<char, 4096> line{};
    while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) {
        std::string& text = output.last_line = line.data();
        while (!text.empty() && text.back() == '\n') text.pop_back();
        if (text == "file") {
            output.files.emplace_back();
        } else if (!output.files.empty()) {
            output.files.back().push_back(text);
        }
    }
    output.status = WEXITSTATUS(::pclose(pipe));
    return output;
}

/// As read_exported_leaves.py prints it: Python's float.hex().
inline std::string hex(double value)
{
    if (value == 0.0) return std::signbit(value) ? "-0x0.0p+0" : "0x0.0p+0";
    std::array<char, 64> text{};
    (void)std::snprintf(text.data(), text.size(), "%.13a", value);
    return text.data();
}

} // namespace proxima::testing
