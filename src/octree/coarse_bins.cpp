#include "octree/coarse_bins.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>

namespace proxima {

namespace {

constexpr int max_chosen_depth = 6;

/// The lowest coarse cell of a triangle's box, and which of the eight cells from there on it
/// touches. A triangle over more than two cells on an axis touches none here and is listed apart.
struct Coverage {
    std::array<std::uint8_t, 3> lower = {};
    std::uint8_t touched = 0;
};

/// One (triangle, coarse cell) pair of a triangle that spans many cells.
struct WidePair {
    std::uint32_t triangle = 0;
    std::uint32_t cell = 0;
};

/// Octants of a 2 x 2 x 2 block that exist where `steps` (x | y << 8 | z << 16, each 0 or 1) says
/// whether the box reaches the second cell.
std::uint8_t allowed_octants(std::uint32_t steps) noexcept
{
    unsigned octants = 0xFF;
    if ((steps & 0x1U) == 0) octants &= 0x55U;
    if ((steps & 0x100U) == 0) octants &= 0x33U;
    if ((steps & 0x10000U) == 0) octants &= 0x0FU;
    return static_cast<std::uint8_t>(octants);
}

/// Bits of a coarse coordinate moved to every third position.
constexpr auto spread_bits = [] {
    std::array<std::uint32_t, 1U << max_bin_depth> table{};
    for (std::uint32_t value = 0; value < table.size(); ++value) {
        for (std::uint32_t bit = 0; bit < max_bin_depth; ++bit) {
            table[value] |= (value >> bit & 1U) << (3 * bit);
        }
    }
    return table;
}();

/// Morton index of a coarse cell.
std::uint32_t morton(std::uint32_t x, std::uint32_t y, std::uint32_t z) noexcept
{
    return spread_bits[x] | spread_bits[y] << 1U | spread_bits[z] << 2U;
}

/// Bins a contiguous range of triangles.
class RangeBinner {
public:
    /// `wide_pairs` counts those of all ranges.
    RangeBinner(const SnappedMesh& mesh, int depth, std::uint32_t begin, std::uint32_t end,
                std::atomic<std::uint64_t>& wide_pairs, std::uint64_t most_wide_pairs,
                Progress* progress)
        : mesh_(mesh), depth_(depth), begin_(begin), end_(end), all_wide_pairs_(wide_pairs),
          most_wide_pairs_(most_wide_pairs), progress_(progress)
    {}

    /// Finds which cells every triangle of the range touches. False where wide triangles have more
    /// pairs than may be.
    bool cover(Coverage* coverages)
    {
        coverages_ = coverages;
        wide_triangles_.clear();
        std::array<std::uint32_t, block_size + lane_padding> lowest;
        std::array<std::uint32_t, block_size + lane_padding> highest;
        for (std::uint32_t first = begin_; first < end_; first += block_size) {
            const std::uint32_t count = std::min<std::uint32_t>(block_size, end_ - first);
            find_cells_of_boxes(mesh_.arrays(), first, count, depth_, mesh_.margin(), lowest.data(),
                                highest.data());
            for (std::uint32_t i = 0; i < count; ++i) cover_one(first + i, lowest[i], highest[i]);
            advance_stage(progress_, count);
            if (is_cancelled(progress_)) break;
        }
        flush_block();
        return descend_wide_triangles();
    }

    /// Calls visit(triangle, cell) for every pair, triangles ascending.
    template <class Visitor>
    void visit_pairs(const Visitor& visit) const
    {
        auto wide = wide_pairs_.begin();
        for (std::uint32_t triangle = begin_; triangle < end_; ++triangle) {
            if ((triangle - begin_) % block_size == 0 && is_cancelled(progress_)) return;
            const Coverage& coverage = coverages_[triangle];
            for (std::uint32_t octants = coverage.touched; octants != 0; octants &= octants - 1) {
                const auto octant = static_cast<std::uint32_t>(std::countr_zero(octants));
                visit(triangle, morton(coverage.lower[0] + (octant & 1U),
                                       coverage.lower[1] + (octant >> 1U & 1U),
                                       coverage.lower[2] + (octant >> 2U)));
            }
            for (; wide != wide_pairs_.end() && wide->triangle == triangle; ++wide) {
                visit(triangle, wide->cell);
            }
        }
    }

private:
    static constexpr std::uint32_t block_size = 512;

