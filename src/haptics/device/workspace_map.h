// From the device's metres to the model's units and back: a uniform scale and a translation.
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// A point p of the device is center + units_per_metre * p of the model.
struct WorkspaceMap {
    double units_per_metre = 1;
    Vec3 center = Vec3::Zero(); ///< what the middle of the workspace is

    [[nodiscard]] Vec3 to_model(const Vec3& device) const noexcept
    {
        return center + units_per_metre * device;
    }
    [[nodiscard]] Vec3 to_device(const Vec3& model) const noexcept
    {
        return (model - center) / units_per_metre;
    }
};

/// How much of the workspace's radius the model takes: the rest is to move round it.
inline constexpr double workspace_share = 0.6;

/// The box within that share of the workspace, centred. \pre the box is not empty, radius > 0
[[nodiscard]] inline WorkspaceMap fit_workspace(const Box& box, double workspace_radius) noexcept
{
    const double half = box.extent().norm() / 2;
    return {half > 0 ? half / (workspace_share * workspace_radius) : 1.0, box.center()};
}

} // namespace proxima
