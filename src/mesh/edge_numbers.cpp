#include "mesh/edge_numbers.h"

#include "base/grow_buffer.h"
#include "base/parallel.h"
#include "base/progress.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <span>
#include <utility>

namespace proxima {

namespace {

using Side = std::uint32_t;
constexpr Side no_side = std::numeric_limits<Side>::max();

constexpr std::size_t most_chunks = 64; // not by the number of threads: the same work for any
constexpr std::size_t least_chunk = 16384;
constexpr unsigned bucket_bits = 10;
constexpr std::uint64_t stages = 4;

struct SideEnds {
    std::uint32_t low;
    std::uint32_t high;
};

SideEnds ends_of(std::uint32_t a, std::uint32_t b) noexcept
{
    return {std::min(a, b), std::max(a, b)};
}

/// Finds the lowest side of the same edge, for all sides with the same lower vertex.
class SideMatcher {
public:
    struct HighEnd {
        std::uint32_t high;
        Side side;
        friend bool operator<(const HighEnd& a, const HighEnd& b) noexcept
        {
            return a.high != b.high ? a.high < b.high : a.side < b.side;
        }
    };

    explicit SideMatcher(std::span<Side> first_sides) : first_sides_(first_sides) {}

    /// \pre the sides are ascending
    void match(std::span<HighEnd> sides) noexcept
    {
        constexpr std::size_t short_list = 24;
        if (sides.size() <= short_list) {
            search_short(sides);
        } else {
            search_sorted(sides);
        }
    }

private:
    void search_short(std::span<const HighEnd> sides) noexcept
    {
        for (const HighEnd& each : sides) {
            const auto first = std::ranges::find(sides, each.high, &HighEnd::high);
            first_sides_[each.side] = first->side;
        }
    }

    void search_sorted(std::span<HighEnd> sides) noexcept
    {
        std::ranges::sort(sides, std::less<>());
        HighEnd first = sides.front();
        for (const HighEnd& each : sides) {
            if (each.high != first.high) first = each;
            first_sides_[each.side] = first.side;
        }
    }

    std::span<Side> first_sides_;
};

/// At most 2^bucket_bits buckets, and no fewer vertices than that in each of several.
unsigned bucket_shift(std::size_t vertices) noexcept
{
    const auto bits = static_cast<unsigned>(std::bit_width(vertices));
    return bits > 2 * bucket_bits ? bits - bucket_bits : bucket_bits;
}

// The steps of number_edges, in the order of their calls there.
class EdgeNumberer {
public:
    EdgeNumberer(const TriangleMesh& mesh, Threads threads)
        : triangles_(mesh.triangles()), threads_(threads),
          per_chunk_(std::max(least_chunk, (triangles_.size() + most_chunks - 1) / most_chunks)),
          chunks_((triangles_.size() + per_chunk_ - 1) / per_chunk_),
          shift_(bucket_shift(mesh.vertex_count())), buckets_((mesh.vertex_count() >> shift_) + 1)
    {}

    /// Sorts the sides into buckets of neighbouring lower vertices, ascending in each.
    void fill_buckets()
    {
        first_sides_.resize(3 * triangles_.size());
        std::vector<std::uint32_t> starts(chunks_ * buckets_, 0);
        parallel_for(chunks_, threads_, [&](std::size_t chunk) {
            std::uint32_t* const counts = &starts[chunk * buckets_];
            for_sides(chunk, [&](Side side, const SideEnds& ends) {
                if (ends.low == ends.high) {
                    first_sides_[side] = no_side;
                } else {
                    ++counts[ends.low >> shift_];
                }
            });
        });
        bucket_starts_.assign(buckets_ + 1, 0);
        std::uint32_t total = 0;
        for (std::size_t bucket = 0; bucket < buckets_; ++bucket) {
            bucket_starts_[bucket] = total;
            for (std::size_t chunk = 0; chunk < chunks_; ++chunk)
                total += std::exchange(starts[chunk * buckets_ + bucket], total);
        }
        bucket_starts_[buckets_] = total;
        sides_.resize(total);
        parallel_for(chunks_, threads_, [&](std::size_t chunk) {
            std::uint32_t* const places = &starts[chunk * buckets_];
            for_sides(chunk, [&](Side side, const SideEnds& ends) {
                if (ends.low != ends.high) sides_[places[ends.low >> shift_]++] = side;
            });
        });
    }

