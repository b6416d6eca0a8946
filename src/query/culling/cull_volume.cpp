#include "proxima/cull.h"

#include "base/fixed_stack.h"
#include "geometry/view_contact.h"
#include "geometry/view_plane.h"
#include "index/index_parts.h"
#include "query/culling/prepare_volume.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <hwy/cache_control.h>

#ifndef PROXIMA_QUERY_CULL_VOLUME_ONCE
#define PROXIMA_QUERY_CULL_VOLUME_ONCE

namespace proxima {

/// Joins rows that come in order to ranges as long as can be.
class RangeJoiner {
public:
    explicit RangeJoiner(FunctionRef<Flow(TriangleRange)> visitor) noexcept : visitor_(visitor) {}

    /// Flow::stop where the visitor said so: then no more is to be added.
    Flow add(std::uint32_t first, std::uint32_t end) noexcept
    {
        if (first != end_) {
            if (flush() == Flow::stop) return Flow::stop;
            first_ = first;
        }
        end_ = end;
        return Flow::proceed;
    }
    Flow flush() noexcept
    {
        if (end_ == first_) return Flow::proceed;
        const TriangleRange range = {first_, end_ - first_};
        first_ = end_;
        return visitor_(range);
    }

private:
    FunctionRef<Flow(TriangleRange)> visitor_;
    std::uint32_t first_ = 0;
    std::uint32_t end_ = 0;
};

/// One query under way.
struct Culling {
    const IndexParts& index;
    const ViewVolume& volume;
    CullMode mode;
    const VolumeTraversal& open;
    RangeJoiner& ranges;
};

/// The planes that may cut a box, by bits; the last bit stands for all from the 64th on.
using PlaneMask = std::uint64_t;
inline constexpr std::uint32_t last_plane_bit = 63;

inline std::uint32_t end_of_planes(const VolumeTraversal& open, std::uint32_t bit) noexcept
{
    return bit == last_plane_bit ? open.count : bit + 1;
}

/// Whether a mask, not empty, stands for one plane alone.
inline bool is_one_plane(const VolumeTraversal& open, PlaneMask mask) noexcept
{
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(mask));
    return std::has_single_bit(mask) && end_of_planes(open, bit) == bit + 1;
}

/// Calls visit(plane) for every plane of the mask, until it returns false.
template <class Visit>
inline void for_planes(const VolumeTraversal& open, PlaneMask mask, const Visit& visit) noexcept
{
    for (; mask != 0; mask &= mask - 1) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(mask));
        for (std::uint32_t i = bit; i < end_of_planes(open, bit); ++i)
            if (!visit(open.planes[i])) return;
    }
}

/// Asks a triangle in doubles; the box that it is in is inside of all planes not in the mask.
bool is_row_visible(const Culling& culling, std::uint32_t row, PlaneMask mask) noexcept;

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/culling/cull_volume.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using CullTag = hn::CappedTag<float, 8>;
using CullFloats = hn::Vec<CullTag>;
inline constexpr std::size_t cull_lanes = HWY_MIN(8, HWY_LANES(float));
inline constexpr std::size_t cull_parts = 8 / cull_lanes;

/// Eight floats.
struct EightValues {
    CullFloats part[cull_parts];
};

HWY_INLINE std::uint32_t bits_of(hn::Mask<CullTag> mask)
{
    std::uint8_t bits[8] = {};
    (void)hn::StoreMaskBits(CullTag(), mask, bits);
    return bits[0] & ((1U << cull_lanes) - 1);
}

/// Where eight boxes lie by a plane, or eight points: bits by box.
struct PlaneSides {
    std::uint32_t outside = 0; ///< surely, wholly
    std::uint32_t inside = 0;
};

/// Boxes between numbers of the node's grid.
struct NodeBoxes {
    EightValues lower[3];
    EightValues upper[3];
    float origin[3];

