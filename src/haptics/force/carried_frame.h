// The frame in which the passivity guards see a device move: with the mean velocity of what it touches.
//
// A lift or a wheel carries a device, which may swing on it as on a surface at rest. What vibrates
// under a device does not carry it: seen from there, a hand that stands still would swing, and
// damping that motion would shake the hand.
//
//     v     += (surface's velocity - v) T / 0.25 s         while it touches
//
// A swing's legs are shorter than the quarter of a second. So of a surface that moves to and fro as fast
// as a swing, the frame follows a third at most.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace proxima {

/// One per device. noexcept, no allocation, O(1).
template <int Size>
class CarriedFrame {
public:
    using Vector = Eigen::Matrix<double, Size, 1>;

    /// Step of the frame in the seconds in which what is touched moved by `surface`; none: nothing is.
    /// \pre finite, seconds > 0
    [[nodiscard]] Vector step(const Vector* surface, double seconds) noexcept
    {
        if (surface != nullptr) {
            apart_ = 0;
            velocity_ += std::min(seconds / mean_seconds, 1.0) * (*surface / seconds - velocity_);
        } else {
            apart_ += seconds;
            if (apart_ > mean_seconds) velocity_.setZero();
        }
        return seconds * velocity_;
    }

    [[nodiscard]] const Vector& velocity() const noexcept { return velocity_; } ///< per second

    void restart() noexcept { *this = {}; }

private:
    static constexpr double mean_seconds = 0.25;

    Vector velocity_ = Vector::Zero();
    double apart_ = 0; ///< s since the last contact
};

} // namespace proxima
