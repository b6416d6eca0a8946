// Which positions were met before: a hash table from exact positions to vertex ids.
//
//     slots   | tag id | tag id |   free   | tag id | ...    open addressing, at most half full;
//                                                           the tag is 32 bits of the hash
//
// The positions themselves lie in the caller's array, by id: tags spare most looks at it.
#pragma once

#include "base/grow_buffer.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace proxima {

/// Equal are positions of equal coordinates (0.0 == -0.0; NaNs of the same bits are equal too).
class VertexTable {
public:
    /// Scratch for so many vertices, in bytes.
    [[nodiscard]] static std::uint64_t bytes_for(std::uint64_t vertex_count) noexcept
    {
        return slot_count(vertex_count) * sizeof(Slot);
    }

    /// Capacity for so many vertices. Throws std::bad_alloc.
    explicit VertexTable(std::size_t vertex_count = 0)
        : slots_(free_slots(slot_count(vertex_count))), mask_(slots_.size() - 1)
    {}

    [[nodiscard]] static std::uint64_t hash(const Vec3& position) noexcept
    {
        // Three rounds of multiply and fold: coordinates that were floats have zeros at the end.
        std::uint64_t bits = 0;
        for (const double value : position) {
            bits = (bits ^ std::bit_cast<std::uint64_t>(value + 0.0)) * 0x9E3779B97F4A7C15U;
            bits ^= bits >> 32U;
        }
        return bits;
    }

    /// To be called some hundred instructions before find_or_add of the same hash.
    void prefetch(std::uint64_t hash) const noexcept { __builtin_prefetch(&slots_[hash & mask_]); }

    /// The id of the equal vertex among kept[0, size()), or size(), which then grows by one: the
    /// caller appends the position to them. \pre hash == hash(position), size() < capacity()
    [[nodiscard]] std::uint32_t find_or_add(std::uint64_t hash, const Vec3& position,
                                            const Vec3* kept) noexcept
    {
        const auto tag = static_cast<std::uint32_t>(hash);
        for (std::uint64_t at = hash & mask_;; at = (at + 1) & mask_) {
            Slot& slot = slots_[at];
            if (slot.id == free_slot) {
                slot = {tag, size_};
                return size_++;
            }
            if (slot.tag == tag && equal(kept[slot.id], position)) return slot.id;
        }
    }

    [[nodiscard]] std::uint32_t size() const noexcept { return size_; }

    /// How many vertices fit.
    [[nodiscard]] std::size_t capacity() const noexcept
    {
        return slots_.size() < most_slots ? slots_.size() / 2 : most_slots - 2;
    }

    /// Bytes that it holds.
    [[nodiscard]] std::uint64_t bytes() const noexcept { return slots_.size() * sizeof(Slot); }

    /// Grows to hold so many. \pre vertex_count >= size(). Throws std::bad_alloc.
    void reserve(std::size_t vertex_count)
    {
        if (vertex_count <= capacity()) return;
        GrowBuffer<Slot> larger = free_slots(slot_count(vertex_count));
        const std::uint64_t mask = larger.size() - 1;
        for (const Slot& slot : slots_) {
            if (slot.id == free_slot) continue;
            std::uint64_t at = slot.tag & mask;
            while (larger[at].id != free_slot) at = (at + 1) & mask;
            larger[at] = slot;
        }
        slots_ = std::move(larger);
        mask_ = mask;
    }

private:
    static constexpr std::uint32_t free_slot = std::numeric_limits<std::uint32_t>::max();

    struct Slot {
        std::uint32_t tag = 0;
        std::uint32_t id = free_slot;
    };

    /// All slots that a tag can tell.
    static constexpr std::uint64_t most_slots = std::uint64_t{1} << 32U;

    /// A power of two.
    [[nodiscard]] static std::uint64_t slot_count(std::uint64_t vertex_count) noexcept
    {
        constexpr std::uint64_t least = 64;
        return std::min(std::bit_ceil(2 * vertex_count + least), most_slots);
    }

    [[nodiscard]] static GrowBuffer<Slot> free_slots(std::uint64_t count)
    {
        GrowBuffer<Slot> slots;
        slots.resize(count);
        std::ranges::fill(slots, Slot{});
        return slots;
    }

    [[nodiscard]] static bool equal(const Vec3& a, const Vec3& b) noexcept
    {
        bool all = true;
        for (int axis = 0; axis < 3; ++axis) {
            const bool same_bits =
                std::bit_cast<std::uint64_t>(a[axis]) == std::bit_cast<std::uint64_t>(b[axis]);
            all = all && (same_bits || a[axis] == b[axis]);
        }
        return all;
    }

    GrowBuffer<Slot> slots_; ///< on huge pages where it is large
    std::uint64_t mask_;
    std::uint32_t size_ = 0;
};

} // namespace proxima