    HWY_INLINE explicit NodeBoxes(const IndexNode& node)
    {
        const CullTag d;
        const hn::RebindToSigned<CullTag> whole;
        const hn::Rebind<std::uint8_t, CullTag> bytes;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            origin[axis] = node.origin[axis] + 32768 * node.step[axis];
            for (std::size_t i = 0; i < cull_parts; ++i) {
                const std::uint8_t* const planes = node.planes[axis].data() + cull_lanes * i;
                lower[axis].part[i] =
                    hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(bytes, planes)));
                upper[axis].part[i] =
                    hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(bytes, planes + 8)));
            }
        }
    }

    /// Slots that have a child.
    HWY_INLINE std::uint32_t used() const
    {
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < cull_parts; ++i)
            bits |= bits_of(hn::Le(lower[0].part[i], upper[0].part[i])) << (cull_lanes * i);
        return bits;
    }

    HWY_INLINE PlaneSides sides(const IndexNode& node, const FloatPlane& plane) const
    {
        const CullTag d;
        const float start = plane.normal[0] * origin[0] + plane.normal[1] * origin[1] +
                            plane.normal[2] * origin[2] + plane.offset;
        const EightValues* outer[3];
        const EightValues* inner[3];
        CullFloats step[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const bool rises = plane.normal[axis] >= 0;
            outer[axis] = rises ? lower + axis : upper + axis;
            inner[axis] = rises ? upper + axis : lower + axis;
            step[axis] = hn::Set(d, plane.normal[axis] * node.step[axis]);
        }
        PlaneSides sides;
        for (std::size_t i = 0; i < cull_parts; ++i) {
            auto least = hn::Set(d, start);
            auto most = least;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                least = hn::MulAdd(step[axis], outer[axis]->part[i], least);
                most = hn::MulAdd(step[axis], inner[axis]->part[i], most);
            }
            const auto slack = hn::Set(d, plane.slack);
            sides.outside |= bits_of(hn::Lt(most, hn::Neg(slack))) << (cull_lanes * i);
            sides.inside |= bits_of(hn::Gt(least, slack)) << (cull_lanes * i);
        }
        return sides;
    }
};

/// Sides of a leaf's vertices.
HWY_INLINE PlaneSides vertex_sides(const IndexLeaf& leaf, const FloatPlane& plane)
{
    const CullTag d;
    PlaneSides sides;
    for (std::size_t i = 0; i < cull_parts; ++i) {
        auto value = hn::Set(d, plane.offset);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto coordinates = hn::Load(d, leaf.coordinates[axis].data() + cull_lanes * i);
            value = hn::MulAdd(hn::Set(d, plane.normal[axis]), coordinates, value);
        }
        const auto slack = hn::Set(d, plane.slack);
        sides.outside |= bits_of(hn::Lt(value, hn::Neg(slack))) << (cull_lanes * i);
        sides.inside |= bits_of(hn::Gt(value, slack)) << (cull_lanes * i);
    }
    return sides;
}

/// Rows of eight bits in a word, made columns [warren-2013].
HWY_INLINE std::uint64_t transposed(std::uint64_t x)
{
    std::uint64_t t = (x ^ (x >> 7U)) & 0x00AA00AA00AA00AAU;
    x ^= t ^ (t << 7U);
    t = (x ^ (x >> 14U)) & 0x0000CCCC0000CCCCU;
    x ^= t ^ (t << 14U);
    t = (x ^ (x >> 28U)) & 0x00000000F0F0F0F0U;
    return x ^ t ^ (t << 28U);
}

/// A block of which something may be visible, its rows, and the planes that may cut its box.
struct PendingRows {
    std::uint32_t reference;
    std::uint32_t first;
    std::uint32_t end;
    PlaneMask mask; ///< none: all is visible
};

/// How many blocks are opened at once, so that memory brings the next ones meanwhile.
inline constexpr std::size_t opened_together = 4;

/// Of every level there are at most as many as the blocks above that are opened at once have
/// children: blocks are opened from the top, where the deepest lie.
using PendingRowsStack = FixedStack<PendingRows, 8 * opened_together * IndexParts::max_levels + 1>;

/// What is visible below a node, in the order of rows.
struct OpenedNode {
    PendingRows children[8];
    std::uint32_t count = 0;
};

HWY_INLINE std::uint32_t first_row_below(const IndexBlock* blocks, std::uint32_t reference)
{
    const IndexBlock& block = blocks[reference & ~index_leaf_bit];
    return (reference & index_leaf_bit) != 0 ? block.leaf.first_row : block.node.first_row;
}

