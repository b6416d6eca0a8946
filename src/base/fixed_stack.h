// A stack whose capacity is known when the code is written, so that traversals never allocate.
#pragma once

#include "base/check.h"

#include <array>
#include <cstddef>

namespace proxima {

/// Last in, first out, at most Capacity elements, no allocation. T is default constructible.
template <class T, std::size_t Capacity>
class FixedStack {
public:
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] static constexpr std::size_t capacity() noexcept { return Capacity; }

    /// \pre size() < capacity()
    void push(const T& value) noexcept
    {
        PROXIMA_CHECK_LT(size_, Capacity);
        items_[size_++] = value;
    }

    /// Removes and returns the element pushed last. \pre !empty()
    T pop() noexcept
    {
        PROXIMA_CHECK_GT(size_, 0U);
        return items_[--size_];
    }

    /// The element pushed last. \pre !empty()
    [[nodiscard]] const T& top() const noexcept
    {
        PROXIMA_CHECK_GT(size_, 0U);
        return items_[size_ - 1];
    }

private:
    std::array<T, Capacity> items_;
    std::size_t size_ = 0;
};

} // namespace proxima
