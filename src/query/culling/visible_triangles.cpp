// What a view volume sees, as lists: of ranges, and of ids in order.
#include "proxima/cull.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace proxima {

std::size_t visible_ranges(const MeshIndex& index, const ViewVolume& volume,
                           std::span<TriangleRange> ranges, CullMode mode) noexcept
{
    std::size_t count = 0;
    visit_visible(index, volume, mode, [&](TriangleRange range) {
        if (count < ranges.size()) ranges[count] = range;
        ++count;
        return Flow::proceed;
    });
    return count;
}

void visible_triangles(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                       std::vector<TriangleId>& ids)
{
    std::vector<TriangleRange> ranges;
    std::size_t visible = 0;
    visit_visible(index, volume, mode, [&](TriangleRange range) {
        ranges.push_back(range);
        visible += range.count;
        return Flow::proceed;
    });
    ids.resize(visible);
    const std::uint32_t triangles = index.triangle_count();
    if (visible == triangles) {
        for (std::uint32_t i = 0; i < triangles; ++i) ids[i] = TriangleId{i};
        return;
    }
    // Ids are in order as bits. Of the visible rows or of the others, the fewer are looked at.
    const bool marks_hidden = visible > triangles / 2;
    constexpr std::uint32_t word = 64;
    std::vector<std::uint64_t> marks((triangles + word - 1) / word, marks_hidden ? ~0ULL : 0ULL);
    if (marks_hidden && triangles % word != 0) marks.back() = (1ULL << triangles % word) - 1;
    const auto turn = [&](std::uint32_t first, std::uint32_t end) {
        for (const TriangleId triangle : index.ids().subspan(first, end - first)) {
            const std::uint32_t id = to_index(triangle);
            marks[id / word] ^= 1ULL << id % word;
        }
    };
    std::uint32_t end = 0;
    for (const TriangleRange& range : ranges) {
        if (marks_hidden) {
            turn(end, range.first);
        } else {
            turn(range.first, range.first + range.count);
        }
        end = range.first + range.count;
    }
    if (marks_hidden) turn(end, triangles);
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < marks.size(); ++i) {
        for (std::uint64_t left = marks[i]; left != 0; left &= left - 1)
            ids[next++] = TriangleId{word * i + static_cast<std::uint32_t>(std::countr_zero(left))};
    }
}

std::vector<TriangleId> visible_triangles(const MeshIndex& index, const ViewVolume& volume,
                                          CullMode mode)
{
    std::vector<TriangleId> ids;
    visible_triangles(index, volume, mode, ids);
    return ids;
}

} // namespace proxima
