#include "geometry/triangle_box.h"

#include "geometry/exact_predicates.h"
#include "geometry/expansion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace proxima {
namespace {

// Forward error bounds, u = 2^-53. Every computed difference of coordinates is the true one times
// 1 + d, |d| <= u, and its sign is exact, so that of the two planes of the box on an axis the one
// that maximises a term of L is chosen exactly.
//
// L, N: each term is a product of two differences: 3 factors 1 + d; their difference: a fourth.
//     |error| <= ((1 + u)^4 - 1) S with S = |first term| + |second term|, true ones; computed S is
//     at least (1 - u)^4 of that: 4u + O(u^2) <= 5u times the computed S.
// Plane: the sum over axes of the larger (or the smaller) of N_k d_k, d_k the differences to the
// two
//     planes of the box. A product carries 4 + 1 + 1 factors, two more for the sums; the larger of
//     two numbers moves by at most the larger of their errors, whatever the sign of N_k really is.
//     |error| <= ((1 + u)^8 - 1) sum of S_k D_k, D_k the larger |d_k|: 8u + O(u^2) <= 9u times the
//     computed sum.
// Underflow adds at most 2^-1074 to a product, so at most 2^-1072 to L or N, and to the plane
//     2^-1072 |d_k| per axis and 2^-1072: `underflow` (times them) covers it and its own rounding.
// Overflow gives infinities and NaN, which compare as neither certain nor apart, because both
//     tests below ask for value +- error against zero.
constexpr double edge_error = 5 * 0x1p-53;
constexpr double plane_error = 9 * 0x1p-53;
constexpr double underflow = 0x1p-1000;

enum class Answer : std::uint8_t { apart, overlap, unsure };

/// A computed number whose true value is at most `error` away.
struct Bounded {
    double value;
    double error;

    [[nodiscard]] bool surely_negative() const noexcept { return value + error < 0; }
    [[nodiscard]] bool surely_positive() const noexcept { return value - error > 0; }
    [[nodiscard]] bool surely_not_negative() const noexcept { return value - error >= 0; }
    [[nodiscard]] bool surely_not_positive() const noexcept { return value + error <= 0; }
};

// The assumed sign of a projection: N_k >= 0 (positive) or N_k < 0 (negative).
enum class Side : std::uint8_t { positive, negative };

constexpr unsigned bit(int index) noexcept
{
    return 1U << static_cast<unsigned>(index);
}

constexpr int edge_index(int axis, int edge) noexcept
{
    return 3 * axis + edge;
}

bool boxes_apart(const Triangle& triangle, const Box& box) noexcept
{
    const Vec3 lowest = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]);
    const Vec3 highest = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis)
        apart = apart || highest[axis] < box.lower[axis] || lowest[axis] > box.upper[axis];
    return apart;
}

// The filter, and the exact test for what it cannot decide.
class TriangleBoxTest {
public:
    TriangleBoxTest(const Triangle& triangle, const Box& box) noexcept
        : triangle_(triangle), box_(box)
    {}

    /// All stages in doubles.
    [[nodiscard]] Answer filter() noexcept
    {
        if (boxes_apart(triangle_, box_)) return Answer::apart;
        for (const Vec3& vertex : triangle_.vertices)
            if (box_.contains(vertex)) return Answer::overlap;
        prepare();
        if (plane_apart()) return Answer::apart;
        if (axis_apart<0>() || axis_apart<1>() || axis_apart<2>()) return Answer::apart;
        if (!pending()) return Answer::overlap;
        drop_true_zeros();
        return pending() ? Answer::unsure : Answer::overlap;
    }

    /// The exact answer. \pre filter() was unsure
    [[nodiscard]] bool resolve() noexcept
    {
        for (int axis = 0; axis < 3; ++axis) {
            if (!sign_is_known_[index(axis)]) find_sign(axis);
            const Side side = sign_[index(axis)] < 0 ? Side::negative : Side::positive;
            if ((apart_[index(side)] & bit(axis)) != 0) return false;
            for (int edge = 0; edge < 3; ++edge) {
                if ((unsure_[index(side)] & bit(edge_index(axis, edge))) != 0 &&
                    edge_apart(axis, edge, side))
                    return false;
            }
        }
        return !plane_is_unsure_ || !plane_apart_exactly();
    }

private:
    template <class Index>
    static constexpr std::size_t index(Index value) noexcept
    {
        return static_cast<std::size_t>(value);
    }

