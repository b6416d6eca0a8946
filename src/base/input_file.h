// A whole regular file as an array of bytes: read into memory, or mapped.
//
//     read   the process's own copy: whoever changes the file later changes nothing here
//     map    pages of the file itself, read when they are touched: shared by processes, there at
//            once, and fatal (SIGBUS) when somebody shortens the file
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace proxima {

/// What has to live as long as the bytes are used; copies share it.
struct FileBytes {
    std::span<const std::byte> bytes; ///< begins at a multiple of 128, or of a page where mapped
    std::shared_ptr<const void> storage;

    [[nodiscard]] std::string_view text() const noexcept
    {
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
};

struct FileReadOptions {
    FileAccess access = FileAccess::read;
    MemoryBudget budget = {};     ///< of what is read
    Progress* progress = nullptr; ///< stage "loading file", steps are bytes
    const char* advice = "";      ///< what to do where the budget does not suffice
    /// False: `path`, an absolute one, is refused where a part of it is a symbolic link, whoever puts one there meanwhile.
    bool follow_links = true;
};

/// The content of a regular file. Pipes and devices are refused, not waited for. Errors:
/// file_not_found with the system's reason, budget_exceeded, malformed_file if it is empty or
/// becomes shorter while it is read, cancelled.
[[nodiscard]] Result<FileBytes> read_file(const std::filesystem::path& path,
                                          const FileReadOptions& options);

} // namespace proxima
