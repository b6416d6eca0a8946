// Files that are damaged in every place: each has to be refused.
#pragma once

#include "base/binary_file.h"

#include <cstddef>
#include <gtest/gtest.h>
#include <string>

namespace proxima::testing {

/// `load(bytes)` and `load(bytes, Verification::structure)` return Results.
template <class Load>
void refuses_every_truncation_and_extension(const std::string& bytes, const Load& load)
{
    ASSERT_TRUE(load(bytes, Verification::full));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        ASSERT_FALSE(load(bytes.substr(0, size), Verification::full)) << size;
        ASSERT_FALSE(load(bytes.substr(0, size), Verification::structure)) << size;
    }
    EXPECT_FALSE(load(bytes + '\0', Verification::full));
}

template <class Load>
void refuses_every_flipped_bit(const std::string& bytes, const Load& load)
{
    ASSERT_TRUE(load(bytes, Verification::full));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            std::string damaged = bytes;
            damaged[i] = static_cast<char>(static_cast<unsigned char>(damaged[i]) ^ 1U << bit);
            const auto loaded = load(damaged, Verification::full);
            ASSERT_FALSE(loaded) << "byte " << i << " bit " << bit;
            ASSERT_FALSE(loaded.error().message.empty());
        }
    }
}

} // namespace proxima::testing
