#include "cli/printable.h"

#include <cstdint>

namespace proxima {

std::size_t utf8_length(std::string_view text) noexcept
{
    if (text.empty()) return 0;
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7F ? 1 : 0;
    const std::size_t length = byte(0) >= 0xF5   ? 0
                               : byte(0) >= 0xF0 ? 4
                               : byte(0) >= 0xE0 ? 3
                               : byte(0) >= 0xC2 ? 2
                                                 : 0;
    if (length == 0 || text.size() < length) return 0;
    std::uint32_t code = byte(0) & (0x7FU >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0U) != 0x80) return 0;
        code = code << 6U | (byte(i) & 0x3FU);
    }
    const bool is_overlong = code < (length == 4 ? 0x10000U : length == 3 ? 0x800U : 0x80U);
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    const bool is_control = code < 0xA0;
    // With these a name could show what stands beside it in another order.
    const bool is_direction =
        (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
    return is_overlong || is_surrogate || is_control || is_direction || code > 0x10FFFF ? 0
                                                                                        : length;
}

std::string printable(std::string_view text)
{
    std::string shown;
    for_each_printable(text, [&](std::string_view piece) { shown += piece; });
    return shown;
}

} // namespace proxima
