// A growing array that never initialises: for output whose size is known only when it is written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace proxima {

namespace detail {

/// Uninitialised memory, grown or shrunk to `bytes` with its content kept as far as it fits; from
/// nothing where `memory` is null. Large blocks are pages of their own, huge ones where the system
/// offers them, and move without copying. Throws std::bad_alloc.
[[nodiscard]] void* resize_memory(void* memory, std::size_t old_bytes, std::size_t bytes);

/// Gives back what resize_memory returned for `bytes`.
void free_memory(void* memory, std::size_t bytes) noexcept;

} // namespace detail

/// While one lives, large blocks that buffers of this thread give back serve the thread's next ones:
/// the system need not clear them again. What is left goes back at the end. For builders that hold
/// one large array after the other; one at a time on a thread.
class PageReserve {
public:
    PageReserve() noexcept;
    ~PageReserve();
    PageReserve(const PageReserve&) = delete;
    PageReserve& operator=(const PageReserve&) = delete;
};

/// Like a vector of plain values, but new elements are left as they come, and growing moves pages
/// instead of copying where the system can. Throws std::bad_alloc when memory runs out.
template <class T>
class GrowBuffer {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

public:
    GrowBuffer() = default;
    GrowBuffer(GrowBuffer&& other) noexcept
        : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)),
          capacity_(std::exchange(other.capacity_, 0))
    {}
    GrowBuffer& operator=(GrowBuffer&& other) noexcept
    {
        data_ = std::move(other.data_);
        size_ = std::exchange(other.size_, 0);
        capacity_ = std::exchange(other.capacity_, 0);
        return *this;
    }
    GrowBuffer(const GrowBuffer&) = delete;
    GrowBuffer& operator=(const GrowBuffer&) = delete;
    ~GrowBuffer() = default;

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] T* data() noexcept { return data_.get(); }
    [[nodiscard]] const T* data() const noexcept { return data_.get(); }
    [[nodiscard]] T* begin() noexcept { return data(); }
    [[nodiscard]] T* end() noexcept { return data() + size_; }
    [[nodiscard]] const T* begin() const noexcept { return data(); }
    [[nodiscard]] const T* end() const noexcept { return data() + size_; }
    [[nodiscard]] T& operator[](std::size_t index) noexcept { return data_.get()[index]; }
    [[nodiscard]] const T& operator[](std::size_t index) const noexcept
    {
        return data_.get()[index];
    }
    [[nodiscard]] std::span<const T> span() const noexcept { return {data(), size_}; }
    [[nodiscard]] std::span<T> span() noexcept { return {data(), size_}; }

    /// Capacity for `count` elements, growing by half at least.
    void reserve(std::size_t count)
    {
        if (count > capacity_) reallocate(std::max(count, capacity_ + capacity_ / 2));
    }

    /// New elements hold whatever the memory held.
    void resize(std::size_t count)
    {
        reserve(count);
        size_ = count;
    }

    void push_back(const T& value)
    {
        const T copy = value;
        reserve(size_ + 1);
        data_.get()[size_++] = copy;
    }

    void clear() noexcept { size_ = 0; }

    /// Gives unused capacity back.
    void shrink_to_fit()
    {
        if (capacity_ > size_) reallocate(size_);
    }

private:
    struct Free {
        std::size_t bytes = 0;
        void operator()(T* data) const noexcept { detail::free_memory(data, bytes); }
    };

    void reallocate(std::size_t capacity)
    {
        const std::size_t bytes = std::max<std::size_t>(capacity, 1) * sizeof(T);
        void* const moved = detail::resize_memory(data_.get(), data_.get_deleter().bytes, bytes);
        (void)data_.release();
        data_ = std::unique_ptr<T, Free>(static_cast<T*>(moved), Free{bytes});
        capacity_ = capacity;
    }

    std::unique_ptr<T, Free> data_;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

/// Makes room in `memory` for so many bytes at a multiple of the alignment, and returns where they
/// begin. Pages are larger than any alignment, the heap's blocks are not.
[[nodiscard]] inline std::byte* aligned_bytes(GrowBuffer<std::byte>& memory, std::size_t count,
                                              std::size_t alignment)
{
    memory.resize(count + alignment);
    void* first = memory.data();
    std::size_t space = memory.size();
    return static_cast<std::byte*>(std::align(alignment, count, first, space));
}

} // namespace proxima