    void cover_one(std::uint32_t triangle, std::uint32_t lowest, std::uint32_t highest)
    {
        Coverage& coverage = coverages_[triangle];
        for (unsigned axis = 0; axis < 3; ++axis) {
            coverage.lower[axis] = static_cast<std::uint8_t>(lowest >> (8 * axis));
        }
        const std::uint32_t steps = highest - lowest; // no axis borrows from the next
        if ((steps & ~0x10101U) != 0) {
            coverage.touched = 0;
            wide_triangles_.push_back(triangle);
            return;
        }
        coverage.touched = allowed_octants(steps);
        if (steps != 0) add_to_block(triangle, coverage);
    }

    /// Around the 2 x 2 x 2 cells of its box lies a cell that need not be one of the octree: the
    /// test for children serves all the same.
    void add_to_block(std::uint32_t triangle, const Coverage& coverage)
    {
        block_ids_[block_count_] = triangle;
        block_index_[block_count_] = static_cast<std::uint32_t>(block_count_);
        block_allowed_[block_count_] = coverage.touched;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            block_center_[axis][block_count_] = (coverage.lower[axis] + 1)
                                                << (snapped_bits - depth_);
        }
        if (++block_count_ == block_size) flush_block();
    }

    void flush_block()
    {
        mesh_.load({block_ids_.data(), block_count_}, {}, blocks_);
        const PairLevel level{
            .pairs = {block_index_.data(),
                      {block_center_[0].data(), block_center_[1].data(), block_center_[2].data()},
                      block_count_},
            .half = 1 << (snapped_bits - depth_),
            .child_depth = depth_,
            .allowed = block_allowed_.data()};
        mesh_.find_touched(blocks_, level, scratch_, block_masks_.data());
        for (std::size_t i = 0; i < block_count_; ++i) {
            coverages_[block_ids_[i]].touched = static_cast<std::uint8_t>(block_masks_[i]);
        }
        block_count_ = 0;
    }

    /// Triangles over many cells descend from the root. A triangle that touches a cell touches a
    /// child, so that pairs never become fewer.
    bool descend_wide_triangles()
    {
        LocalTriangles local;
        mesh_.load(wide_triangles_, {}, local);
        struct Pairs {
            GrowBuffer<std::uint32_t> triangle;
            std::array<GrowBuffer<std::int32_t>, 3> center;
            void resize(std::size_t count)
            {
                triangle.resize(count + lane_padding);
                std::fill_n(triangle.data() + count, lane_padding, 0U);
                for (auto& axis : center) axis.resize(count + lane_padding);
            }
        };
        Pairs current;
        Pairs next;
        GrowBuffer<std::uint32_t> masks;
        std::size_t count = wide_triangles_.size();
        std::int32_t half = 1 << (snapped_bits - 1);
        current.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            current.triangle[i] = static_cast<std::uint32_t>(i);
            for (auto& axis : current.center) axis[i] = half;
        }
        for (int depth = 1; depth <= depth_ && count != 0; ++depth, half /= 2) {
            masks.resize(count + lane_padding);
            const PairLevel level{.pairs = {current.triangle.data(),
                                            {current.center[0].data(), current.center[1].data(),
                                             current.center[2].data()},
                                            count},
                                  .half = half,
                                  .child_depth = depth};
            mesh_.find_touched(local, level, scratch_, masks.data());
            std::size_t child_count = 0;
            for (std::size_t i = 0; i < count; ++i) {
                child_count += static_cast<std::size_t>(std::popcount(masks[i]));
            }
            const std::uint64_t added = child_count - (depth == 1 ? 0 : count);
            if ((all_wide_pairs_ += added) > most_wide_pairs_) return false;
            if (is_cancelled(progress_)) return true;
            next.resize(child_count);
            std::size_t out = 0;
            for (std::size_t i = 0; i < count; ++i) {
                for (std::uint32_t octants = masks[i]; octants != 0; octants &= octants - 1) {
                    const auto octant = static_cast<unsigned>(std::countr_zero(octants));
                    next.triangle[out] = current.triangle[i];
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        const bool upper = (octant >> axis & 1U) != 0;
                        next.center[axis][out] =
                            current.center[axis][i] + (upper ? half / 2 : -half / 2);
                    }
                    ++out;
                }
            }
            std::swap(current, next);
            count = child_count;
        }
        // Each level kept the triangles' order.
        wide_pairs_.resize(count);
        const int shift = snapped_bits - depth_;
        for (std::size_t i = 0; i < count; ++i) {
            const auto coordinate = [&](std::size_t axis) {
                return static_cast<std::uint32_t>(current.center[axis][i] >> shift);
            };
            wide_pairs_[i] = {wide_triangles_[current.triangle[i]],
                              morton(coordinate(0), coordinate(1), coordinate(2))};
        }
        return true;
    }

    const SnappedMesh& mesh_;
    int depth_;
    std::uint32_t begin_;
    std::uint32_t end_;
    std::atomic<std::uint64_t>& all_wide_pairs_;
    std::uint64_t most_wide_pairs_;
    Progress* progress_;
    Coverage* coverages_ = nullptr;
    LocalTriangles blocks_;
    std::size_t block_count_ = 0;
    std::array<std::uint32_t, block_size> block_ids_ = {};
    std::array<std::uint32_t, block_size + lane_padding> block_index_ = {};
    std::array<std::array<std::int32_t, block_size + lane_padding>, 3> block_center_ = {};
    std::array<std::uint32_t, block_size + lane_padding> block_masks_ = {};
    std::array<std::uint8_t, block_size> block_allowed_ = {};
    SnappedScratch scratch_;
    std::vector<std::uint32_t> wide_triangles_;
    std::vector<WidePair> wide_pairs_;
};

