// Hands the latest value from one thread to another, wait-free, through three slots.
//
//     writer   fills its slot, swaps it with the middle one         never waits for the reader
//     reader   takes the middle one in exchange for its own         never waits for the writer
//
// The reader always sees a whole value, the newest one when it updated; values in between are lost.
// The bits of `middle_` are the slot's number and whether it is new.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// One writer thread, one reader thread. All but the constructors are noexcept, wait-free, and
/// allocate nothing.
template <class T>
class Snapshot {
public:
    Snapshot() = default;
    /// All slots begin as copies.
    explicit Snapshot(const T& value) : slots_{value, value, value} {}

    /// The writer's slot, with any older value in it.
    [[nodiscard]] T& writing() noexcept { return slots_[write_]; }

    /// Hands the writer's slot over.
    void publish() noexcept
    {
        write_ =
            middle_.exchange(static_cast<std::uint8_t>(write_ | news), std::memory_order_acq_rel) &
            number;
    }

    /// The reader takes the newest value. False where nothing was published since the last update.
    bool update() noexcept
    {
        if ((middle_.load(std::memory_order_relaxed) & news) == 0) return false;
        read_ = middle_.exchange(read_, std::memory_order_acq_rel) & number;
        return true;
    }

    /// The reader's slot, which does not change until the next update.
    [[nodiscard]] const T& reading() const noexcept { return slots_[read_]; }
    [[nodiscard]] T& reading() noexcept { return slots_[read_]; }

private:
    static constexpr std::uint8_t number = 3;
    static constexpr std::uint8_t news = 4;
    static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

    alignas(64) std::atomic<std::uint8_t> middle_{1};
    alignas(64) std::array<T, 3> slots_{};
    alignas(64) std::uint8_t write_ = 0; ///< of the writer alone
    alignas(64) std::uint8_t read_ = 2;  ///< of the reader alone
};

} // namespace proxima
