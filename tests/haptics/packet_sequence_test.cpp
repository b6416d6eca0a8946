#include "haptics/device/packet_sequence.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace proxima::packet_sequence_test {
namespace {

using enum PacketVerdict;

constexpr std::int64_t millisecond = 1'000'000;
constexpr UdpAddress ours{.port = 7000};
constexpr UdpAddress theirs{.port = 7001};

/// Another session of the same program may begin after 250 ms, another program after a second.
class PacketSequenceTest : public ::testing::Test {
protected:
    PacketVerdict judge(std::uint64_t session, std::uint64_t sequence, const UdpAddress& from,
                        std::int64_t milliseconds)
    {
        return packets.judge(session, sequence, from, milliseconds * millisecond);
    }
    std::uint64_t accept(std::uint64_t sequence, std::int64_t milliseconds)
    {
        return packets.accept(sequence, milliseconds * millisecond);
    }
    /// Session 1 of ours was heard once, with number 100, at `milliseconds`.
    void begin(std::int64_t milliseconds = 0)
    {
        ASSERT_EQ(judge(1, 100, ours, milliseconds), well);
        ASSERT_EQ(accept(100, milliseconds), 0U);
    }

    PacketSequence packets{0.25, 1};
};

TEST_F(PacketSequenceTest, TakesTheFirstProgramWithAnyNumber)
{
    EXPECT_FALSE(packets.serves());
    EXPECT_EQ(judge(1, 1U << 30U, ours, 0), well);
    EXPECT_TRUE(packets.serves());
    EXPECT_TRUE(packets.is_first());
    EXPECT_EQ(packets.session(), 1U);
    EXPECT_EQ(packets.peer(), ours);
    EXPECT_EQ(packets.sessions(), 1U);
    // Nothing was accepted: the next packet is a first one again, whatever its number.
    EXPECT_EQ(judge(1, 5, ours, 1), well);
    EXPECT_EQ(packets.sessions(), 1U);
    EXPECT_EQ(accept(5, 1), 0U);
    EXPECT_FALSE(packets.is_first());
    EXPECT_EQ(packets.sequence(), 5U);
    EXPECT_EQ(packets.last_heard(), millisecond);
}

TEST_F(PacketSequenceTest, AnotherProgramBeginsAtOnceWhenTheServedOneLeaves)
{
    begin();
    EXPECT_EQ(judge(2, 1, theirs, 1), foreign);
    packets.leave();
    EXPECT_EQ(judge(1, 99, ours, 1), reordered); // a late packet of the one that left
    EXPECT_EQ(judge(2, 1, theirs, 1), well);
    EXPECT_EQ(accept(1, 1), 0U);
    EXPECT_EQ(judge(1, 101, ours, 2), foreign);
    // The one that left goes on: it has not left.
    packets.leave();
    EXPECT_EQ(judge(2, 2, theirs, 2), well);
    EXPECT_EQ(accept(2, 2), 0U);
    EXPECT_EQ(judge(1, 101, ours, 3), foreign);
}

TEST_F(PacketSequenceTest, TellsHowANumberFollowsTheLastOne)
{
    begin();
    EXPECT_EQ(judge(1, 100, ours, 1), duplicated);
    EXPECT_EQ(judge(1, 99, ours, 1), reordered);
    EXPECT_EQ(judge(1, 0, ours, 1), reordered);
    EXPECT_EQ(judge(1, 101, ours, 1), well);
    EXPECT_EQ(judge(1, 100 + 65536, ours, 1), well);
    EXPECT_EQ(judge(1, 100 + 65537, ours, 1), leapt);
    EXPECT_EQ(accept(101, 1), 0U);
    EXPECT_EQ(accept(105, 2), 3U); // 102, 103 and 104 never came
}

TEST_F(PacketSequenceTest, KeepsASessionThatFollowsHoweverLongItWasSilent)
{
    begin();
    EXPECT_EQ(judge(1, 101, ours, 3'600'000), well);
    EXPECT_EQ(judge(1, 100 + 65536, ours, 3'600'000), well);
    EXPECT_EQ(packets.sessions(), 1U);
    EXPECT_FALSE(packets.is_first());
}

TEST_F(PacketSequenceTest, BeginsTheSameSessionAnewAfterTheLongSilence)
{
    for (const std::uint64_t number : {100U, 99U, 100U + 65537U}) {
        packets = PacketSequence(0.25, 1);
        begin();
        EXPECT_NE(judge(1, number, ours, 999), well) << number;
        EXPECT_EQ(packets.sessions(), 1U) << number;
        EXPECT_EQ(judge(1, number, ours, 1000), well) << number;
        EXPECT_TRUE(packets.is_first()) << number;
        EXPECT_EQ(packets.sequence(), 0U) << number;
        EXPECT_EQ(packets.sessions(), 2U) << number;
    }
}

TEST_F(PacketSequenceTest, HearsAnotherSessionOfTheSameAddressAfterAShortSilence)
{
    begin(500);
    EXPECT_EQ(judge(2, 101, ours, 749), foreign);
    EXPECT_EQ(packets.session(), 1U);
    EXPECT_EQ(judge(2, 101, ours, 750), well);
    EXPECT_EQ(packets.session(), 2U);
    EXPECT_EQ(packets.sessions(), 2U);
    // Now the first session is the stranger, though a number of its would follow.
    EXPECT_EQ(accept(101, 750), 0U);
    EXPECT_EQ(judge(1, 102, ours, 800), foreign);
}

TEST_F(PacketSequenceTest, HearsAnotherAddressAfterTheLongSilenceAlone)
{
    begin(500);
    // Another address sends the number that follows, of the same session.
    EXPECT_EQ(judge(1, 101, theirs, 500), foreign);
    EXPECT_EQ(judge(1, 101, theirs, 1499), foreign);
    EXPECT_EQ(judge(1, 101, ours, 1499), well);
    EXPECT_EQ(judge(1, 101, theirs, 1500), well);
    EXPECT_EQ(packets.peer(), theirs);
    EXPECT_TRUE(packets.is_first());
    EXPECT_EQ(accept(101, 1500), 0U);
    EXPECT_EQ(judge(1, 102, ours, 1501), foreign);
}

} // namespace
} // namespace proxima::packet_sequence_test
