#include "proxima/geometry.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"

#include <Eigen/SVD>
#include <cmath>

namespace proxima {

namespace {

Mat3 rotation_of(std::span<const double, 12> matrix)
{
    using Rows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
    return Eigen::Map<const Rows>(matrix.data()).leftCols<3>();
}

double rotation_error(const Mat3& rotation)
{
    return (rotation.transpose() * rotation - Mat3::Identity()).norm();
}

/// What a matrix does that is no rotation.
tl::unexpected<Error> refuse(const Mat3& matrix, double off)
{
    const Vec3 scales = matrix.jacobiSvd().singularValues(); // the largest first
    if (scales[0] - scales[2] <= nearly_rigid_tolerance * scales[0]) {
        return fail(ErrorCode::invalid_argument,
                    concat("a pose scales by ", scales[0],
                           "; poses move and turn: scale the mesh, or give a rotation"));
    }
    return fail(ErrorCode::invalid_argument,
                concat("a pose stretches or shears: R^T R is ", off,
                       " away from the identity, more than ", nearly_rigid_tolerance,
                       "; give a rotation, three orthogonal rows of length 1"));
}

} // namespace

double rotation_error(std::span<const double, 12> matrix) noexcept
{
    return rotation_error(rotation_of(matrix));
}

Result<RigidTransform> make_rigid_transform(std::span<const double, 12> matrix)
{
    for (std::size_t i = 0; i < matrix.size(); ++i) {
        if (std::isfinite(matrix[i])) continue;
        return fail(ErrorCode::invalid_argument,
                    concat("a pose has the number ", matrix[i], " in row ", i / 4, ", column ",
                           i % 4, "; give finite numbers"));
    }
    RigidTransform result;
    result.rotation = rotation_of(matrix);
    result.translation = {matrix[3], matrix[7], matrix[11]};
    const double off = rotation_error(result.rotation);
    if (!(off <= nearly_rigid_tolerance)) return refuse(result.rotation, off);
    if (result.rotation.determinant() < 0) {
        return fail(ErrorCode::invalid_argument,
                    "a pose mirrors: its determinant is negative; give a rotation");
    }
    if (off > rigid_tolerance) {
        const Eigen::JacobiSVD<Mat3> svd(result.rotation,
                                         Eigen::ComputeFullU | Eigen::ComputeFullV);
        result.rotation = svd.matrixU() * svd.matrixV().transpose();
    }
    return result;
}

} // namespace proxima
