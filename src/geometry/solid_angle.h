// Solid angles of triangles, summed without an arc tangent each.
//
// A triangle seen from a point spans the angle 2 arg(z), z = (denominator, numerator) of Van
// Oosterom and Strackee [van-oosterom-1983]. The sum over triangles is twice the argument of the
// product of their z, plus full turns, which are counted where the product crosses the negative
// real axis.
#pragma once

#include "proxima/geometry.h"

#include <cmath>
#include <numbers>

namespace proxima {

class SolidAngleSum {
public:
    /// Adds the triangle with these corners relative to the eye, positive where its
    /// counter-clockwise side faces away. One whose plane contains the eye adds nothing. The
    /// corners' lengths should be within 1e-60 to 1e60.
    void add(const Vec3& a, const Vec3& b, const Vec3& c) noexcept
    {
        const double numerator = a.dot(b.cross(c));
        if (numerator == 0.0) return;
        const double la = a.norm();
        const double lb = b.norm();
        const double lc = c.norm();
        const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        const double real = real_ * denominator - imaginary_ * numerator;
        const double imaginary = real_ * numerator + imaginary_ * denominator;
        if (numerator > 0.0) {
            if (imaginary_ >= 0.0 && imaginary < 0.0) ++turns_;
        } else if (imaginary_ < 0.0 && imaginary >= 0.0) {
            --turns_;
        }
        const double size = std::abs(real) + std::abs(imaginary);
        const bool representable = size > 1e-60 && size < 1e60;
        const double scale = representable ? 1.0 : 1.0 / size;
        real_ = real * scale;
        imaginary_ = imaginary * scale;
    }

    /// The sum as a part of the whole sphere: 1 from inside one closed outward surface.
    [[nodiscard]] double winding() const noexcept
    {
        return turns_ + std::atan2(imaginary_, real_) / (2.0 * std::numbers::pi);
    }

private:
    double real_ = 1.0;
    double imaginary_ = 0.0;
    double turns_ = 0.0;
};

} // namespace proxima
