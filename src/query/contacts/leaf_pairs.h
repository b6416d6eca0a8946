// Pairs of triangles of two leaves that may come together, one of a mesh that moves.
#pragma once

#include "index/index_parts.h"
#include "query/contacts/motion_bounds.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// The triangles of two leaves, and of their pairs those that are not sure to stay apart.
class LeafPairs {
public:
    LeafPairs(const MotionBounds& bounds, const IndexLeaf& a, const IndexLeaf& b,
              const MovedFrame& frame)
        : bounds_(bounds), a_(a), b_(b), frame_(frame)
    {
        for (std::uint32_t i = 0; i < a.count; ++i)
            of_a_[i] = bounds.triangle_of_a(a.first_row + i);
        for (std::uint32_t k = 0; k < b.count; ++k)
            of_b_[k] = bounds.triangle_of_b(b.first_row + k, frame);
        const std::uint64_t row = (1U << b.count) - 1;
        for (std::uint32_t i = 0; i < a.count; ++i) left_ |= row << 8 * i;
    }

    [[nodiscard]] bool empty() const { return left_ == 0; }

    /// Takes away pairs that are apart along a direction for as long. Returns whether there were any.
    bool filter(const Vec3& direction, double within)
    {
        if (direction.isZero(0) || left_ == 0) return false;
        const std::uint64_t before = left_;
        const Along along = bounds_.along(direction);
        std::array<double, 8> least{};
        for (std::size_t k = 0; k < b_.count; ++k)
            least[k] = bounds_.least_within(along, of_b_[k], frame_, within);
        for (std::size_t i = 0; i < a_.count; ++i) {
            double top = -MotionBounds::never;
            for (const Vec3& p : of_a_[i].vertices) top = std::max(top, direction.dot(p));
            for (std::size_t k = 0; k < b_.count; ++k)
                if (least[k] > top) left_ &= ~(std::uint64_t{1} << (8 * i + k));
        }
        return left_ != before;
    }

    struct Rows {
        std::uint32_t a;
        std::uint32_t b;
    };
    /// \pre not empty
    Rows pop()
    {
        const auto at = static_cast<std::uint32_t>(std::countr_zero(left_));
        left_ &= left_ - 1;
        return {a_.first_row + at / 8, b_.first_row + at % 8};
    }

private:
    const MotionBounds& bounds_;
    const IndexLeaf& a_;
    const IndexLeaf& b_;
    const MovedFrame& frame_;
    std::array<Triangle, 8> of_a_;
    std::array<Triangle, 8> of_b_;
    std::uint64_t left_ = 0; ///< bit 8 i + k
};

} // namespace proxima