    void prepare() noexcept
    {
        for (int i = 0; i < 3; ++i) {
            edge_[index(i)] = triangle_[(i + 1) % 3] - triangle_[i];
            to_plane_[index(i)][0] = box_.lower - triangle_[i];
            to_plane_[index(i)][1] = box_.upper - triangle_[i];
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3;
            const int w = (axis + 2) % 3;
            const double first = edge_[0][u] * edge_[1][w];
            const double second = edge_[0][w] * edge_[1][u];
            normal_[axis] = first - second;
            normal_size_[axis] = std::abs(first) + std::abs(second);
            const Bounded component = {normal_[axis], edge_error * normal_size_[axis] + underflow};
            const bool negative = component.surely_negative();
            const bool positive = component.surely_positive();
            sign_[index(axis)] = static_cast<int>(positive) - static_cast<int>(negative);
            sign_is_known_[index(axis)] = negative || positive;
        }
    }

    // The signed distances of the corners of the box farthest along and against the normal.
    [[nodiscard]] bool plane_apart() noexcept
    {
        Bounded maximum = {0, underflow};
        Bounded minimum = {0, underflow};
        double size = 0; // infinite where a value may be
        for (int axis = 0; axis < 3; ++axis) {
            const double lower = to_plane_[0][0][axis];
            const double upper = to_plane_[0][1][axis];
            const double at_lower = normal_[axis] * lower;
            const double at_upper = normal_[axis] * upper;
            maximum.value += at_lower < at_upper ? at_upper : at_lower;
            minimum.value += at_lower < at_upper ? at_lower : at_upper;
            const double farthest = std::max(std::abs(lower), std::abs(upper));
            size += normal_size_[axis] * farthest;
            maximum.error += underflow * farthest;
        }
        maximum.error += plane_error * size;
        minimum.error = maximum.error;
        plane_is_unsure_ = !(maximum.surely_not_negative() && minimum.surely_not_positive());
        return maximum.surely_negative() || minimum.surely_positive();
    }

    // The largest value of L (with Side::negative: of -L) over the box.
    [[nodiscard]] Bounded edge_value(int axis, int edge, Side side) const noexcept
    {
        const int u = (axis + 1) % 3;
        const int w = (axis + 2) % 3;
        const double flip = 1.0 - 2.0 * static_cast<double>(side);
        const double edge_u = flip * edge_[index(edge)][u];
        const double edge_w = flip * edge_[index(edge)][w];
        const double first = edge_u * to_plane_[index(edge)][index(edge_u > 0)][w];
        const double second = edge_w * to_plane_[index(edge)][index(edge_w < 0)][u];
        return {first - second, edge_error * (std::abs(first) + std::abs(second)) + underflow};
    }

    // Whether the box surely lies beyond some edge; notes the edges that are unsure. All three are
    // computed before the only branch, because their results are unpredictable.
    template <int Axis>
    [[nodiscard]] bool side_apart(Side side) noexcept
    {
        unsigned apart = 0;
        unsigned clear = 0;
        for (int edge = 0; edge < 3; ++edge) {
            const Bounded value = edge_value(Axis, edge, side);
            apart |= static_cast<unsigned>(value.surely_negative());
            clear |= static_cast<unsigned>(value.surely_not_negative())
                     << static_cast<unsigned>(edge);
        }
        unsure_[index(side)] |= (~clear & 7U) << static_cast<unsigned>(3 * Axis);
        return apart != 0;
    }

    // The axis is a template constant, so that the loops unroll to straight code.
    template <int Axis>
    [[nodiscard]] bool axis_apart() noexcept
    {
        if (sign_is_known_[Axis]) return side_apart<Axis>(static_cast<Side>(sign_[Axis] < 0));
        for (const Side side : {Side::positive, Side::negative})
            if (side_apart<Axis>(side)) apart_[index(side)] |= bit(Axis);
        return (apart_[0] & apart_[1] & bit(Axis)) != 0;
    }

    [[nodiscard]] bool pending() const noexcept
    {
        return plane_is_unsure_ || (unsure_[0] | unsure_[1] | apart_[0] | apart_[1]) != 0;
    }

