// A number that counts what is done to it, written for these tests alone: the published
// counts are those of this and of any other counting scalar.
#pragma once

namespace proxima {

struct NumberTally {
    int additions = 0; ///< and subtractions
    int multiplications = 0;
    int comparisons = 0;

    [[nodiscard]] int flops() const { return additions + multiplications; }
};

struct CountingNumber {
    static inline NumberTally tally;

    double value = 0;

    CountingNumber() = default;
    // NOLINTNEXTLINE(google-explicit-constructor): as free as a built-in number
    CountingNumber(double number) : value(number) {}

    friend CountingNumber operator+(CountingNumber a, CountingNumber b)
    {
        ++tally.additions;
        return {a.value + b.value};
    }
    friend CountingNumber operator-(CountingNumber a, CountingNumber b)
    {
        ++tally.additions;
        return {a.value - b.value};
    }
    friend CountingNumber operator*(CountingNumber a, CountingNumber b)
    {
        ++tally.multiplications;
        return {a.value * b.value};
    }
    CountingNumber operator-() const { return {-value}; }
    friend CountingNumber abs(CountingNumber a) { return {a.value < 0 ? -a.value : a.value}; }
    friend bool operator<(CountingNumber a, CountingNumber b)
    {
        ++tally.comparisons;
        return a.value < b.value;
    }
    friend bool operator<=(CountingNumber a, CountingNumber b)
    {
        ++tally.comparisons;
        return a.value <= b.value;
    }
};

} // namespace proxima
