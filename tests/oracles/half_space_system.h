// Whether half-spaces have a point in common, by eliminating one unknown after the other [fourier].
//
//     row of K + 1 numbers: r[0] x_0 + ... + r[K-1] x_(K-1) + r[K] >= 0
//
// Slow, without a division, exact where the numbers are: __int128 for small whole ones, else a type
// of any size. It knows nothing of corners, lines or signs of determinants.
#pragma once

#include "proxima/geometry.h"
#include "proxima/view_volume.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace proxima::testing {

template <class Number, std::size_t Unknowns>
using HalfSpaceRow = std::array<Number, Unknowns + 1>;

template <class Number, std::size_t Unknowns>
bool have_common_point(const std::vector<HalfSpaceRow<Number, Unknowns>>& rows)
{
    const Number zero(0);
    if constexpr (Unknowns == 0) {
        for (const auto& row : rows)
            if (row[0] < zero) return false;
        return true;
    } else {
        std::vector<HalfSpaceRow<Number, Unknowns - 1>> fewer;
        const auto add = [&](const auto& row, const Number& factor, const auto& other,
                             const Number& other_factor) {
            HalfSpaceRow<Number, Unknowns - 1> sum;
            for (std::size_t i = 0; i < Unknowns; ++i)
                sum[i] = row[i + 1] * factor + other[i + 1] * other_factor;
            fewer.push_back(sum);
        };
        for (const auto& row : rows) {
            if (row[0] == zero) add(row, Number(1), row, zero);
            if (!(row[0] > zero)) continue;
            for (const auto& other : rows)
                if (other[0] < zero) add(row, Number(-other[0]), other, row[0]);
        }
        return have_common_point<Number, Unknowns - 1>(fewer);
    }
}

template <class Number>
HalfSpaceRow<Number, 3> row_of(const ViewPlane& plane)
{
    return {Number(plane.normal.x()), Number(plane.normal.y()), Number(plane.normal.z()),
            Number(plane.offset)};
}

template <class Number>
std::vector<HalfSpaceRow<Number, 3>> rows_of(std::span<const ViewPlane> planes)
{
    std::vector<HalfSpaceRow<Number, 3>> rows;
    for (const ViewPlane& plane : planes) rows.push_back(row_of<Number>(plane));
    return rows;
}

/// With the triangle's points as v0 + s (v1 - v0) + t (v2 - v0).
template <class Number>
bool oracle_meets(std::span<const ViewPlane> planes, const Triangle& triangle)
{
    std::vector<HalfSpaceRow<Number, 2>> rows = {{Number(1), Number(0), Number(0)},
                                                 {Number(0), Number(1), Number(0)},
                                                 {Number(-1), Number(-1), Number(1)}};
    for (const ViewPlane& plane : planes) {
        const auto row = row_of<Number>(plane);
        std::array<Number, 3> values;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& v = triangle.vertices[i];
            values[i] =
                row[0] * Number(v.x()) + row[1] * Number(v.y()) + row[2] * Number(v.z()) + row[3];
        }
        rows.push_back({values[1] - values[0], values[2] - values[0], values[0]});
    }
    return have_common_point<Number, 2>(rows);
}

template <class Number>
bool oracle_meets(std::span<const ViewPlane> planes, const Box& box)
{
    auto rows = rows_of<Number>(planes);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        HalfSpaceRow<Number, 3> lower = {Number(0), Number(0), Number(0), Number(0)};
        HalfSpaceRow<Number, 3> upper = lower;
        lower[axis] = Number(1);
        lower[3] = Number(-box.lower[static_cast<Eigen::Index>(axis)]);
        upper[axis] = Number(-1);
        upper[3] = Number(box.upper[static_cast<Eigen::Index>(axis)]);
        rows.push_back(lower);
        rows.push_back(upper);
    }
    return have_common_point<Number, 3>(rows);
}

/// Whether the planes contradict each other.
template <class Number>
bool oracle_is_empty(std::span<const ViewPlane> planes)
{
    return !have_common_point<Number, 3>(rows_of<Number>(planes));
}

} // namespace proxima::testing
