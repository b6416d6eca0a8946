#include "cull_by_lanes.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cull_by_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::bench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, 16>;

/// Calls take(first, mask of lanes) for every block of triangles.
template <class Take>
HWY_INLINE void for_blocks(const float* const* coordinates, std::size_t count,
                           const LanePlane* planes, std::size_t plane_count, const Take& take)
{
    const Tag d;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        hn::Vec<Tag> x[3];
        hn::Vec<Tag> y[3];
        hn::Vec<Tag> z[3];
        for (std::size_t corner = 0; corner < 3; ++corner) {
            x[corner] = hn::Load(d, coordinates[3 * corner] + first);
            y[corner] = hn::Load(d, coordinates[3 * corner + 1] + first);
            z[corner] = hn::Load(d, coordinates[3 * corner + 2] + first);
        }
        auto inside = hn::FirstN(d, count - first);
        for (std::size_t i = 0; i < plane_count; ++i) {
            const auto& numbers = planes[i].numbers; // lambdas of C++20 see no parts of it by name
            const auto a = hn::Set(d, numbers[0]);
            const auto b = hn::Set(d, numbers[1]);
            const auto c = hn::Set(d, numbers[2]);
            const auto e = hn::Set(d, numbers[3]);
            const auto value = [&](std::size_t corner) HWY_ATTR {
                return hn::MulAdd(a, x[corner],
                                  hn::MulAdd(b, y[corner], hn::MulAdd(c, z[corner], e)));
            };
            const auto most = hn::Max(hn::Max(value(0), value(1)), value(2));
            inside = hn::And(inside, hn::Ge(most, hn::Zero(d)));
            if (hn::AllFalse(d, inside)) break;
        }
        take(first, inside);
    }
}

std::size_t triangle_ids(const float* const* coordinates, std::size_t count,
                         const LanePlane* planes, std::size_t plane_count, std::uint32_t* ids)
{
    const hn::RebindToUnsigned<Tag> words;
    std::size_t found = 0;
    for_blocks(coordinates, count, planes, plane_count,
               [&](std::size_t first, hn::Mask<Tag> inside) HWY_ATTR {
                   const auto all = hn::Iota(words, static_cast<std::uint32_t>(first));
                   const auto mask = hn::RebindMask(words, inside);
                   hn::StoreU(hn::Compress(all, mask), words, ids + found);
                   found += hn::CountTrue(words, mask);
               });
    return found;
}

std::size_t triangle_ranges(const float* const* coordinates, std::size_t count,
                            const LanePlane* planes, std::size_t plane_count, TriangleRange* ranges)
{
    const Tag d;
    std::size_t found = 0;
    std::uint32_t begin = 0;
    bool open = false;
    for_blocks(coordinates, count, planes, plane_count,
               [&](std::size_t first, hn::Mask<Tag> inside) HWY_ATTR {
                   std::uint8_t bytes[8] = {};
                   (void)hn::StoreMaskBits(d, inside, bytes);
                   const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
                   const std::uint32_t full = lanes == 32 ? ~0U : (1U << lanes) - 1;
                   const std::uint32_t bits = (bytes[0] | bytes[1] << 8U) & full;
                   // Where a range begins or ends.
                   std::uint32_t turns = (bits ^ (bits << 1U | (open ? 1U : 0U))) & full;
                   for (; turns != 0; turns &= turns - 1) {
                       const auto at = static_cast<std::uint32_t>(first) +
                                       static_cast<std::uint32_t>(std::countr_zero(turns));
                       if (open) {
                           ranges[found++] = {begin, at - begin};
                       } else {
                           begin = at;
                       }
                       open = !open;
                   }
               });
    if (open) ranges[found++] = {begin, static_cast<std::uint32_t>(count) - begin};
    return found;
}

void vertices_outside(const float* const* coordinates, std::size_t count, const LanePlane* planes,
                      std::size_t plane_count, std::uint8_t* outside)
{
    const Tag d;
    const hn::RebindToSigned<Tag> words;
    const hn::Rebind<std::uint8_t, Tag> bytes;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const auto x = hn::Load(d, coordinates[0] + first);
        const auto y = hn::Load(d, coordinates[1] + first);
        const auto z = hn::Load(d, coordinates[2] + first);
        auto bits = hn::Zero(words);
        for (std::size_t i = 0; i < plane_count; ++i) {
            const auto& [a, b, c, e] = planes[i].numbers;
            const auto value = hn::MulAdd(
                hn::Set(d, a), x,
                hn::MulAdd(hn::Set(d, b), y, hn::MulAdd(hn::Set(d, c), z, hn::Set(d, e))));
            const auto bit = hn::Set(words, static_cast<std::int32_t>(1U << i));
            bits = hn::Or(
                bits, hn::IfThenElseZero(hn::RebindMask(words, hn::Lt(value, hn::Zero(d))), bit));
        }
        hn::StoreU(hn::DemoteTo(bytes, bits), bytes, outside + first);
    }
}

} // namespace proxima::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima::bench {