tl::unexpected<Error> too_many_pairs(int depth)
{
    return fail(ErrorCode::limit_exceeded,
                concat("the triangles touch cells of depth ", depth,
                       " more than 2^32 times in one process: lower the depth below ", depth,
                       " (in proxima-mpi, --routing-depth is enough), or use more processes of "
                       "proxima-mpi"));
}

} // namespace

int choose_bin_depth(const SnappedMesh& mesh, int max_depth)
{
    const std::size_t count = mesh.mesh().triangle_count();
    const double by_count = std::round(std::log2(static_cast<double>(count) / 64.0) / 2) - 2;
    int depth = std::clamp(static_cast<int>(by_count), 0, std::min(max_chosen_depth, max_depth));
    // Nine of ten sampled triangles should fit a cell.
    constexpr std::size_t sample_count = 1024;
    const std::size_t step = std::max<std::size_t>(1, count / sample_count);
    std::array<std::size_t, snapped_bits + 2> by_width = {};
    std::size_t samples = 0;
    for (std::size_t triangle = 0; triangle < count; triangle += step, ++samples) {
        const TriangleCorners& corners = mesh.mesh().triangles()[triangle];
        std::int32_t extent = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto a = mesh.vertex(corners[0])[axis];
            const auto b = mesh.vertex(corners[1])[axis];
            const auto c = mesh.vertex(corners[2])[axis];
            extent = std::max(extent, std::max({a, b, c}) - std::min({a, b, c}));
        }
        ++by_width[static_cast<std::size_t>(std::bit_width(static_cast<std::uint32_t>(extent)))];
    }
    std::size_t larger = 0;
    for (int width = snapped_bits + 1; width > 0; --width) {
        larger += by_width[static_cast<std::size_t>(width)];
        if (10 * larger > samples) {
            depth = std::min(depth, std::max(0, snapped_bits - width));
            break;
        }
    }
    // Where the grid is coarse against a cell, boxes would spread over all of them.
    while (depth > 0 && mesh.margin() > (1 << (snapped_bits - depth)) / 1024) --depth;
    return depth;
}

CoverageSum sum_coverage(const SnappedMesh& mesh)
{
    constexpr std::size_t sample_count = std::size_t{1} << 16U;
    const auto triangles = mesh.mesh().triangles();
    const std::size_t step = triangles.size() / sample_count | 1U; // meshes often repeat in pairs
    CoverageSum sum;
    for (std::size_t i = 0; i < triangles.size(); i += step) {
        const auto& a = mesh.vertex(triangles[i][0]);
        const auto& b = mesh.vertex(triangles[i][1]);
        const auto& c = mesh.vertex(triangles[i][2]);
        std::array<double, 3> ab{};
        std::array<double, 3> ac{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            ab[axis] = b[axis] - a[axis];
            ac[axis] = c[axis] - a[axis];
            sum.widths +=
                std::max({a[axis], b[axis], c[axis]}) - std::min({a[axis], b[axis], c[axis]});
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t next = (axis + 1) % 3;
            const std::size_t last = (axis + 2) % 3;
            sum.areas += std::abs(ab[next] * ac[last] - ab[last] * ac[next]) / 2;
        }
    }
    const std::size_t samples = (triangles.size() + step - 1) / step;
    const auto count = static_cast<double>(triangles.size());
    const double weight = samples == 0 ? 0 : count / static_cast<double>(samples);
    const double scale = std::ldexp(1.0, -snapped_bits);
    return {count, weight * scale * sum.widths, weight * scale * scale * sum.areas};
}

