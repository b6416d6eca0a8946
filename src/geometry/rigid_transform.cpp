#include "proxima/geometry.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"

#include <cmath>

namespace proxima {

Result<RigidTransform> make_rigid_transform(std::span<const double, 12> matrix)
{
    RigidTransform result;
    for (int row = 0; row < 3; ++row) {
        const auto at = matrix.subspan(4 * static_cast<std::size_t>(row), 4);
        for (int column = 0; column < 4; ++column) {
            const double number = at[static_cast<std::size_t>(column)];
            if (!std::isfinite(number)) {
                return fail(ErrorCode::invalid_argument,
                            concat("a pose has the number ", number, " in row ", row, ", column ",
                                   column, "; give finite numbers"));
            }
            (column < 3 ? result.rotation(row, column) : result.translation[row]) = number;
        }
    }
    const Mat3 product = result.rotation.transpose() * result.rotation;
    const double off = (product - Mat3::Identity()).norm();
    if (!(off <= rigid_tolerance)) {
        return fail(ErrorCode::invalid_argument,
                    concat("a pose stretches or shears: R^T R is ", off,
                           " away from the identity, more than ", rigid_tolerance,
                           "; give a rotation, three orthogonal rows of length 1"));
    }
    if (result.rotation.determinant() < 0) {
        return fail(ErrorCode::invalid_argument,
                    "a pose mirrors: its determinant is negative; give a rotation");
    }
    return result;
}

} // namespace proxima
