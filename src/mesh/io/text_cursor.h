// A position in a text file, and the steps that readers of line-based formats make from it.
//
//     f 1 2 \          a dialect may continue lines by a backslash,
//       3 4  # four    have comments to the end of the line,
//     vertex 1         or take line ends for blanks
//     2 3
#pragma once

#include "mesh/io/number_text.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace proxima::detail {

/// The text behind the byte order mark of UTF-8, with which some editors begin a file.
[[nodiscard]] inline std::string_view without_byte_order_mark(std::string_view text) noexcept
{
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

/// What separates values in a format.
struct TextDialect {
    bool has_comments = false;         ///< '#' to the end of the line
    bool continues_lines = false;      ///< backslash at the end of a line
    bool line_ends_are_blanks = false; ///< values may stand on any line
};

/// Cheap to copy; never reads beyond the text it was given.
template <TextDialect Dialect>
class TextCursor {
public:
    explicit TextCursor(std::string_view text) noexcept
        : position_(text.data()), end_(text.data() + text.size())
    {}

    [[nodiscard]] const char* position() const noexcept { return position_; }
    [[nodiscard]] std::size_t remaining() const noexcept
    {
        return static_cast<std::size_t>(end_ - position_);
    }
    [[nodiscard]] bool at_end() const noexcept { return position_ == end_; }

    /// Moves to the next value of this line, over blanks and what the dialect counts as such.
    void skip_blanks() noexcept
    {
        for (; position_ < end_; ++position_) {
            if (is_blank(*position_)) continue;
            if constexpr (Dialect.line_ends_are_blanks) {
                if (*position_ == '\n') continue;
            }
            if constexpr (Dialect.continues_lines) {
                if (*position_ == '\\' && step_over_continuation()) continue;
            }
            return;
        }
    }

    /// Moves to the first value of the next line that has one, or of this line if none was read
    /// yet. False at the end of the text.
    bool next_filled_line() noexcept
    {
        while (true) {
            skip_blanks();
            if (position_ == end_) return false;
            if constexpr (Dialect.has_comments) {
                if (*position_ == '#') skip_physical_line();
                if (position_ == end_) return false;
            }
            if (*position_ != '\n') return true;
            ++position_;
        }
    }

    /// True where no value is left on this line.
    [[nodiscard]] bool at_line_end() noexcept
    {
        skip_blanks();
        if (position_ == end_ || *position_ == '\n') return true;
        return Dialect.has_comments && *position_ == '#';
    }

    /// Moves behind the end of this line.
    void skip_line() noexcept
    {
        while (true) {
            const char* const begin = position_;
            skip_physical_line();
            const char* last = position_;
            if (position_ < end_) ++position_;
            if constexpr (!Dialect.continues_lines) return;
            if (last > begin && last[-1] == '\r') --last;
            if (position_ == end_ || last == begin || last[-1] != '\\') return;
        }
    }

    /// Reads a real number of this line. False, without moving over it, where there is none.
    [[nodiscard]] bool real(double& value) noexcept
    {
        skip_blanks();
        const char* const stop = parse_real(position_, end_, value);
        if (stop == nullptr || !ends_value(stop)) return false;
        position_ = stop;
        return true;
    }

    /// Reads a whole number of this line. False, without moving over it, where there is none.
    [[nodiscard]] bool integer(std::int64_t& value) noexcept
    {
        skip_blanks();
        const char* const stop = parse_integer(position_, end_, value);
        if (stop == nullptr || !ends_value(stop)) return false;
        position_ = stop;
        return true;
    }

    /// Moves over this very word if it is the next one of this line.
    template <std::size_t Size>
    [[nodiscard]] bool take_word(const char (&word)[Size]) noexcept
    {
        constexpr std::size_t length = Size - 1; // known here, so that comparing takes no call
        skip_blanks();
        if (remaining() < length || std::memcmp(position_, word, length) != 0 ||
            !ends_value(position_ + length)) {
            return false;
        }
        position_ += length;
        return true;
    }

    /// Reads letters up to the next blank of this line; empty at its end.
    [[nodiscard]] std::string_view word() noexcept
    {
        skip_blanks();
        const char* const begin = position_;
        if constexpr (std::endian::native == std::endian::little && only_blanks_end_values) {
            // Eight letters at a time while all are above the blank.
            while (remaining() >= 8) {
                std::uint64_t letters = 0;
                std::memcpy(&letters, position_, sizeof letters);
                const std::uint64_t low =
                    (letters - 0x2121212121212121U) & ~letters & 0x8080808080808080U;
                position_ += std::countr_zero(low) / 8;
                if (low != 0) break;
            }
        }
        while (position_ < end_ && !ends_value(position_)) ++position_;
        return {begin, static_cast<std::size_t>(position_ - begin)};
    }

    /// Moves over `letter` if it is the very next one.
    [[nodiscard]] bool take(char letter) noexcept
    {
        if (position_ == end_ || *position_ != letter) return false;
        ++position_;
        return true;
    }

    /// Reads a whole number at this very position, whatever follows it.
    [[nodiscard]] bool integer_here(std::int64_t& value) noexcept
    {
        const char* const stop = parse_integer(position_, end_, value);
        if (stop == nullptr) return false;
        position_ = stop;
        return true;
    }

    /// True where a value may end here.
    [[nodiscard]] bool ends_value() const noexcept { return ends_value(position_); }

private:
    static constexpr bool only_blanks_end_values =
        !Dialect.has_comments && !Dialect.continues_lines;

    static bool is_blank(char letter) noexcept
    {
        if (static_cast<unsigned char>(letter) > ' ') return false;
        return letter == ' ' || letter == '\t' || letter == '\r' || letter == '\v' ||
               letter == '\f';
    }

    [[nodiscard]] bool ends_value(const char* position) const noexcept
    {
        if (position == end_) return true;
        if (static_cast<unsigned char>(*position) <= ' ')
            return is_blank(*position) || *position == '\n';
        if (Dialect.has_comments && *position == '#') return true;
        return Dialect.continues_lines && *position == '\\';
    }

    // From the backslash to the line end that it hides.
    bool step_over_continuation() noexcept
    {
        const char* next = position_ + 1;
        if (next < end_ && *next == '\r') ++next;
        if (next == end_ || *next != '\n') return false;
        position_ = next;
        return true;
    }

    void skip_physical_line() noexcept
    {
        const void* line_end =
            remaining() == 0 ? nullptr : std::memchr(position_, '\n', remaining());
        position_ = line_end == nullptr ? end_ : static_cast<const char*>(line_end);
    }

    const char* position_;
    const char* end_;
};

} // namespace proxima::detail
