// Three lamps fixed to the camera and light from the sky.
#pragma once

#include "cli/canvas.h"

#include <algorithm>

namespace proxima {

class Lamps {
public:
    /// The camera's axes: right, up, and towards the eye.
    Lamps(const Vec3& right, const Vec3& up, const Vec3& back)
        : key_((-0.45 * right + 0.65 * up + 0.60 * back).normalized()),
          fill_((0.80 * right + 0.10 * up + 0.45 * back).normalized()), sky_(up)
    {}

    /// \pre the normal has length 1
    [[nodiscard]] Color shade(const Vec3& normal, const Color& surface) const
    {
        const auto part = [&](const Vec3& lamp) {
            return static_cast<float>(std::max(0.0, normal.dot(lamp)));
        };
        const auto sky = static_cast<float>(0.5 + 0.5 * normal.dot(sky_));
        const Color light = 0.80F * part(key_) * Color(1.00F, 0.97F, 0.92F) +
                            0.20F * part(fill_) * Color(0.80F, 0.88F, 1.00F) +
                            (0.14F + 0.22F * sky) * Color(0.93F, 0.96F, 1.00F);
        return surface * light;
    }

private:
    Vec3 key_;
    Vec3 fill_;
    Vec3 sky_;
};

} // namespace proxima