    void match_sides()
    {
        parallel_for(buckets_, threads_, [&](std::size_t bucket) {
            const std::span<const Side> sides = sides_.span().subspan(
                bucket_starts_[bucket], bucket_starts_[bucket + 1] - bucket_starts_[bucket]);
            const std::uint32_t mask = (1U << shift_) - 1;
            std::vector<std::uint32_t> starts(std::size_t{mask} + 2, 0);
            std::vector<SideEnds> ends(sides.size());
            for (std::size_t i = 0; i < sides.size(); ++i) {
                ends[i] = ends_of(sides[i]);
                ++starts[(ends[i].low & mask) + 1];
            }
            for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
            std::vector<SideMatcher::HighEnd> sorted(sides.size());
            for (std::size_t i = 0; i < sides.size(); ++i)
                sorted[starts[ends[i].low & mask]++] = {ends[i].high, sides[i]};
            SideMatcher matcher(first_sides_.span());
            std::uint32_t first = 0;
            for (std::size_t vertex = 0; vertex <= mask; ++vertex) {
                const std::uint32_t end = starts[vertex];
                if (end > first) matcher.match(std::span(sorted).subspan(first, end - first));
                first = end;
            }
        });
        sides_ = {};
    }

    /// Edges get their numbers where their first side stands.
    void number()
    {
        std::vector<std::uint32_t> first_edge(chunks_ + 1, 0);
        parallel_for(chunks_, threads_, [&](std::size_t chunk) {
            std::uint32_t count = 0;
            for_chunk(chunk, [&](Side side) { count += first_sides_[side] == side ? 1U : 0U; });
            first_edge[chunk + 1] = count;
        });
        for (std::size_t chunk = 0; chunk < chunks_; ++chunk)
            first_edge[chunk + 1] += first_edge[chunk];
        numbers_.first_sides.resize(first_edge.back());
        numbers_.triangle_edges.resize(triangles_.size());
        parallel_for(chunks_, threads_, [&](std::size_t chunk) {
            const auto begin = static_cast<Side>(3 * chunk * per_chunk_);
            std::uint32_t next = first_edge[chunk];
            for_chunk(chunk, [&](Side side) {
                const Side first = first_sides_[side];
                if (first == side) {
                    numbers_.first_sides[next] = side;
                    edge_of(side) = EdgeId{next++};
                } else if (first >= begin) { // numbered before, in this chunk
                    edge_of(side) = first == no_side ? no_edge : edge_of(first);
                }
            });
        });
        parallel_for(chunks_, threads_, [&](std::size_t chunk) {
            const auto begin = static_cast<Side>(3 * chunk * per_chunk_);
            for_chunk(chunk, [&](Side side) {
                const Side first = first_sides_[side];
                if (first < begin) edge_of(side) = edge_of(first);
            });
        });
    }

    EdgeNumbers result() { return std::move(numbers_); }

private:
    template <class Visit>
    void for_chunk(std::size_t chunk, const Visit& visit) const
    {
        const std::size_t end = std::min(triangles_.size(), (chunk + 1) * per_chunk_);
        for (std::size_t side = 3 * chunk * per_chunk_; side < 3 * end; ++side)
            visit(static_cast<Side>(side));
    }
    template <class Visit>
    void for_sides(std::size_t chunk, const Visit& visit) const
    {
        const std::size_t end = std::min(triangles_.size(), (chunk + 1) * per_chunk_);
        for (std::size_t triangle = chunk * per_chunk_; triangle < end; ++triangle) {
            const auto [a, b, c] = triangles_[triangle];
            const auto side = static_cast<Side>(3 * triangle);
            visit(side, proxima::ends_of(a, b));
            visit(side + 1, proxima::ends_of(b, c));
            visit(side + 2, proxima::ends_of(c, a));
        }
    }
    [[nodiscard]] SideEnds ends_of(Side side) const noexcept
    {
        const TriangleCorners& corners = triangles_[side / 3];
        const std::size_t corner = side % 3;
        return proxima::ends_of(corners[corner], corners[corner == 2 ? 0 : corner + 1]);
    }
    [[nodiscard]] EdgeId& edge_of(Side side) noexcept
    {
        return numbers_.triangle_edges[side / 3][side % 3];
    }

    std::span<const TriangleCorners> triangles_;
    Threads threads_;
    std::size_t per_chunk_;
    std::size_t chunks_;
    unsigned shift_; ///< of a vertex's number, to its bucket
    std::size_t buckets_;
    GrowBuffer<Side> first_sides_; ///< by side: the lowest of the same edge
    std::vector<std::uint32_t> bucket_starts_;
    GrowBuffer<Side> sides_; ///< by bucket, ascending in each
    EdgeNumbers numbers_;
};

} // namespace

Result<EdgeNumbers> number_edges(const TriangleMesh& mesh, Threads threads, Progress* progress)
{
    begin_stage(progress, "numbering edges", stages);
    const auto stopped = [&] {
        advance_stage(progress, 1);
        return is_cancelled(progress);
    };
    const auto cancelled = [] { return fail(ErrorCode::cancelled, "edges: stopped on request"); };
    EdgeNumberer numberer(mesh, threads);
    if (stopped()) return cancelled();
    numberer.fill_buckets();
    if (stopped()) return cancelled();
    numberer.match_sides();
    if (stopped()) return cancelled();
    numberer.number();
    return numberer.result();
}

} // namespace proxima