HWY_EXPORT(triangle_ids);
HWY_EXPORT(triangle_ranges);
HWY_EXPORT(vertices_outside);

namespace {

constexpr std::size_t block = 16;

std::size_t padded_to_blocks(std::size_t count)
{
    return (count + block - 1) / block * block;
}

template <std::size_t Count>
std::array<const float*, Count>
pointers(const std::array<hwy::AlignedFreeUniquePtr<float[]>, Count>& arrays)
{
    std::array<const float*, Count> result;
    for (std::size_t i = 0; i < Count; ++i) result[i] = arrays[i].get();
    return result;
}

} // namespace

std::vector<LanePlane> lane_planes(const ViewVolume& volume)
{
    std::vector<LanePlane> planes;
    for (const ViewPlane& plane : volume.planes()) {
        planes.push_back(
            {{static_cast<float>(plane.normal.x()), static_cast<float>(plane.normal.y()),
              static_cast<float>(plane.normal.z()), static_cast<float>(plane.offset)}});
    }
    return planes;
}

TriangleArrays::TriangleArrays(std::span<const Triangle> triangles)
    : count_(triangles.size()), padded_(padded_to_blocks(count_))
{
    for (std::size_t k = 0; k < 9; ++k) {
        coordinates_[k] = hwy::AllocateAligned<float>(padded_);
        for (std::size_t i = 0; i < padded_; ++i) {
            coordinates_[k][i] =
                i < count_ ? static_cast<float>(
                                 triangles[i].vertices[k / 3][static_cast<Eigen::Index>(k % 3)])
                           : 0.0F;
        }
    }
}

std::size_t TriangleArrays::visible_ids(std::span<const LanePlane> planes,
                                        std::span<std::uint32_t> ids) const
{
    return HWY_DYNAMIC_DISPATCH(triangle_ids)(pointers(coordinates_).data(), count_, planes.data(),
                                              planes.size(), ids.data());
}

std::size_t TriangleArrays::visible_ranges(std::span<const LanePlane> planes,
                                           std::span<TriangleRange> ranges) const
{
    return HWY_DYNAMIC_DISPATCH(triangle_ranges)(pointers(coordinates_).data(), count_,
                                                 planes.data(), planes.size(), ranges.data());
}

VertexArrays::VertexArrays(std::span<const Vec3> positions,
                           std::span<const TriangleCorners> triangles)
    : vertices_(positions.size()), outside_(padded_to_blocks(vertices_)),
      triangles_(triangles.begin(), triangles.end())
{
    for (std::size_t k = 0; k < 3; ++k) {
        coordinates_[k] = hwy::AllocateAligned<float>(outside_.size());
        for (std::size_t i = 0; i < outside_.size(); ++i) {
            coordinates_[k][i] =
                i < vertices_ ? static_cast<float>(positions[i][static_cast<Eigen::Index>(k)])
                              : 0.0F;
        }
    }
}

void VertexArrays::find_outside(std::span<const LanePlane> planes)
{
    HWY_DYNAMIC_DISPATCH(vertices_outside)
    (pointers(coordinates_).data(), outside_.size(), planes.data(), planes.size(), outside_.data());
}

std::size_t VertexArrays::visible_ids(std::span<const LanePlane> planes,
                                      std::span<std::uint32_t> ids)
{
    find_outside(planes);
    std::size_t found = 0;
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
        const auto& [a, b, c] = triangles_[i];
        ids[found] = i;
        found += (outside_[a] & outside_[b] & outside_[c]) == 0 ? 1U : 0U;
    }
    return found;
}

std::size_t VertexArrays::visible_ranges(std::span<const LanePlane> planes,
                                         std::span<TriangleRange> ranges)
{
    find_outside(planes);
    std::size_t found = 0;
    std::uint32_t begin = 0;
    bool open = false;
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
        const auto& [a, b, c] = triangles_[i];
        const bool inside = (outside_[a] & outside_[b] & outside_[c]) == 0;
        if (inside == open) continue;
        if (open) {
            ranges[found++] = {begin, i - begin};
        } else {
            begin = i;
        }
        open = inside;
    }
    if (open) ranges[found++] = {begin, static_cast<std::uint32_t>(triangles_.size()) - begin};
    return found;
}

} // namespace proxima::bench

#endif
