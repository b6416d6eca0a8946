// Files that appear whole or not at all: written under a temporary name beside the destination and
// renamed over it when all of it is on the disk.
//
//     auto file = OutputFile::create("mesh.ply");
//     if (!file) return tl::unexpected(file.error());
//     if (auto status = file->write(text); !status) return status;   // errors may also wait for
//     return file->commit();                                         // commit, which repeats them
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

namespace proxima {

/// The file that a path stands for once its own symbolic links are followed, which need not exist;
/// nothing where they go round in circles.
[[nodiscard]] std::optional<std::filesystem::path> linked_file(std::filesystem::path path);

struct OutputOptions {
    Progress* progress = nullptr; ///< stage "writing", steps are bytes
    std::uint64_t bytes = 0;      ///< about how many there will be, for the stage alone
};

/// A file being written. Until commit() succeeds the destination keeps what it had; the destructor
/// throws away what was not committed. What a killed process left in the folder under a temporary
/// name is removed when this process first writes there.
///
/// One's own file keeps who may read, write and execute it, and its group; bits that change the
/// user or group of who executes it are dropped. In place of another user's file comes one of one's
/// own, as a new file has it. A file that may not be written is refused although its folder would
/// allow the rename. A symbolic link stays a link and its target is replaced; other hard links of a
/// file keep what they had.
///
/// A destination that is no regular file (/dev/full, a pipe), and what exists under /dev, but for
/// /dev/shm, and under /proc (/dev/stdout is a file when redirected), is appended to directly: there
/// commit() only tells whether all of it arrived. Writes go through a buffer. Not thread safe; two
/// objects for one destination may live at the same time, the last commit wins.
class OutputFile {
public:
    /// Error file_not_writable with the reason: folder missing or read-only, destination is a
    /// folder or read-only, disk full, a pipe that nobody has begun to read within three seconds;
    /// cancelled where options.progress asks to stop meanwhile.
    [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& path,
                                                   const OutputOptions& options = {});

    OutputFile(OutputFile&&) noexcept;
    OutputFile& operator=(OutputFile&&) noexcept;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();

    /// Whether the destination is appended to directly.
    [[nodiscard]] bool is_direct() const noexcept;

    /// Appends. Error file_not_writable where the system refuses bytes (disk full, file-size
    /// limit), cancelled where options.progress asks to stop; from then on every call returns the
    /// same error. A file-size limit raises no signal.
    [[nodiscard]] Status write(std::span<const std::byte> bytes);
    [[nodiscard]] Status write(std::string_view text);

    /// Replaces bytes that were written before, and errors like write(). A destination that is
    /// appended to directly is refused.
    [[nodiscard]] Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes);

    /// Writes what is still buffered, waits until the disk has it, and renames it over the
    /// destination: after a power cut the folder has the old file or the new one. The object is
    /// empty afterwards, on success and on failure. An error says so where the destination has been
    /// replaced before. \pre called once
    [[nodiscard]] Status commit();

private:
    struct State;
    explicit OutputFile(std::unique_ptr<State> state) noexcept;
    std::unique_ptr<State> state_;
};

} // namespace proxima