HWY_INLINE void prefetch_both(const IndexBlock& block)
{
    hwy::Prefetch(&block);
    hwy::Prefetch(reinterpret_cast<const std::byte*>(&block) + 64);
}

HWY_INLINE void open_node(const Culling& culling, const PendingRows& at, OpenedNode& opened)
{
    const IndexBlock* const blocks = culling.index.blocks().data();
    const IndexNode& node = blocks[at.reference].node;
    const NodeBoxes boxes(node);
    std::uint32_t visible = boxes.used();
    std::uint32_t any_cut = 0;
    std::uint64_t cut[8] = {}; // by eights of planes: for each a byte, bits by child
    for (PlaneMask left = at.mask; left != 0 && visible != 0; left &= left - 1) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(left));
        std::uint32_t inside = 0xFF;
        for (std::uint32_t i = bit; i < end_of_planes(culling.open, bit); ++i) {
            const PlaneSides sides = boxes.sides(node, culling.open.planes[i]);
            visible &= ~sides.outside;
            inside &= sides.inside;
        }
        any_cut |= ~inside & 0xFFU;
        cut[bit / 8] |= std::uint64_t{~inside & 0xFFU} << (8 * (bit % 8));
    }
    if (visible == 0) return;
    for (std::size_t i = 0; i < 8 && at.mask >> (8 * i) != 0; ++i) cut[i] = transposed(cut[i]);

    // In the order of rows: where runs begin, and bits of what is visible and what is cut.
    const auto count = 8 - static_cast<std::uint32_t>(std::countl_one(node.order)) / 4;
    std::uint32_t firsts[9];
    std::uint32_t shown = 0;
    std::uint32_t whole = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t slot = node.order >> (4 * i) & 15U;
        firsts[i] = node.starts[slot] == IndexNode::far_start
                        ? first_row_below(blocks, node.children[slot])
                        : node.first_row + node.starts[slot];
        shown |= (visible >> slot & 1U) << i;
        whole |= (visible & ~any_cut) >> slot << 31U >> (31U - i);
    }
    firsts[count] = at.end;
    while (shown != 0) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(shown));
        // Neighbours that are wholly visible go as one.
        const auto together = static_cast<std::uint32_t>(std::countr_one(whole >> i));
        if (together > 0) {
            opened.children[opened.count++] = {0, firsts[i], firsts[i + together], 0};
            shown &= ~(((1U << together) - 1) << i);
            continue;
        }
        shown &= shown - 1;
        const std::uint32_t slot = node.order >> (4 * i) & 15U;
        PlaneMask mask = 0;
        for (std::size_t k = 0; k < 8 && at.mask >> (8 * k) != 0; ++k)
            mask |= (cut[k] >> (8 * slot) & 0xFFU) << (8 * k);
        const std::uint32_t reference = node.children[slot];
        prefetch_both(blocks[reference & ~index_leaf_bit]);
        opened.children[opened.count++] = {reference, firsts[i], firsts[i + 1], mask};
    }
}

/// For bytes below 8 the byte with that bit.
HWY_INLINE std::uint64_t bits_of_bytes(std::uint64_t bytes)
{
    constexpr std::uint64_t each = 0x0101010101010101U;
    std::uint64_t bits = each + (bytes & each);
    const std::uint64_t twos = (bytes >> 1U & each) * 0xFFU;
    bits = (bits & ~twos) | (bits << 2U & twos);
    const std::uint64_t fours = (bytes >> 2U & each) * 0xFFU;
    return (bits & ~fours) | (bits << 4U & fours);
}

/// Which bytes are not zero, as bits.
HWY_INLINE std::uint32_t nonzero_bytes(std::uint64_t bytes)
{
    constexpr std::uint64_t low = 0x7F7F7F7F7F7F7F7FU;
    const std::uint64_t tops = (((bytes & low) + low) | bytes) & ~low;
    return static_cast<std::uint32_t>((tops >> 7U) * 0x0102040810204080U >> 56U);
}

