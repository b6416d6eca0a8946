#include "viewer/panels/placed_point.h"

#include "proxima/base/text.h"
#include "viewer/camera.h"

#include <algorithm>
#include <array>

namespace proxima {

Vec3 place_by(const ViewModel& model, double right, double front, double up)
{
    const View view({.azimuth = 0.0, .elevation = 0.0, .up = model.up}, {});
    return model.box.center() + model.box.extent().norm() *
                                    (right * view.right() + front * view.back() + up * view.up());
}

void PlacedPoint::offer(Controls& controls, std::string_view name, const ViewModels& models)
{
    // Before there are models any number will do.
    constexpr double anywhere = 1e12;
    const Box box = bounding_box(models);
    constexpr std::array axes = {" x", " y", " z"};
    for (int axis = 0; axis < 3; ++axis) {
        double least = -anywhere;
        double most = anywhere;
        if (!box.empty()) {
            const double reach = 1.5 * box.extent().norm();
            least = std::min(box.center()[axis] - reach, at[axis]);
            most = std::max(box.center()[axis] + reach, at[axis]);
        }
        if (controls.number(concat(name, axes[static_cast<std::size_t>(axis)]), at[axis], least,
                            most))
            is_set = true;
    }
}

} // namespace proxima
