// A point that a panel puts somewhere until a person puts it elsewhere.
#pragma once

#include "viewer/panel.h"

#include <string_view>

namespace proxima {

/// From the middle of a model so far to the right, to the front and up, as it is seen at first, per
/// diagonal of its box.
[[nodiscard]] Vec3 place_by(const ViewModel& model, double right, double front, double up);

/// A place on the model that is seen at first, on its right, and the direction out of the surface
/// there.
struct SurfacePlace {
    Vec3 point = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ();

    /// So far above it, in the model's units; below where negative.
    [[nodiscard]] Vec3 above(double height) const { return point + height * normal; }
};
[[nodiscard]] SurfacePlace seen_place(const ViewModel& model);

/// A part of the model about a place: of at least so much of its diagonal to each side, and large
/// enough to tell its triangles apart. All of the model where that is not much more.
[[nodiscard]] Box close_up(const ViewModel& model, const Vec3& place, double least);

struct PlacedPoint {
    Vec3 at = Vec3::Zero();
    bool is_set = false; ///< by a person

    /// Where the panel would have it: heeded until somebody has set it.
    void place(const Vec3& to)
    {
        if (!is_set) at = to;
    }
    void set(const Vec3& to)
    {
        at = to;
        is_set = true;
    }

    /// Three numbers "NAME x", "NAME y" and "NAME z", as far as three times the models' size.
    void offer(Controls& controls, std::string_view name, const ViewModels& models);
};

} // namespace proxima