    // Where nothing can have underflowed, terms that are zero are truly zero, and results that
    // depend on them alone are certain. Triangles parallel to axes have many such terms.
    void drop_true_zeros() noexcept
    {
        for (int axis = 0; axis < 3; ++axis) {
            const bool fits = detail::fits_expansion(box_.lower[axis]) &&
                              detail::fits_expansion(box_.upper[axis]) &&
                              detail::fits_expansion(triangle_[0][axis]) &&
                              detail::fits_expansion(triangle_[1][axis]) &&
                              detail::fits_expansion(triangle_[2][axis]);
            if (!fits) return;
        }
        for (int axis = 0; axis < 3; ++axis) {
            if (!sign_is_known_[index(axis)] && normal_size_[axis] == 0) {
                sign_[index(axis)] = 0;
                sign_is_known_[index(axis)] = true;
                unsure_[index(Side::negative)] &= ~(7U << static_cast<unsigned>(3 * axis));
                apart_[index(Side::negative)] &= ~bit(axis);
            }
            for (int edge = 0; edge < 3; ++edge) {
                for (const Side side : {Side::positive, Side::negative}) {
                    const unsigned mask = bit(edge_index(axis, edge));
                    if ((unsure_[index(side)] & mask) != 0 &&
                        edge_value(axis, edge, side).error == underflow)
                        unsure_[index(side)] &= ~mask;
                }
            }
        }
        if (plane_is_unsure_) plane_is_unsure_ = !plane_touches_axis_parallel();
    }

    // The signs of the exact value where only one axis has a term that is not zero: a product's.
    [[nodiscard]] bool plane_touches_axis_parallel() const noexcept
    {
        int terms = 0;
        int axis_of_term = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (normal_size_[axis] == 0) continue;
            ++terms;
            axis_of_term = axis;
        }
        if (terms > 1) return false;
        return terms == 0 ||
               (to_plane_[0][0][axis_of_term] <= 0 && to_plane_[0][1][axis_of_term] >= 0);
    }

    [[nodiscard]] Vec2 project(const Vec3& point, int axis) const noexcept
    {
        return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
    }

    void find_sign(int axis) noexcept
    {
        sign_[index(axis)] = orient2d(project(triangle_[0], axis), project(triangle_[1], axis),
                                      project(triangle_[2], axis));
        sign_is_known_[index(axis)] = true;
    }

    [[nodiscard]] bool edge_apart(int axis, int edge, Side side) const noexcept
    {
        const Vec3& from = triangle_[edge];
        const Vec3& to = triangle_[(edge + 1) % 3];
        const int u = (axis + 1) % 3;
        const int w = (axis + 2) % 3;
        const bool maximum = side == Side::positive;
        // The corner of the box where L is largest, or smallest; with equal coordinates, any.
        const Vec2 corner((to[w] > from[w]) == maximum ? box_.lower[u] : box_.upper[u],
                          (to[u] > from[u]) == maximum ? box_.upper[w] : box_.lower[w]);
        const int sign = orient2d(project(from, axis), project(to, axis), corner);
        return maximum ? sign < 0 : sign > 0;
    }

    [[nodiscard]] bool plane_apart_exactly() const noexcept
    {
        // The corners farthest along and against the normal.
        Vec3 highest = box_.lower;
        Vec3 lowest = box_.upper;
        for (int axis = 0; axis < 3; ++axis) {
            if (sign_[index(axis)] <= 0) continue;
            highest[axis] = box_.upper[axis];
            lowest[axis] = box_.lower[axis];
        }
        return orient3d(triangle_[0], triangle_[1], triangle_[2], highest) < 0 ||
               orient3d(triangle_[0], triangle_[1], triangle_[2], lowest) > 0;
    }

    const Triangle& triangle_;
    const Box& box_;
    std::array<Vec3, 3> edge_;
    std::array<std::array<Vec3, 2>, 3> to_plane_; ///< [vertex][lower, upper]
    Vec3 normal_;
    Vec3 normal_size_; ///< sum of the sizes of the two products
    std::array<int, 3> sign_ = {};
    std::array<bool, 3> sign_is_known_ = {};
    std::array<unsigned, 2> unsure_ = {}; ///< [side], bits of edge_index
    std::array<unsigned, 2> apart_ = {};  ///< [side], bits of axes: apart if that is the side
    bool plane_is_unsure_ = false;
};

} // namespace

TriangleBoxVerdict triangle_box_filter(const Triangle& triangle, const Box& box) noexcept
{
    const Answer answer = TriangleBoxTest(triangle, box).filter();
    return {answer != Answer::apart, answer != Answer::unsure};
}

bool triangle_overlaps_box(const Triangle& triangle, const Box& box) noexcept
{
    TriangleBoxTest test(triangle, box);
    const Answer answer = test.filter();
    return answer == Answer::unsure ? test.resolve() : answer == Answer::overlap;
}

} // namespace proxima
