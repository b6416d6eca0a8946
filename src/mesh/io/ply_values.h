// The values of a PLY body, one after the other, from text or from bytes: the one difference
// between the encodings, so that elements are read by one piece of code.
#pragma once

#include "mesh/io/ply_header.h"
#include "mesh/io/text_cursor.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace proxima::detail {

/// Why a value could not be read.
enum class PlyFailure : std::uint8_t { none, ends_early, no_number, missing_value, extra_value };

/// One element per line, values apart by blanks.
class PlyTextValues {
public:
    explicit PlyTextValues(std::string_view body) noexcept : cursor_(body) {}

    [[nodiscard]] const char* position() const noexcept { return cursor_.position(); }
    [[nodiscard]] PlyFailure failure() const noexcept { return failure_; }

    /// The fewest bytes that a value takes: a digit and what parts it from the next.
    [[nodiscard]] static std::size_t least_bytes(PlyType /*type*/) noexcept { return 2; }
    /// Bytes left, the blank that the last value need not have included.
    [[nodiscard]] std::size_t remaining() const noexcept { return cursor_.remaining() + 1; }

    [[nodiscard]] bool begin_element() noexcept
    {
        return cursor_.next_filled_line() || failed(PlyFailure::ends_early);
    }

    [[nodiscard]] bool real(PlyType /*type*/, double& value) noexcept
    {
        return cursor_.real(value) || no_value();
    }

    [[nodiscard]] bool integer(PlyType /*type*/, std::int64_t& value) noexcept
    {
        return cursor_.integer(value) || no_value();
    }

    [[nodiscard]] bool skip(PlyType /*type*/) noexcept
    {
        return !cursor_.word().empty() || no_value();
    }

    [[nodiscard]] bool end_element() noexcept
    {
        return cursor_.at_line_end() || failed(PlyFailure::extra_value);
    }

    /// True where nothing but blank lines follows.
    [[nodiscard]] bool is_complete() noexcept { return !cursor_.next_filled_line(); }

private:
    [[nodiscard]] bool failed(PlyFailure failure) noexcept
    {
        failure_ = failure;
        return false;
    }

    [[nodiscard]] bool no_value() noexcept
    {
        if (cursor_.at_end()) return failed(PlyFailure::ends_early);
        return failed(cursor_.at_line_end() ? PlyFailure::missing_value : PlyFailure::no_number);
    }

    TextCursor<TextDialect{}> cursor_;
    PlyFailure failure_ = PlyFailure::none;
};

/// Packed bytes of the given order.
template <std::endian Order>
class PlyBinaryValues {
public:
    explicit PlyBinaryValues(std::string_view body) noexcept
        : position_(body.data()), end_(body.data() + body.size())
    {}

    [[nodiscard]] const char* position() const noexcept { return position_; }
    [[nodiscard]] PlyFailure failure() const noexcept { return failure_; }
    [[nodiscard]] static std::size_t least_bytes(PlyType type) noexcept { return size_of(type); }
    [[nodiscard]] std::size_t remaining() const noexcept
    {
        return static_cast<std::size_t>(end_ - position_);
    }

    [[nodiscard]] bool begin_element() const noexcept { return true; }
    [[nodiscard]] bool end_element() const noexcept { return true; }

    [[nodiscard]] bool real(PlyType type, double& value) noexcept
    {
        if (remaining() < size_of(type)) return failed(PlyFailure::ends_early);
        value = number(type);
        position_ += size_of(type);
        return true;
    }

    [[nodiscard]] bool integer(PlyType type, std::int64_t& value) noexcept
    {
        constexpr double whole_limit = 9007199254740992.0; // 2^53
        double number = 0;
        if (!real(type, number)) return false;
        if (!(std::abs(number) <= whole_limit) || number != std::trunc(number)) {
            return failed(PlyFailure::no_number);
        }
        value = static_cast<std::int64_t>(number);
        return true;
    }

    [[nodiscard]] bool skip(PlyType type) noexcept
    {
        if (remaining() < size_of(type)) return failed(PlyFailure::ends_early);
        position_ += size_of(type);
        return true;
    }

    /// True at the end, where some writers put one more line end.
    [[nodiscard]] bool is_complete() const noexcept
    {
        const std::string_view rest(position_, remaining());
        return rest.empty() || rest == "\n" || rest == "\r\n";
    }

private:
    [[nodiscard]] bool failed(PlyFailure failure) noexcept
    {
        failure_ = failure;
        return false;
    }

    template <class T>
    [[nodiscard]] double load() const noexcept
    {
        unsigned char bytes[sizeof(T)];
        std::memcpy(bytes, position_, sizeof(T));
        if constexpr (Order != std::endian::native) {
            for (std::size_t i = 0; i < sizeof(T) / 2; ++i) {
                std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
            }
        }
        T value;
        std::memcpy(&value, bytes, sizeof(T));
        return static_cast<double>(value);
    }

    [[nodiscard]] double number(PlyType type) const noexcept
    {
        switch (type) {
        case PlyType::int8:
            return load<std::int8_t>();
        case PlyType::uint8:
            return load<std::uint8_t>();
        case PlyType::int16:
            return load<std::int16_t>();
        case PlyType::uint16:
            return load<std::uint16_t>();
        case PlyType::int32:
            return load<std::int32_t>();
        case PlyType::uint32:
            return load<std::uint32_t>();
        case PlyType::float32:
            return load<float>();
        case PlyType::float64:
            return load<double>();
        }
        return 0;
    }

    const char* position_;
    const char* end_;
    PlyFailure failure_ = PlyFailure::none;
};

} // namespace proxima::detail
