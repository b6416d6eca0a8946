// Button events from the servo thread to the user's: a ring without lock or waiting.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace proxima {

struct ButtonEvent {
    std::uint64_t tick = 0; ///< in which the device said so
    int button = 0;         ///< which, from 0
    bool pressed = false;   ///< or released

    friend bool operator==(const ButtonEvent&, const ButtonEvent&) = default;
};

/// One thread pushes, one other thread pops. Wait-free, noexcept, no allocation. Where nobody pops,
/// the newest events are dropped and counted: what was pushed first is read first.
class ButtonQueue {
public:
    static constexpr std::size_t capacity = 256;

    /// False where the ring is full. The pushing thread's.
    bool push(const ButtonEvent& event) noexcept
    {
        const std::size_t end = end_.load(std::memory_order_relaxed);
        if (end - begin_.load(std::memory_order_acquire) == capacity) {
            dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
            return false;
        }
        events_[end % capacity] = event;
        end_.store(end + 1, std::memory_order_release);
        return true;
    }

    /// False where there is none. The popping thread's.
    bool pop(ButtonEvent& event) noexcept
    {
        const std::size_t begin = begin_.load(std::memory_order_relaxed);
        if (begin == end_.load(std::memory_order_acquire)) return false;
        event = events_[begin % capacity];
        begin_.store(begin + 1, std::memory_order_release);
        return true;
    }

    /// Events so far that found no room.
    [[nodiscard]] std::uint64_t dropped() const noexcept
    {
        return dropped_.load(std::memory_order_relaxed);
    }

private:
    std::array<ButtonEvent, capacity> events_{};
    alignas(64) std::atomic<std::size_t> end_{0};
    alignas(64) std::atomic<std::size_t> begin_{0};
    std::atomic<std::uint64_t> dropped_{0};
};

} // namespace proxima
