// The numbers of a pose, as files and make_rigid_transform have them.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>

namespace proxima {

/// The row-major 3 x 4 matrix (R | t).
[[nodiscard]] inline std::array<double, 12> pose_matrix(const RigidTransform& pose) noexcept
{
    std::array<double, 12> matrix{};
    for (std::size_t row = 0; row < 3; ++row) {
        const auto at = static_cast<Eigen::Index>(row);
        for (std::size_t column = 0; column < 3; ++column)
            matrix[4 * row + column] = pose.rotation(at, static_cast<Eigen::Index>(column));
        matrix[4 * row + 3] = pose.translation[at];
    }
    return matrix;
}

} // namespace proxima
