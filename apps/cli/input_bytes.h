// Bytes that a command reads from front to back: of a file, a pipe, standard input, or a text.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace proxima {

/// As the name of an input: standard input.
inline constexpr const char* from_stdin = "-";

class InputBytes {
public:
    /// A file, a pipe or, as "-", standard input. Stage "reading numbers", steps are bytes. Errors:
    /// file_not_found (a folder, not there, not readable).
    [[nodiscard]] static Result<InputBytes> open(const std::string& path, Progress* progress);

    /// The text itself; errors call it `name`.
    [[nodiscard]] static InputBytes of_text(std::string text, std::string name);

    InputBytes(InputBytes&& other) noexcept;
    InputBytes& operator=(InputBytes&&) = delete;
    ~InputBytes();

    /// For messages.
    [[nodiscard]] const std::string& name() const noexcept { return name_; }

    /// Of all; nothing for pipes.
    [[nodiscard]] std::optional<std::uint64_t> size() const noexcept { return size_; }

    /// How many bytes came; fewer than asked for at the end alone. Waits for pipes. Error
    /// cancelled, or what the system says.
    [[nodiscard]] Result<std::size_t> read(char* bytes, std::size_t count);

private:
    InputBytes() = default;

    /// Returns once bytes are there or the end is.
    [[nodiscard]] Status wait() const;

    int file_ = -1;
    bool owned_ = false;
    std::string text_;         ///< where there is no file
    std::size_t position_ = 0; ///< in the text
    std::string name_;
    std::optional<std::uint64_t> size_;
    Progress* progress_ = nullptr;
};

} // namespace proxima
