#include "query/contact/join_segments.h"

#include <algorithm>

namespace proxima {
namespace {

class Joiner {
public:
    Joiner(std::size_t point_count, std::vector<SegmentEnds> segments)
        : segments_(std::move(segments))
    {
        for (SegmentEnds& ends : segments_) std::ranges::sort(ends);
        std::erase_if(segments_, [](const SegmentEnds& ends) { return ends[0] == ends[1]; });
        std::ranges::sort(segments_);
        segments_.erase(std::unique(segments_.begin(), segments_.end()), segments_.end());
        used_.resize(segments_.size());
        // The segments at each point, in the order of their other ends.
        first_.resize(point_count + 1);
        for (const SegmentEnds& ends : segments_) {
            for (const std::uint32_t end : ends) ++first_[end + 1];
        }
        for (std::size_t i = 0; i < point_count; ++i) first_[i + 1] += first_[i];
        at_point_.resize(2 * segments_.size());
        next_ = first_;
        for (const int side : {1, 0}) {
            for (std::uint32_t i = 0; i < segments_.size(); ++i)
                at_point_[next_[segments_[i][static_cast<std::size_t>(side)]]++] = i;
        }
        next_ = first_;
        unused_.resize(point_count);
    }

    [[nodiscard]] std::vector<JoinedLine> lines()
    {
        const auto points = static_cast<std::uint32_t>(first_.size() - 1);
        for (std::uint32_t point = 0; point < points; ++point) {
            unused_[point] = first_[point + 1] - first_[point];
            if (unused_[point] == 0) lines_.push_back({{point}, false});
        }
        for (std::uint32_t point = 0; point < points; ++point) {
            while (unused_[point] % 2 != 0) walk(point);
        }
        for (std::uint32_t point = 0; point < points; ++point) {
            while (unused_[point] != 0) walk(point);
        }
        return std::move(lines_);
    }

private:
    /// Of the segments at a point with unused ones.
    [[nodiscard]] std::uint32_t next_unused(std::uint32_t point)
    {
        std::uint32_t& next = next_[point];
        while (used_[at_point_[next]]) ++next;
        return at_point_[next];
    }

    /// Until it comes back or can go no farther.
    void walk(std::uint32_t start)
    {
        JoinedLine line{{start}, false};
        std::uint32_t here = start;
        while (unused_[here] != 0 && !line.closed) {
            const std::uint32_t segment = next_unused(here);
            const SegmentEnds& ends = segments_[segment];
            used_[segment] = true;
            for (const std::uint32_t end : ends) --unused_[end];
            here = ends[0] == here ? ends[1] : ends[0];
            line.closed = here == start;
            if (!line.closed) line.points.push_back(here);
        }
        lines_.push_back(std::move(line));
    }

    std::vector<SegmentEnds> segments_;
    std::vector<bool> used_;
    std::vector<std::uint32_t> first_; ///< point p's: at_point_[first_[p]] to [first_[p + 1] - 1]
    std::vector<std::uint32_t> at_point_;
    std::vector<std::uint32_t> next_;   ///< the ones before are used
    std::vector<std::uint32_t> unused_; ///< how many segments at each point
    std::vector<JoinedLine> lines_;
};

} // namespace

std::vector<JoinedLine> join_segments(std::size_t point_count, std::vector<SegmentEnds> segments)
{
    return Joiner(point_count, std::move(segments)).lines();
}

} // namespace proxima
