#include "base/text.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <sstream>

namespace proxima::text_test {
namespace {

TEST(Text, JoinsStringsOfAllKindsAndValues)
{
    const std::string owned = "owned";
    const char* const pointer = "pointer";
    EXPECT_EQ(
        concat("array", ' ', owned, ' ', pointer, ' ', std::string_view("view"), ' ', true, false),
        "array owned pointer view truefalse");
    EXPECT_EQ(concat(""), "");
    EXPECT_EQ(to_text(std::string()), "");
}

template <class Integer>
void expect_as_a_stream_has_it()
{
    using Limits = std::numeric_limits<Integer>;
    for (const Integer value : {Limits::min(), Limits::max(), Integer{0}, Integer{7}}) {
        std::ostringstream stream;
        stream << +value;
        EXPECT_EQ(to_text(value), stream.str());
    }
}

TEST(Text, WritesIntegersOfAllWidths)
{
    expect_as_a_stream_has_it<std::int8_t>();
    expect_as_a_stream_has_it<std::uint8_t>();
    expect_as_a_stream_has_it<short>();
    expect_as_a_stream_has_it<unsigned short>();
    expect_as_a_stream_has_it<int>();
    expect_as_a_stream_has_it<unsigned>();
    expect_as_a_stream_has_it<long>();
    expect_as_a_stream_has_it<unsigned long>();
    expect_as_a_stream_has_it<long long>();
    expect_as_a_stream_has_it<unsigned long long>();
}

TEST(Text, WritesNumbersThatReadBackToTheSameBits)
{
    const auto seed = std::random_device{}();
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    for (int i = 0; i < 20'000; ++i) {
        const auto real = std::bit_cast<double>(random());
        if (std::isfinite(real)) {
            EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(to_text(real).c_str(), nullptr)),
                      std::bit_cast<std::uint64_t>(real));
        }
        const auto single = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
        if (std::isfinite(single)) {
            EXPECT_EQ(std::bit_cast<std::uint32_t>(std::strtof(to_text(single).c_str(), nullptr)),
                      std::bit_cast<std::uint32_t>(single));
        }
    }
}

TEST(Text, WritesNumbersShort)
{
    EXPECT_EQ(concat(0.1, ' ', 0.1F, ' ', 12.0, ' ', -0.0, ' ', 1e300), "0.1 0.1 12 -0 1e+300");
    EXPECT_EQ(to_text(-std::numeric_limits<double>::max()), "-1.7976931348623157e+308");
    EXPECT_EQ(to_text(-std::numeric_limits<double>::denorm_min()), "-5e-324");
    EXPECT_EQ(to_text(std::numeric_limits<double>::infinity()), "inf");
}

} // namespace
} // namespace proxima::text_test
