// What a method costs, counted by running it: a number that counts what is done to it (thesis 3.3,
// 3.6, Table 3.2).
//
//     reset_operation_counts();
//     const auto sum = geometric_sum(features, half_size);      // on Counted
//     std::cout << operation_counts().flops();
#pragma once

#include "minkowski/scalar_vector.h"

#include <cstdint>

namespace proxima {

/// Operations on Counted numbers of one thread since its last reset. A dot or cross product is
/// counted as such and, besides, by its additions and multiplications.
struct OperationCounts {
    std::int64_t additions = 0;
    std::int64_t subtractions = 0;
    std::int64_t multiplications = 0;
    std::int64_t divisions = 0;
    std::int64_t negations = 0; ///< sign changes and absolute values
    std::int64_t comparisons = 0;
    std::int64_t dot_products = 0;
    std::int64_t cross_products = 0;

    /// The thesis's flops: no comparisons, no negations.
    [[nodiscard]] std::int64_t flops() const noexcept
    {
        return additions + subtractions + multiplications + divisions;
    }
    friend bool operator==(const OperationCounts&, const OperationCounts&) = default;
};

/// The counters of the calling thread.
[[nodiscard]] OperationCounts& operation_counts() noexcept;

/// Sets the counters of the calling thread to zero.
void reset_operation_counts() noexcept;

/// A double whose operations are counted. Reading its value is free: it serves bookkeeping, such as
/// bounds on rounding, that is no part of the counted method.
class Counted {
public:
    Counted() = default;
    // NOLINTNEXTLINE(google-explicit-constructor): numbers in formulas read as in plain double
    Counted(double value) noexcept : value_(value) {}

    [[nodiscard]] double value() const noexcept { return value_; }

    friend Counted operator+(Counted a, Counted b) noexcept
    {
        ++operation_counts().additions;
        return {a.value_ + b.value_};
    }
    friend Counted operator-(Counted a, Counted b) noexcept
    {
        ++operation_counts().subtractions;
        return {a.value_ - b.value_};
    }
    friend Counted operator*(Counted a, Counted b) noexcept
    {
        ++operation_counts().multiplications;
        return {a.value_ * b.value_};
    }
    friend Counted operator/(Counted a, Counted b) noexcept
    {
        ++operation_counts().divisions;
        return {a.value_ / b.value_};
    }
    Counted operator-() const noexcept
    {
        ++operation_counts().negations;
        return {-value_};
    }
    Counted& operator+=(Counted other) noexcept { return *this = *this + other; }
    Counted& operator-=(Counted other) noexcept { return *this = *this - other; }
    Counted& operator*=(Counted other) noexcept { return *this = *this * other; }
    Counted& operator/=(Counted other) noexcept { return *this = *this / other; }

    friend bool operator==(Counted a, Counted b) noexcept { return compared(a.value_ == b.value_); }
    friend bool operator!=(Counted a, Counted b) noexcept { return compared(a.value_ != b.value_); }
    friend bool operator<(Counted a, Counted b) noexcept { return compared(a.value_ < b.value_); }
    friend bool operator<=(Counted a, Counted b) noexcept { return compared(a.value_ <= b.value_); }
    friend bool operator>(Counted a, Counted b) noexcept { return compared(a.value_ > b.value_); }
    friend bool operator>=(Counted a, Counted b) noexcept { return compared(a.value_ >= b.value_); }

    friend Counted abs(Counted a) noexcept
    {
        ++operation_counts().negations;
        return {a.value_ < 0 ? -a.value_ : a.value_};
    }

    static void count_dot_product() noexcept { ++operation_counts().dot_products; }
    static void count_cross_product() noexcept { ++operation_counts().cross_products; }

private:
    [[nodiscard]] static bool compared(bool outcome) noexcept
    {
        ++operation_counts().comparisons;
        return outcome;
    }

    double value_ = 0;
};

[[nodiscard]] inline double to_double(Counted value) noexcept
{
    return value.value();
}

} // namespace proxima

/// What Eigen must know of Counted.
template <>
struct Eigen::NumTraits<proxima::Counted> : Eigen::NumTraits<double> {
    using Real = proxima::Counted;
    using NonInteger = proxima::Counted;
    using Nested = proxima::Counted;
    using Literal = proxima::Counted;
};
