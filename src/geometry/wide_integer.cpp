#include "geometry/wide_integer.h"

#include "base/check.h"

#include <algorithm>
#include <cmath>

namespace proxima::detail {
namespace {

constexpr int limb_bits = 32;

} // namespace

WideInteger::WideInteger(double value) noexcept
{
    if (value == 0) return;
    int exponent = 0;
    // |value| = mantissa * 2^shift * 2^-1074 with a whole mantissa below 2^53.
    const double fraction = std::frexp(std::abs(value), &exponent);
    auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
    int shift = exponent - 53 + 1074;
    if (shift < 0) { // subnormal: the lowest bits are zeros
        mantissa >>= -shift;
        shift = 0;
    }
    const int first = shift / limb_bits;
    const int bits = shift % limb_bits;
    const std::uint64_t low = mantissa << bits;
    const std::uint64_t high = bits == 0 ? 0U : mantissa >> (64 - bits);
    set_limb(first, low);
    set_limb(first + 1, low >> limb_bits);
    set_limb(first + 2, high);
    size_ = first + 3;
    sign_ = value > 0 ? 1 : -1;
    trim();
}

ScaledNumber WideInteger::rounded() const noexcept
{
    double top = 0; // 65 bits or more
    for (int i = size_; i-- > std::max(size_ - 3, 0);)
        top = top * 0x1p32 + static_cast<double>(limb(i));
    return {sign_ * top, limb_bits * std::max(size_ - 3, 0)};
}

void WideInteger::trim() noexcept
{
    while (size_ > 0 && limb(size_ - 1) == 0) --size_;
    if (size_ == 0) sign_ = 0;
}

int WideInteger::compare_sizes(const WideInteger& a, const WideInteger& b) noexcept
{
    if (a.size_ != b.size_) return a.size_ < b.size_ ? -1 : 1;
    for (int i = a.size_ - 1; i >= 0; --i)
        if (a.limb(i) != b.limb(i)) return a.limb(i) < b.limb(i) ? -1 : 1;
    return 0;
}

WideInteger WideInteger::add_sizes(const WideInteger& a, const WideInteger& b) noexcept
{
    WideInteger sum;
    sum.size_ = std::max(a.size_, b.size_) + 1;
    PROXIMA_CHECK_LE(sum.size_, capacity);
    std::uint64_t carry = 0;
    for (int i = 0; i < sum.size_; ++i) {
        carry += a.limb(i) + b.limb(i);
        sum.set_limb(i, carry);
        carry >>= limb_bits;
    }
    sum.sign_ = 1;
    sum.trim();
    return sum;
}

WideInteger WideInteger::subtract_sizes(const WideInteger& a, const WideInteger& b) noexcept
{
    WideInteger difference;
    difference.size_ = a.size_;
    std::uint64_t borrow = 0;
    for (int i = 0; i < difference.size_; ++i) {
        const std::uint64_t taken = a.limb(i) - b.limb(i) - borrow;
        difference.set_limb(i, taken);
        borrow = taken >> 63U;
    }
    difference.sign_ = 1;
    difference.trim();
    return difference;
}

WideInteger WideInteger::operator-() const noexcept
{
    WideInteger negated = *this;
    negated.sign_ = -sign_;
    return negated;
}

WideInteger operator+(const WideInteger& a, const WideInteger& b) noexcept
{
    if (a.sign_ == 0) return b;
    if (b.sign_ == 0) return a;
    if (a.sign_ == b.sign_) {
        const WideInteger sum = WideInteger::add_sizes(a, b);
        return a.sign_ > 0 ? sum : -sum;
    }
    const bool a_is_larger = WideInteger::compare_sizes(a, b) >= 0;
    const WideInteger rest =
        a_is_larger ? WideInteger::subtract_sizes(a, b) : WideInteger::subtract_sizes(b, a);
    return (a_is_larger ? a.sign_ : b.sign_) > 0 ? rest : -rest;
}

WideInteger operator-(const WideInteger& a, const WideInteger& b) noexcept
{
    return a + (-b);
}

WideInteger operator*(const WideInteger& a, const WideInteger& b) noexcept
{
    WideInteger product;
    if (a.sign_ == 0 || b.sign_ == 0) return product;
    product.size_ = a.size_ + b.size_;
    PROXIMA_CHECK_LE(product.size_, WideInteger::capacity);
    for (int i = 0; i < a.size_; ++i) {
        std::uint64_t carry = 0;
        for (int j = 0; j < b.size_ || carry != 0; ++j) {
            carry += product.limb(i + j) + a.limb(i) * b.limb(j);
            product.set_limb(i + j, carry);
            carry >>= limb_bits;
        }
    }
    product.sign_ = a.sign_ * b.sign_;
    product.trim();
    return product;
}

} // namespace proxima::detail
