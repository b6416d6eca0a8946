#include "base/hash.h"

#include <xxhash.h>

namespace proxima {

std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed) noexcept
{
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

} // namespace proxima
