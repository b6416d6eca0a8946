// Events from the servo thread to the user's, such as those of buttons: a ring without lock or waiting.
#pragma once

#include "proxima/device.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace proxima {

/// One thread pushes, one other thread pops. Wait-free, noexcept, no allocation. Events are popped
/// in the order in which they were pushed. A full queue drops and counts new ones.
template <class Event, std::size_t Capacity>
class EventQueue {
public:
    static constexpr std::size_t capacity = Capacity;

    /// False where the ring is full. Called by the pushing thread.
    bool push(const Event& event) noexcept
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

    /// The next event; nothing where there is none. Called by the popping thread.
    [[nodiscard]] std::optional<Event> pop() noexcept
    {
        const std::size_t begin = begin_.load(std::memory_order_relaxed);
        if (begin == end_.load(std::memory_order_acquire)) return std::nullopt;
        const Event event = events_[begin % capacity];
        begin_.store(begin + 1, std::memory_order_release);
        return event;
    }

    /// Events that were dropped so far.
    [[nodiscard]] std::uint64_t dropped() const noexcept
    {
        return dropped_.load(std::memory_order_relaxed);
    }

private:
    std::array<Event, capacity> events_{};
    alignas(64) std::atomic<std::size_t> end_{0};
    alignas(64) std::atomic<std::size_t> begin_{0};
    std::atomic<std::uint64_t> dropped_{0};
};

using ButtonQueue = EventQueue<ButtonEvent, 256>;

} // namespace proxima
