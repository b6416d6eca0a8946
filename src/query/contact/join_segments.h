// Segments joined to lines by the numbers of their ends. Internal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// The numbers of the two points that a segment joins.
using SegmentEnds = std::array<std::uint32_t, 2>;

/// The points along a line; a closed one does not repeat its first.
struct JoinedLine {
    std::vector<std::uint32_t> points;
    bool closed = false;
};

/// Every segment (each once, however often it comes) in one line, and every point without a segment
/// alone. Open lines begin and end where an odd number of segments meet, all others are closed.
/// Where more than two meet, a line goes on along the one to the lowest point. O(n log n).
[[nodiscard]] std::vector<JoinedLine> join_segments(std::size_t point_count,
                                                    std::vector<SegmentEnds> segments);

} // namespace proxima