Result<CoarseBins> bin_triangles(const SnappedMesh& mesh, int depth, Threads threads,
                                 Progress* progress, std::uint64_t most_pairs,
                                 std::uint64_t most_wide_pairs)
{
    const auto count = static_cast<std::uint32_t>(mesh.mesh().triangle_count());
    CoarseBins bins;
    bins.depth = depth;
    const std::size_t cells = std::size_t{1} << (3 * depth);
    bins.first.assign(cells + 1, 0);
    if (depth == 0) {
        bins.first[1] = count;
        bins.ids.resize(count);
        for (std::uint32_t triangle = 0; triangle < count; ++triangle)
            bins.ids[triangle] = triangle;
        return bins;
    }
    const std::size_t ranges =
        thread_count(threads) == 1
            ? 1
            : std::min<std::size_t>(static_cast<std::size_t>(thread_count(threads)) * 2,
                                    1 + count / 4096);
    std::vector<RangeBinner> binners;
    std::atomic<std::uint64_t> wide_pairs{0};
    for (std::size_t range = 0; range < ranges; ++range) {
        const auto bound = [&](std::size_t index) {
            return static_cast<std::uint32_t>(std::uint64_t{count} * index / ranges);
        };
        binners.emplace_back(mesh, depth, bound(range), bound(range + 1), wide_pairs,
                             std::min(most_pairs, most_wide_pairs), progress);
    }
    GrowBuffer<Coverage> coverages;
    coverages.resize(count);
    std::vector<std::vector<std::uint32_t>> starts(ranges);
    std::atomic<std::uint64_t> pair_count{0};
    parallel_for(ranges, threads, [&](std::size_t range) {
        if (!binners[range].cover(coverages.data())) {
            pair_count += most_pairs + 1;
            return;
        }
        starts[range].assign(cells, 0);
        std::uint64_t pairs_here = 0;
        binners[range].visit_pairs([&](std::uint32_t, std::uint32_t cell) {
            ++starts[range][cell];
            ++pairs_here;
        });
        pair_count += pairs_here;
    });
    if (pair_count > most_pairs) return too_many_pairs(depth);
    if (is_cancelled(progress)) return bins;
    // Counts become starts: cells in order, and within a cell the ranges in order.
    std::uint32_t total = 0;
    for (std::size_t cell = 0; cell < cells; ++cell) {
        bins.first[cell] = total;
        for (auto& range_starts : starts) {
            const std::uint32_t pairs = range_starts[cell];
            range_starts[cell] = total;
            total += pairs;
        }
    }
    bins.first[cells] = total;
    bins.ids.resize(total);
    parallel_for(ranges, threads, [&](std::size_t range) {
        binners[range].visit_pairs([&](std::uint32_t triangle, std::uint32_t cell) {
            bins.ids[starts[range][cell]++] = triangle;
        });
        advance_stage(progress, count / ranges);
    });
    return bins;
}

Result<CoarseBins> bin_triangles_within(std::uint64_t most_bytes, const SnappedMesh& mesh,
                                        int depth, Threads threads, Progress* progress)
{
    // Wide pairs are found in two levels of triangle and centre and a mask, and kept; then come ids.
    constexpr std::uint64_t finding = 2 * (4 * sizeof(std::uint32_t)) + sizeof(std::uint32_t);
    const std::uint64_t most_wide_pairs = most_bytes / (finding + sizeof(WidePair));
    const std::uint64_t kept = most_wide_pairs * sizeof(WidePair);
    const std::uint64_t count = mesh.mesh().triangle_count();
    const std::uint64_t most_pairs =
        std::min<std::uint64_t>(count + (most_bytes - kept) / sizeof(std::uint32_t),
                                std::numeric_limits<std::uint32_t>::max());
    for (;; --depth) {
        auto bins = bin_triangles(mesh, depth, threads, progress, most_pairs, most_wide_pairs);
        if (bins || depth == 0) return bins;
        begin_stage(progress, "snapping", 2 * count);
    }
}

} // namespace proxima
