#include "query/culling/prepare_volume.h"

#include "index/index_parts.h"

#include <cmath>
#include <limits>

namespace proxima {

namespace {

// Errors in floats, u = 2^-24, where |n|_1 <= 1, |y| <= 1.01 and |d| <= 1.05. A box's plane is o +
// q s with s q <= 2.1: o is off by 1.01 u, n, d and n s by u of their size, the six products and
// sums by u each of at most 4.3, twice that where they are not fused: 2 + 2 + 2.1 + 6 * 4.3 * 2 <
// 60 u. Vertices, rounded to floats, are less off.
constexpr double float_slack = 64 * 0x1p-24;

// In doubles the offset is off by a few roundings of what it is made of.
constexpr double double_error = 0x1p-48;

/// No point of the mesh is farther from the centre, on any axis.
constexpr double volume_reach = 1.01;
/// Beyond this, margins included, a plane does not come near.
constexpr double beyond = 1.04;

} // namespace

VolumeStart prepare_volume(const IndexParts& index, const ViewVolume& volume,
                           VolumeTraversal& open) noexcept
{
    if (volume.empty() || index.triangle_count() == 0) return VolumeStart::sees_nothing;
    open.count = 0;
    for (std::uint32_t i = 0; i < volume.planes().size(); ++i) {
        const ViewPlane& plane = volume.planes()[i];
        // By a power of two first, so that nothing over- or underflows that can be helped.
        int exponent = 0;
        std::frexp(plane.normal.cwiseAbs().maxCoeff(), &exponent);
        const Vec3 scaled(std::ldexp(plane.normal.x(), -exponent),
                          std::ldexp(plane.normal.y(), -exponent),
                          std::ldexp(plane.normal.z(), -exponent));
        const double length = scaled.cwiseAbs().sum();
        const Vec3 normal = scaled / length;
        const double far = std::ldexp(plane.offset, -exponent) / length;
        const double offset = (normal.dot(index.center()) + far) * index.scale();
        const double size =
            (normal.cwiseAbs().dot(index.center().cwiseAbs()) + std::abs(far)) * index.scale();
        const double error = double_error * (size + 1);
        if (offset - error > beyond) continue;
        if (offset + error < -beyond) return VolumeStart::sees_nothing;
        FloatPlane& flat = open.planes[open.count++];
        // Unsure everywhere where doubles are too coarse.
        const bool is_known = error < volume_reach;
        flat.offset = is_known ? static_cast<float>(offset) : 0.0F;
        flat.slack = is_known ? static_cast<float>(float_slack + 2 * error)
                              : std::numeric_limits<float>::infinity();
        for (std::size_t k = 0; k < 3; ++k)
            flat.normal[k] = static_cast<float>(normal[static_cast<Eigen::Index>(k)]);
        flat.plane = i;
    }
    return open.count == 0 ? VolumeStart::sees_all : VolumeStart::ready;
}

} // namespace proxima
