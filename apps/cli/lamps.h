// Two lamps fixed to the camera and light from the sky.
#pragma once

#include "cli/canvas.h"

#include <algorithm>

namespace proxima {

/// Light that comes from one direction.
struct Lamp {
    Vec3 toward; ///< unit, from the surface to the lamp
    Color light;
};

class Lamps {
public:
    /// The camera's axes: right, up, and towards the eye.
    Lamps(const Vec3& right, const Vec3& up, const Vec3& back)
        : key{(-0.45 * right + 0.65 * up + 0.60 * back).normalized(),
              0.80F * Color(1.00F, 0.97F, 0.92F)},
          fill{(0.80 * right + 0.10 * up + 0.45 * back).normalized(),
               0.20F * Color(0.80F, 0.88F, 1.00F)},
          sky{up, 0.22F * Color(0.93F, 0.96F, 1.00F)}
    {}

    /// \pre the normal has length 1
    [[nodiscard]] Color shade(const Vec3& normal, const Color& surface) const
    {
        const auto part = [&](const Lamp& lamp) {
            return static_cast<float>(std::max(0.0, normal.dot(lamp.toward)));
        };
        const auto open = static_cast<float>(0.5 + 0.5 * normal.dot(sky.toward));
        return surface *
               (part(key) * key.light + part(fill) * fill.light + open * sky.light + everywhere);
    }

    Lamp key;
    Lamp fill;
    Lamp sky; ///< shines from its whole half of space
    Color everywhere = 0.14F * Color(0.93F, 0.96F, 1.00F);
};

} // namespace proxima
