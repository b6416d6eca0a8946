// What a folder offers to somebody who looks for a model: folders, and files that can be read.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace proxima {

struct FolderEntry {
    std::string name;
    bool is_folder = false;
    std::uintmax_t bytes = 0; ///< of a file
};

struct FolderList {
    /// More are left out.
    static constexpr std::size_t most_entries = 20'000;

    std::filesystem::path folder;     ///< absolute
    std::vector<FolderEntry> entries; ///< folders, then files, each by name; hidden ones are not
    bool is_whole = true;
};

/// Files by their extensions alone. Errors: file_not_found (no such folder, or it may not be read),
/// cancelled.
[[nodiscard]] Result<FolderList> list_folder(const std::filesystem::path& folder,
                                             const Progress* progress = nullptr);

/// What somebody typed as a path: without spaces and quotes round it, `~` as their home, relative
/// to a folder. Names of built-ins stay as they are.
[[nodiscard]] std::filesystem::path typed_path(std::string_view typed,
                                               const std::filesystem::path& folder);

} // namespace proxima
