// Numbers of packets as bytes, the lowest byte first, behind a header that all packets have:
//
//     0  magic, 4 letters    4  version, u16    6  size of the packet in bytes, u16
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

enum class PacketFault : std::uint8_t { none, wrong_size, wrong_magic, wrong_version };

using PacketMagic = std::array<char, 4>;
inline constexpr std::size_t packet_header_size = 8;

/// Writes numbers one after another. \pre the bytes suffice
class PacketWriter {
public:
    explicit PacketWriter(std::span<std::byte> bytes) noexcept : bytes_(bytes) {}

    template <class Number>
    void put(Number number) noexcept
    {
        for (std::size_t i = 0; i < sizeof(Number); ++i)
            bytes_[at_++] = static_cast<std::byte>(number >> (8 * i) & 255U);
    }
    void put(double number) noexcept { put(std::bit_cast<std::uint64_t>(number)); }
    void put(const Vec3& v) noexcept
    {
        for (const double x : v) put(x);
    }
    void header(const PacketMagic& magic, std::uint16_t version) noexcept
    {
        for (const char letter : magic) put(static_cast<std::uint8_t>(letter));
        put(version);
        put(static_cast<std::uint16_t>(bytes_.size()));
    }

private:
    std::span<std::byte> bytes_;
    std::size_t at_ = 0;
};

/// Reads numbers that a PacketWriter wrote. \pre the bytes suffice
class PacketReader {
public:
    explicit PacketReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

    template <class Number>
    void get(Number& number) noexcept
    {
        number = 0;
        for (std::size_t i = 0; i < sizeof(Number); ++i)
            number |= static_cast<Number>(static_cast<Number>(bytes_[at_++]) << (8 * i));
    }
    void get(double& number) noexcept
    {
        std::uint64_t bits = 0;
        get(bits);
        number = std::bit_cast<double>(bits);
    }
    void get(Vec3& v) noexcept
    {
        for (double& x : v) get(x);
    }
    /// Reads the header of a packet that is all the bytes. Any number of bytes.
    [[nodiscard]] PacketFault header(const PacketMagic& magic, std::uint16_t version) noexcept
    {
        if (bytes_.size() < packet_header_size) return PacketFault::wrong_size;
        bool same = true;
        for (const char letter : magic) {
            std::uint8_t byte = 0;
            get(byte);
            same = same && byte == static_cast<std::uint8_t>(letter);
        }
        if (!same) return PacketFault::wrong_magic;
        std::uint16_t reported_version = 0;
        std::uint16_t reported_size = 0;
        get(reported_version);
        get(reported_size);
        if (reported_version != version) return PacketFault::wrong_version;
        return reported_size == bytes_.size() ? PacketFault::none : PacketFault::wrong_size;
    }

private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

} // namespace proxima