HWY_INLINE Flow cull_leaf(const Culling& culling, const PendingRows& at)
{
    const IndexLeaf& leaf = culling.index.blocks()[at.reference & ~index_leaf_bit].leaf;
    constexpr std::uint64_t each = 0x0101010101010101U;
    std::uint64_t corners = 0; // a byte per triangle, bits by vertex
    for (const auto& bytes : leaf.corners)
        corners |= bits_of_bytes(std::bit_cast<std::uint64_t>(bytes));
    std::uint32_t visible = (1U << leaf.count) - 1;
    std::uint32_t sure = visible;
    std::uint32_t inside = 0xFF; // vertices, of all planes
    for_planes(culling.open, at.mask, [&](const FloatPlane& plane) {
        const PlaneSides sides = vertex_sides(leaf, plane);
        visible &= nonzero_bytes(corners & each * (~sides.outside & 0xFFU));
        sure &= nonzero_bytes(corners & each * sides.inside);
        inside &= sides.inside;
        return visible != 0;
    });
    // By a single plane both modes see the same.
    if (culling.mode == CullMode::exact && !is_one_plane(culling.open, at.mask))
        sure &= nonzero_bytes(corners & each * inside);
    for (std::uint32_t unsure = visible & ~sure; unsure != 0; unsure &= unsure - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(unsure));
        if (!is_row_visible(culling, at.first + i, at.mask)) visible &= ~(1U << i);
    }
    while (visible != 0) {
        const auto first = static_cast<std::uint32_t>(std::countr_zero(visible));
        const auto length = static_cast<std::uint32_t>(std::countr_one(visible >> first));
        if (culling.ranges.add(at.first + first, at.first + first + length) == Flow::stop)
            return Flow::stop;
        visible &= ~(((1U << length) - 1) << first);
    }
    return Flow::proceed;
}

void cull(const Culling& culling)
{
    PendingRowsStack pending;
    const std::uint32_t planes = culling.open.count;
    const PlaneMask all = planes > last_plane_bit ? ~PlaneMask{0} : (PlaneMask{1} << planes) - 1;
    pending.push({culling.index.root(), 0, culling.index.triangle_count(), all});
    const auto is_node = [](const PendingRows& at) {
        return at.mask != 0 && (at.reference & index_leaf_bit) == 0;
    };
    while (!pending.empty()) {
        if (!is_node(pending.top())) {
            const PendingRows at = pending.pop();
            const Flow flow =
                at.mask == 0 ? culling.ranges.add(at.first, at.end) : cull_leaf(culling, at);
            if (flow == Flow::stop) return;
            continue;
        }
        OpenedNode opened[opened_together];
        std::size_t count = 0;
        for (; count < opened_together && !pending.empty(); ++count) {
            const PendingRows at = pending.pop();
            if (is_node(at)) {
                open_node(culling, at, opened[count]);
            } else {
                opened[count].children[0] = at;
                opened[count].count = 1;
            }
        }
        // The last one goes first, to come out last.
        while (count-- > 0) {
            for (std::uint32_t i = opened[count].count; i-- > 0;)
                pending.push(opened[count].children[i]);
        }
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(cull);

bool is_row_visible(const Culling& culling, std::uint32_t row, PlaneMask mask) noexcept
{
    const Triangle triangle = culling.index.triangle(row);
    if (culling.mode == CullMode::exact) return meets_volume(culling.volume, triangle);
    bool passes = true;
    for_planes(culling.open, mask, [&](const FloatPlane& flat) {
        const ViewPlane& plane = culling.volume.planes()[flat.plane];
        passes = std::ranges::any_of(triangle.vertices, [&](const Vec3& corner) {
            return side_of_plane(plane, corner) >= 0;
        });
        return passes;
    });
    return passes;
}

void visit_visible(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                   FunctionRef<Flow(TriangleRange)> visitor) noexcept
{
    const IndexParts& parts = index.parts();
    VolumeTraversal open;
    RangeJoiner ranges(visitor);
    switch (prepare_volume(parts, volume, open)) {
    case VolumeStart::sees_nothing:
        return;
    case VolumeStart::sees_all:
        (void)ranges.add(0, parts.triangle_count());
        break;
    case VolumeStart::ready:
        HWY_DYNAMIC_DISPATCH(cull)({parts, volume, mode, open, ranges});
        break;
    }
    (void)ranges.flush();
}

} // namespace proxima

#endif
