// Whole numbers wide enough for any orientation determinant of doubles, on the stack.
//
// Every double is a whole multiple of 2^-1074 of at most 2,098 bits. Three sums of a few products of
// two doubles multiply to 12,600 bits, and sums of a few such products stay below 12,800.
// Slow (microseconds): for the inputs on which expansions would over- or underflow.
#pragma once

#include "geometry/scaled_number.h"

#include <array>
#include <cstdint>

namespace proxima::detail {

/// Sign and size; the limbs of the size are little end first.
class WideInteger {
public:
    WideInteger() noexcept = default;

    /// value / 2^-1074. \pre finite
    explicit WideInteger(double value) noexcept;

    /// -1, 0 or +1.
    [[nodiscard]] int sign() const noexcept { return sign_; }

    /// The number itself, within 2^-52 of its size.
    [[nodiscard]] ScaledNumber rounded() const noexcept;

    [[nodiscard]] WideInteger operator-() const noexcept;
    friend WideInteger operator+(const WideInteger& a, const WideInteger& b) noexcept;
    friend WideInteger operator-(const WideInteger& a, const WideInteger& b) noexcept;
    /// \pre the product has at most 12,800 bits
    friend WideInteger operator*(const WideInteger& a, const WideInteger& b) noexcept;

private:
    static constexpr int capacity = 400;

    [[nodiscard]] static int compare_sizes(const WideInteger& a, const WideInteger& b) noexcept;
    [[nodiscard]] static WideInteger add_sizes(const WideInteger& a, const WideInteger& b) noexcept;
    /// \pre a's size is not below b's
    [[nodiscard]] static WideInteger subtract_sizes(const WideInteger& a,
                                                    const WideInteger& b) noexcept;
    [[nodiscard]] std::uint64_t limb(int index) const noexcept
    {
        return index < size_ ? limbs_[static_cast<std::size_t>(index)] : 0U;
    }
    void set_limb(int index, std::uint64_t value) noexcept
    {
        limbs_[static_cast<std::size_t>(index)] = static_cast<std::uint32_t>(value);
    }
    void trim() noexcept;

    std::array<std::uint32_t, capacity> limbs_ = {};
    int size_ = 0; ///< limbs in use; the topmost is not zero
    int sign_ = 0;
};

} // namespace proxima::detail
