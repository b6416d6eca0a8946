// Hands the latest value from one thread to another, wait-free, through three slots or four.
//
//     writer   fills its slot, swaps it with the middle one         never waits for the reader
//     reader   takes the middle one in exchange for its oldest      never waits for the writer
//
// The reader always sees a whole value, the newest one when it updated; values in between are lost.
// A reader of two values has the one before as well. The bits of `middle_` are the slot's number and
// whether it is new.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// One writer thread, one reader thread, which keeps one value or two. All but the constructors are
/// noexcept, wait-free, and allocate nothing.
template <class T, std::size_t Kept = 1>
requires(Kept == 1 || Kept == 2) class Snapshot {
public:
    Snapshot() { number_slots(); }
    /// All slots begin as copies.
    explicit Snapshot(const T& value)
    {
        slots_.fill(value);
        number_slots();
    }

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
        const std::uint8_t oldest = read_.back();
        for (std::size_t i = Kept - 1; i > 0; --i) read_[i] = read_[i - 1];
        read_.front() = middle_.exchange(oldest, std::memory_order_acq_rel) & number;
        return true;
    }

    /// The reader's slot, which does not change until the next update.
    [[nodiscard]] const T& reading() const noexcept { return slots_[read_.front()]; }
    [[nodiscard]] T& reading() noexcept { return slots_[read_.front()]; }

    /// What reading() was before the last update; it does not change until the next one.
    [[nodiscard]] const T& before() const noexcept requires(Kept == 2)
    {
        return slots_[read_.back()];
    }

private:
    static constexpr std::uint8_t number = 3;
    static constexpr std::uint8_t news = 4;
    static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

    alignas(64) std::atomic<std::uint8_t> middle_{1};
    void number_slots() noexcept
    {
        for (std::size_t i = 0; i < Kept; ++i) read_[i] = static_cast<std::uint8_t>(2 + i);
    }

    alignas(64) std::array<T, Kept + 2> slots_{};
    alignas(64) std::uint8_t write_ = 0;                ///< of the writer alone
    alignas(64) std::array<std::uint8_t, Kept> read_{}; ///< of the reader alone, newest first
};

} // namespace proxima
