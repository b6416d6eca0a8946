#include "proxima/query/open_pair.h"

#include "proxima/geometry/triangle_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr double root_reach = 1.01; // the mesh is within 1, its boxes within 1 + 2^-19
constexpr double too_coarse = 0x1p-6;

void set_frame(const Mat3& rotation, const Vec3& offset, PairFrame& frame) noexcept
{
    frame.exact_rotation = rotation;
    frame.exact_offset = offset;
    for (int row = 0; row < 4; ++row) {
        const auto k = static_cast<std::size_t>(row);
        for (int column = 0; column < 3; ++column) {
            const auto j = static_cast<std::size_t>(column);
            const auto number = row < 3 ? static_cast<float>(rotation(row, column)) : 0.0F;
            frame.columns[j][k] = number;
            frame.column_sizes[j][k] = std::abs(number);
        }
        frame.offset[k] = row < 3 ? static_cast<float>(offset[row]) : 0.0F;
    }
}

} // namespace

PairStart open_pair(const RayIndex& a, const RayIndex& b, const RigidTransform& pose_b,
                    OpenPair& open) noexcept
{
    if (a.triangle_count() == 0 || b.triangle_count() == 0) return PairStart::apart;
    const double size_a = root_reach / a.scale();
    const double size_b = root_reach / b.scale();
    const Vec3 between = pose_b(b.center()) - a.center();
    // v = 2^-53. A moved corner q has 3 products, 3 sums: off by 4 v (|q|_1 + |t|), rounding of
    // R q included; so is R c_b + t, whose difference from c_a is off by 1 v more. Coordinates in
    // the indexes' units are off by 2 v times the mesh's size. All of it, per axis:
    constexpr double roundoff = 0x1p-53;
    const double reach = b.center().lpNorm<1>() + 3 * size_b;
    const double error =
        roundoff * (10 * (reach + pose_b.translation.lpNorm<Eigen::Infinity>()) +
                    2 * a.center().lpNorm<Eigen::Infinity>() + 4 * (size_a + size_b)) +
        64 * std::numeric_limits<double>::denorm_min();
    const double farthest = between.cwiseAbs().maxCoeff();
    if (farthest > (size_a + 1.8 * size_b) + 2 * error) return PairStart::apart;
    const double scale = std::min(a.scale(), b.scale());
    if (!(error * scale < too_coarse)) return PairStart::too_far;
    set_frame(pose_b.rotation, between * scale, open.frames[0]);
    set_frame(pose_b.rotation.transpose(), -(pose_b.rotation.transpose() * between) * scale,
              open.frames[1]);
    open.pose_error = static_cast<float>(error * scale * 1.8);
    constexpr float float_roundoff = 0x1p-24F;
    open.box_slack = 160 * float_roundoff + 2 * open.pose_error;
    open.sides[0] = {&a, a.blocks().data(), static_cast<float>(scale / a.scale())};
    open.sides[1] = {&b, b.blocks().data(), static_cast<float>(scale / b.scale())};
    open.pose = &pose_b;
    return PairStart::ready;
}

bool ask_rows(const RayIndex& a, std::uint32_t row_a, const RayIndex& b, std::uint32_t row_b,
              const RigidTransform& pose_b) noexcept
{
    const Triangle moved = pose_b(row_triangle(b, row_b));
    for (const Vec3& corner : moved.vertices)
        if (!corner.allFinite()) return false;
    return triangles_meet(row_triangle(a, row_a), moved);
}

} // namespace proxima
