#include "mesh/io/number_text.h"

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <random>
#include <string>

namespace proxima::detail::number_text_test {
namespace {

// The whole text as a number.
std::optional<double> real(const std::string& text)
{
    double value = -12345;
    const char* stop = parse_real(text.data(), text.data() + text.size(), value);
    if (stop != text.data() + text.size()) return std::nullopt;
    return value;
}

TEST(NumberText, AgreesWithTheStandardLibrary)
{
    std::mt19937_64 random(1);
    const auto digits = [&](std::uint64_t most) {
        std::string text;
        for (auto count = random() % (most + 1); count > 0; --count) {
            text += static_cast<char>('0' + random() % 10);
        }
        return text;
    };
    for (int i = 0; i < 300'000; ++i) {
        const std::uint64_t most = random() % 4 == 0 ? 40 : 9;
        std::string text = random() % 3 == 0 ? "-" : "";
        text += digits(most);
        if (random() % 4 != 0) text.append(1, '.').append(digits(most));
        if (random() % 3 == 0) {
            text += random() % 2 == 0 ? "e" : "E";
            if (random() % 2 == 0) text += random() % 2 == 0 ? "-" : "+";
            text += digits(random() % 4 == 0 ? 5 : 2);
        }
        char* stop = nullptr;
        const double expected = std::strtod(text.c_str(), &stop);
        double value = 0;
        const char* const end = text.data() + text.size();
        const char* const place = parse_real(text.data(), end, value);
        if (stop == text.data()) {
            ASSERT_EQ(place, nullptr) << text;
        } else {
            ASSERT_EQ(place, stop) << text;
            ASSERT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(expected))
                << text;
        }
    }
}

TEST(NumberText, ReadsBackTheShortestAndTheLongestTextOfAnyDouble)
{
    std::mt19937_64 random(2);
    for (int i = 0; i < 100'000; ++i) {
        const auto expected = std::bit_cast<double>(random());
        if (!std::isfinite(expected)) continue;
        char text[64];
        for (const int precision : {17, 25}) {
            const int size = std::snprintf(text, sizeof(text), "%.*g", precision, expected);
            const auto value = real(std::string(text, static_cast<std::size_t>(size)));
            ASSERT_TRUE(value) << text;
            ASSERT_EQ(*value, expected) << text;
        }
    }
}

TEST(NumberText, ReadsSignsAndSpecialValues)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(real("+1.5"), 1.5);
    EXPECT_EQ(real("+.5e+1"), 5);
    EXPECT_TRUE(std::signbit(real("-0").value_or(0)));
    EXPECT_TRUE(std::signbit(real("-0.000").value_or(0)));
    EXPECT_EQ(real("inf"), infinity);
    EXPECT_EQ(real("-Infinity"), -infinity);
    EXPECT_TRUE(std::isnan(real("NaN").value_or(0)));
    EXPECT_TRUE(std::isnan(real("-nan(ind)").value_or(0)));
    EXPECT_EQ(real("1.#INF"), infinity);
    EXPECT_EQ(real("-1.#INF00"), -infinity);
    EXPECT_TRUE(std::isnan(real("-1.#IND").value_or(0)));
    EXPECT_TRUE(std::isnan(real("1.#qnan").value_or(0)));
    EXPECT_EQ(real("1e400"), infinity);
    EXPECT_EQ(real("-1e99999999999"), -infinity);
    EXPECT_EQ(real(std::string(400, '9')), infinity);
    EXPECT_EQ(real("1e-400"), 0);
    EXPECT_EQ(real(std::string("0.").append(400, '0').append("1")), 0);
    EXPECT_EQ(real("0e400"), 0);
    EXPECT_EQ(real("5e-324"), 5e-324);
}

TEST(NumberText, RefusesTextThatIsNotANumber)
{
    for (const char* text : {"", "+", "-", ".", "-.", "e5", "++1", "+-1", "-+1", "--1", "1.5.2",
                             "1e", "1e+", "0x10", "1,5", "1#", "1.#FOO", "one", " 1"}) {
        EXPECT_FALSE(real(text)) << text;
    }
}

TEST(NumberText, ReadsIntegersWithinBounds)
{
    const auto integer = [](const std::string& text) -> std::optional<std::int64_t> {
        std::int64_t value = 0;
        const char* stop = parse_integer(text.data(), text.data() + text.size(), value);
        if (stop != text.data() + text.size()) return std::nullopt;
        return value;
    };
    EXPECT_EQ(integer("0"), 0);
    EXPECT_EQ(integer("-17"), -17);
    EXPECT_EQ(integer("+4294967295"), 4294967295);
    EXPECT_EQ(integer("999999999999999999"), 999999999999999999);
    EXPECT_FALSE(integer("9999999999999999999"));
    EXPECT_FALSE(integer("18446744073709551617"));
    EXPECT_FALSE(integer(""));
    EXPECT_FALSE(integer("-"));
    EXPECT_FALSE(integer("1.0"));
}

} // namespace
} // namespace proxima::detail::number_text_test
