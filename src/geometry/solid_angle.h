// Solid angles of triangles, summed without an arc tangent each.
//
// A triangle seen from a point spans the angle 2 arg(z), z = (denominator, numerator) of Van
// Oosterom and Strackee [van-oosterom-1983]. The sum over triangles is twice the argument of the
// product of their z, plus full turns, which are counted where the product crosses the negative
// real axis.
#pragma once

#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace proxima {

class SolidAngleSum {
public:
    /// Adds a triangle seen from the eye, positive where its counter-clockwise side faces away. One
    /// whose plane contains the eye adds nothing; on which side the eye is, is exact. `unit` brings
    /// most distances of corners to within 1e-60 to 1e60: others take longer.
    void add(const Triangle& triangle, const Vec3& eye, double unit) noexcept
    {
        const Vec3 a = (triangle[0] - eye) * unit;
        const Vec3 b = (triangle[1] - eye) * unit;
        const Vec3 c = (triangle[2] - eye) * unit;
        double numerator = a.dot(b.cross(c));
        double la = a.norm();
        double lb = b.norm();
        double lc = c.norm();
        if (!(la * lb * lc > 1e-190 && la * lb * lc < 1e190)) {
            const double own = unit_of(triangle, eye);
            if (own != unit) return add(triangle, eye, own);
            // Squares of the distance of a corner that is all but the eye are zero.
            la = length_of(a);
            lb = length_of(b);
            lc = length_of(c);
        }
        // Off by less than 20 * 2^-53 of this. Before a face the sign is all that matters of it.
        const double doubt = 0x1p-48 * (la * lb * lc);
        if (std::abs(numerator) <= doubt) {
            const int side = orient3d(triangle[0], triangle[1], triangle[2], eye);
            if (side == 0) return;
            numerator = -side * std::max(std::abs(numerator), 0x1p-10 * doubt);
        }
        const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        const double real = real_ * denominator - imaginary_ * numerator;
        const double imaginary = real_ * numerator + imaginary_ * denominator;
        const double size = std::abs(real) + std::abs(imaginary);
        if (!(size > 0.0)) return; // the eye is a corner, as far as doubles tell
        if (numerator > 0.0) {
            if (imaginary_ >= 0.0 && imaginary < 0.0) ++turns_;
        } else if (imaginary_ < 0.0 && imaginary >= 0.0) {
            --turns_;
        }
        const bool representable = size > 1e-60 && size < 1e60;
        const double scale = representable ? 1.0 : std::min(1.0 / size, 0x1p1000);
        real_ = real * scale;
        imaginary_ = imaginary * scale;
    }

    /// The sum as a part of the whole sphere: 1 from inside one closed outward surface.
    [[nodiscard]] double winding() const noexcept
    {
        return turns_ + std::atan2(imaginary_, real_) / (2.0 * std::numbers::pi);
    }

private:
    /// The power of two that brings the farthest corner's distance to about 1.
    [[nodiscard]] static double unit_of(const Triangle& triangle, const Vec3& eye) noexcept
    {
        double far = 0;
        for (const Vec3& corner : triangle.vertices)
            far = std::max(far, (corner - eye).cwiseAbs().maxCoeff());
        if (!(far > 0 && std::isfinite(far))) return 1.0;
        return std::ldexp(1.0, std::clamp(-std::ilogb(far), -1000, 1000));
    }

    double real_ = 1.0;
    double imaginary_ = 0.0;
    double turns_ = 0.0;
};

} // namespace proxima
