#include "query/contact/contact_search.h"

#include "geometry/triangle_contact.h"
#include "index/binary_tree.h"
#include "index/index_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr double root_reach = 1.01; // the mesh is within 1, its boxes within 1 + 2^-19
constexpr double too_coarse = 0x1p-6;

void set_frame(const Mat3& rotation, const Vec3& offset, float slack, PairFrame& frame) noexcept
{
    for (int j = 0; j < 3; ++j) {
        frame.exact_columns[static_cast<std::size_t>(j)] = {rotation(0, j), rotation(1, j),
                                                            rotation(2, j), 0};
    }
    frame.exact_offset = {offset.x(), offset.y(), offset.z(), 0};
    frame.slack = slack;
    const auto number = [&](int row, int column) {
        return row < 3 ? static_cast<float>(rotation(row, column)) : 0.0F;
    };
    for (int i = 0; i < 4; ++i) {
        const auto low = static_cast<std::size_t>(i);
        const std::size_t high = low + 4;
        for (int j = 0; j < 3; ++j) {
            auto& column = frame.columns[static_cast<std::size_t>(j)];
            column[low] = number(i, j);
            column[high] = std::abs(number(i, j));
        }
        frame.offset[low] = i < 3 ? static_cast<float>(offset[i]) : 0.0F;
        frame.offset[high] = slack;
        // Axis e_i x R_j: half size j + 1 times |R_i,j+2|, and half size j + 2 times |R_i,j+1|.
        frame.edges[0][low] = std::abs(number(i, 2));
        frame.edges[1][low] = std::abs(number(i, 1));
        frame.edges[0][high] = std::abs(number(i, 0));
        frame.edges[1][high] = std::abs(number(i, 2));
        frame.edges[2][low] = std::abs(number(i, 1));
        frame.edges[3][low] = std::abs(number(i, 0));
        frame.edges[2][high] = 1; // axis R_j: half size j
        frame.edges[3][high] = 0;
    }
}

} // namespace

PairStart contact_search(const IndexParts& a, const IndexParts& b, const RigidTransform& pose_b,
                         ContactSearch& open) noexcept
{
    if (a.triangle_count() == 0 || b.triangle_count() == 0) return PairStart::apart;
    const double scale = std::min(a.scale(), b.scale());
    if (scale <= least_index_scale) return PairStart::too_far; // not within the frame, perhaps
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
    if (!(error * scale < too_coarse)) return PairStart::too_far;
    open.pose_error = static_cast<float>(error * scale * 1.8);
    constexpr float float_roundoff = 0x1p-24F;
    const float slack = 160 * float_roundoff + 2 * open.pose_error;
    const Mat3 back = pose_b.rotation.transpose();
    set_frame(pose_b.rotation, between * scale, slack, open.frames[0]);
    set_frame(back, -(back * between) * scale, slack, open.frames[1]);
    open.sides[0] = {&a, a.blocks().data(), static_cast<float>(scale / a.scale())};
    open.sides[1] = {&b, b.blocks().data(), static_cast<float>(scale / b.scale())};
    open.pose = &pose_b;
    return PairStart::ready;
}

bool ask_rows(const IndexParts& a, std::uint32_t row_a, const IndexParts& b, std::uint32_t row_b,
              const RigidTransform& pose_b) noexcept
{
    const Triangle moved = pose_b(b.triangle(row_b));
    for (const Vec3& corner : moved.vertices)
        if (!corner.allFinite()) return false;
    return triangles_meet(a.triangle(row_a), moved);
}

} // namespace proxima
