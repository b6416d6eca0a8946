// Vectors over any scalar and of any dimension, so that the thesis's methods run on doubles and on
// counting numbers, in the plane and in space.
//
// dot() and cross() fix the order of operations, which the rounding bounds rely on, and let a
// counting scalar know that a product of vectors took place (operation_counts.h).
#pragma once

#include "proxima/geometry.h"

namespace proxima {

template <class Scalar, int Dim>
using Vector = Eigen::Matrix<Scalar, Dim, 1>;

template <class Scalar>
using Vector3 = Vector<Scalar, 3>;

/// The plain value of a scalar, for bookkeeping that is no part of a method.
[[nodiscard]] inline double to_double(double value) noexcept
{
    return value;
}

/// A vector of a method's scalar from plain coordinates.
template <class Scalar>
[[nodiscard]] Vector3<Scalar> to_scalar(const Vec3& vector) noexcept
{
    return {Scalar(vector.x()), Scalar(vector.y()), Scalar(vector.z())};
}

/// a . b, summed from the first component on: Dim products, Dim - 1 sums.
template <class Scalar, int Dim>
[[nodiscard]] Scalar dot(const Vector<Scalar, Dim>& a, const Vector<Scalar, Dim>& b) noexcept
{
    if constexpr (requires { Scalar::count_dot_product(); }) Scalar::count_dot_product();
    Scalar sum = a[0] * b[0];
    for (int axis = 1; axis < Dim; ++axis) sum = sum + a[axis] * b[axis];
    return sum;
}

/// a x b: six products, three differences.
template <class Scalar>
[[nodiscard]] Vector3<Scalar> cross(const Vector3<Scalar>& a, const Vector3<Scalar>& b) noexcept
{
    if constexpr (requires { Scalar::count_cross_product(); }) Scalar::count_cross_product();
    return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
            a.x() * b.y() - a.y() * b.x()};
}

/// |a x b| at most, component by component, whatever cancels in it.
[[nodiscard]] inline Vec3 cross_magnitude(const Vec3& a, const Vec3& b) noexcept
{
    const Vec3 p = a.cwiseAbs();
    const Vec3 q = b.cwiseAbs();
    return {p.y() * q.z() + p.z() * q.y(), p.z() * q.x() + p.x() * q.z(),
            p.x() * q.y() + p.y() * q.x()};
}

} // namespace proxima
