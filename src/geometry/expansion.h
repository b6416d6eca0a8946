// Exact sums and products of doubles as floating-point expansions [shewchuk-1997].
//
//     value = c[0] + c[1] + ... + c[n-1], exactly; |c[i]| grows, components do not overlap,
//     zero components are left out, so the sign of the value is the sign of c[n-1]
//
// Error-free only while nothing over- or underflows: with inputs that are zero or between
// min_expansion_input and max_expansion_input in size, every product of up to three differences of
// inputs is. (A double of at least 2^-288 is a multiple of 2^-340, and so is every difference;
// three of them multiply to a multiple of 2^-1020, a double's grid reaches down to 2^-1074. Upward
// three differences stay below 2^903, and splitting adds 28 bits to one factor.)
// Products are split as Dekker does: no fused multiply-add, the same bits on every machine.
#pragma once

#include <array>
#include <cfloat>
#include <cmath>
#include <limits>

namespace proxima::detail {

static_assert(std::numeric_limits<double>::is_iec559 && FLT_EVAL_METHOD == 0,
              "expansions need IEEE 754 doubles without hidden extra precision");

inline constexpr double min_expansion_input = 0x1p-288;
inline constexpr double max_expansion_input = 0x1p+300;

/// The same where products of up to four are formed.
inline constexpr double min_quartic_input = 0x1p-216;
inline constexpr double max_quartic_input = 0x1p+216;

/// Whether this number may enter an expansion of degree four.
[[nodiscard]] inline bool fits_quartic_expansion(double value) noexcept
{
    const double size = std::abs(value);
    return size <= max_quartic_input && (size >= min_quartic_input || size == 0);
}

/// Whether this number may enter an expansion of degree up to three.
[[nodiscard]] inline bool fits_expansion(double value) noexcept
{
    const double size = std::abs(value);
    return size <= max_expansion_input && (size >= min_expansion_input || size == 0);
}

/// rounded + error is exact.
struct RoundedWithError {
    double rounded;
    double error;
};

/// a + b (Knuth).
[[nodiscard]] inline RoundedWithError two_sum(double a, double b) noexcept
{
    const double sum = a + b;
    const double b_part = sum - a;
    const double a_part = sum - b_part;
    return {sum, (a - a_part) + (b - b_part)};
}

/// a + b where |a| >= |b| or a == 0 (Dekker).
[[nodiscard]] inline RoundedWithError fast_two_sum(double a, double b) noexcept
{
    const double sum = a + b;
    return {sum, b - (sum - a)};
}

/// value as the sum of two numbers of at most 26 bits.
[[nodiscard]] inline RoundedWithError split(double value) noexcept
{
    constexpr double splitter = 0x1p27 + 1;
    const double scaled = splitter * value;
    const double high = scaled - (scaled - value);
    return {high, value - high};
}

/// a * b, with b split already.
[[nodiscard]] inline RoundedWithError two_product(double a, double b,
                                                  RoundedWithError b_split) noexcept
{
    const double product = a * b;
    const RoundedWithError a_split = split(a);
    const double rest = product - a_split.rounded * b_split.rounded -
                        a_split.error * b_split.rounded - a_split.rounded * b_split.error;
    return {product, a_split.error * b_split.error - rest};
}

/// A number of at most Capacity components.
template <int Capacity>
class Expansion {
public:
    // The components beyond size() are never read, so they are not written either.
    Expansion() noexcept {} // NOLINT(modernize-use-equals-default)

    [[nodiscard]] int size() const noexcept { return size_; }
    [[nodiscard]] double operator[](int index) const noexcept
    {
        return components_[static_cast<std::size_t>(index)];
    }

    /// Appends a component larger than all before it; zeros are left out.
    void append(double component) noexcept
    {
        if (component != 0) components_[static_cast<std::size_t>(size_++)] = component;
    }

    /// -1, 0 or +1.
    [[nodiscard]] int sign() const noexcept
    {
        if (size_ == 0) return 0;
        return (*this)[size_ - 1] > 0 ? 1 : -1;
    }

    [[nodiscard]] Expansion operator-() const noexcept
    {
        Expansion negated;
        for (int i = 0; i < size_; ++i) negated.append(-(*this)[i]);
        return negated;
    }

private:
    std::array<double, static_cast<std::size_t>(Capacity)> components_;
    int size_ = 0;
};

/// a - b.
[[nodiscard]] inline Expansion<2> exact_difference(double a, double b) noexcept
{
    const RoundedWithError difference = two_sum(a, -b);
    Expansion<2> result;
    result.append(difference.error);
    result.append(difference.rounded);
    return result;
}

/// Shewchuk's fast expansion sum: merge by size, then one sweep of two-sums.
template <int A, int B>
[[nodiscard]] Expansion<A + B> operator+(const Expansion<A>& a, const Expansion<B>& b) noexcept
{
    Expansion<A + B> result;
    int next_a = 0;
    int next_b = 0;
    const auto smallest_left = [&]() noexcept {
        const bool from_a =
            next_b == b.size() || (next_a < a.size() && std::abs(a[next_a]) < std::abs(b[next_b]));
        return from_a ? a[next_a++] : b[next_b++];
    };
    const int total = a.size() + b.size();
    if (total == 0) return result;
    double running = smallest_left();
    for (int i = 1; i < total; ++i) {
        const RoundedWithError sum = two_sum(running, smallest_left());
        result.append(sum.error);
        running = sum.rounded;
    }
    result.append(running);
    return result;
}

template <int A, int B>
[[nodiscard]] Expansion<A + B> operator-(const Expansion<A>& a, const Expansion<B>& b) noexcept
{
    return a + (-b);
}

/// Shewchuk's scale expansion.
template <int A>
[[nodiscard]] Expansion<2 * A> scaled(const Expansion<A>& a, double factor) noexcept
{
    Expansion<2 * A> result;
    if (a.size() == 0) return result;
    const RoundedWithError factor_split = split(factor);
    RoundedWithError product = two_product(a[0], factor, factor_split);
    result.append(product.error);
    double running = product.rounded;
    for (int i = 1; i < a.size(); ++i) {
        product = two_product(a[i], factor, factor_split);
        const RoundedWithError low = two_sum(running, product.error);
        result.append(low.error);
        const RoundedWithError high = fast_two_sum(product.rounded, low.rounded);
        result.append(high.error);
        running = high.rounded;
    }
    result.append(running);
    return result;
}

template <int A>
[[nodiscard]] Expansion<4 * A> operator*(const Expansion<A>& a, const Expansion<2>& b) noexcept
{
    Expansion<4 * A> result;
    if (b.size() == 0) return result;
    if (b.size() == 1) {
        const Expansion<2 * A> product = scaled(a, b[0]);
        for (int i = 0; i < product.size(); ++i) result.append(product[i]);
        return result;
    }
    return scaled(a, b[0]) + scaled(a, b[1]);
}

template <int A>
[[nodiscard]] Expansion<8 * A> operator*(const Expansion<A>& a, const Expansion<4>& b) noexcept
{
    Expansion<2> low;
    Expansion<2> high;
    for (int i = 0; i < b.size(); ++i) {
        if (i < 2) {
            low.append(b[i]);
        } else {
            high.append(b[i]);
        }
    }
    return a * low + a * high;
}

/// a * b, exactly.
[[nodiscard]] inline Expansion<2> exact_product(double a, double b) noexcept
{
    const RoundedWithError product = two_product(a, b, split(b));
    Expansion<2> result;
    result.append(product.error);
    result.append(product.rounded);
    return result;
}

} // namespace proxima::detail
