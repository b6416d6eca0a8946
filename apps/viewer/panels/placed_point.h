// A point that a panel puts somewhere until a person puts it elsewhere.
#pragma once

#include "viewer/panel.h"

#include <array>
#include <string_view>

namespace proxima {

/// The point at an offset from the middle of a model: to the right, to the front and up in its
/// first view, each as a part of the diagonal of its box.
[[nodiscard]] Vec3 point_at_offset(const ViewModel& model, double right, double front, double up);

/// A point of a surface and a direction away from the surface there.
struct PointWithNormal {
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ();

    /// So far above it, in the model's units; below where negative.
    [[nodiscard]] Vec3 above(double height) const { return point + height * normal; }
};
/// A point of the surface that an eye far away in the unit direction `to_eye` sees with what is
/// round it, where the model leaves the space above free: no point in a bore. `height` per
/// diagonal is how far above it something will stand.
[[nodiscard]] PointWithNormal visible_point(const ViewModel& model, const Vec3& to_eye,
                                            double height);

/// The part of the model around a point: it reaches at least the part `least` of the model's
/// diagonal to each side, and is large enough to tell triangles apart. The whole model where that
/// is not much larger.
[[nodiscard]] Box close_up(const ViewModel& model, const Vec3& point, double least);

struct PlacedPoint {
    Vec3 at = Vec3::Zero();
    std::array<bool, 3> is_set = {}; ///< by a person, each coordinate

    [[nodiscard]] bool is_untouched() const { return is_set == std::array<bool, 3>{}; }

    /// Where the panel would have it: heeded until somebody has set it.
    void place(const Vec3& to)
    {
        for (int axis = 0; axis < 3; ++axis)
            if (!is_set[static_cast<std::size_t>(axis)]) at[axis] = to[axis];
    }
    void set(const Vec3& to)
    {
        at = to;
        is_set.fill(true);
    }

    /// Three numbers "NAME x", "NAME y" and "NAME z", as far as three times the models' size.
    void offer(Controls& controls, std::string_view name, const ViewModels& models);
};

} // namespace proxima
