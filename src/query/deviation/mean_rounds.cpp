#include "query/deviation/mean_rounds.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// From so many on, parts tell how to share the work. Groups of parts or triangles are no more: each has
/// a histogram.
constexpr std::size_t most_groups = 1024;
/// So many parts may the first round leave, and each group what one triangle leaves beyond its share of them.
constexpr std::size_t most_shared_parts = std::size_t{1} << 16U;

struct Group {
    MeanSums sums;
    std::vector<MeanPart> left;
    double spare = 0;
};

class MeanRounds {
public:
    MeanRounds(const SurfacePair& pair, const MeasuredVertices& vertices,
               const MeanDeviationOptions& options, double tolerance, double root)
        : pair_(pair), vertices_(vertices), options_(options), tolerance_(tolerance), root_(root),
          empty_(options.histogram_bins, pair.to_units(options.histogram_end)), sums_(empty_)
    {}

    Result<MeanSums> run(std::uint64_t max_splits)
    {
        const std::size_t count = pair_.a().triangle_count();
        // Neighbours hand on what they leave of their tolerance.
        const std::size_t size = std::max<std::size_t>(16, chunk_count(count, most_groups));
        if (Status status = plan_memory(chunk_count(count, size)); !status)
            return tl::unexpected(status.error());
        const std::size_t shared = is_shared_ ? most_shared_parts / chunk_count(count, size) : 0;
        begin_stage(progress(), "mean deviation", count);
        round(count, size, std::max<std::uint64_t>(max_splits / count, 64) * size,
              [&](std::size_t row, MeanSearch& search, Group& group) {
                  search.add_triangle(static_cast<std::uint32_t>(row), group.sums,
                                      group.left.size() < shared ? &group.left : nullptr);
              });
        while (!parts_.empty() && !is_cancelled(progress())) {
            const std::vector<MeanPart> parts = std::exchange(parts_, {});
            const bool is_enough = parts.size() >= most_groups;
            const std::size_t each = chunk_count(parts.size(), most_groups);
            const std::uint64_t splits = max_splits > sums_.splits ? max_splits - sums_.splits : 0;
            begin_stage(progress(), "parts of large triangles", parts.size());
            round(parts.size(), each, splits / chunk_count(parts.size(), each),
                  [&](std::size_t i, MeanSearch& search, Group& group) {
                      search.add_part(parts[i], group.sums, is_enough ? nullptr : &group.left);
                  });
        }
        if (is_cancelled(progress())) return cancelled("measuring the mean deviation");
        return sums_;
    }

private:
    [[nodiscard]] Progress* progress() const noexcept { return options_.execution.progress; }

    /// Neither the bytes of a search nor what it finds depend on the number of threads.
    Status plan_memory(std::size_t groups)
    {
        const std::uint64_t fixed =
            pair_.bytes() + bytes_of_groups(std::max(groups, std::size_t{1}));
        if (Status status = check_budget(options_.execution.budget, fixed + MeanSearch::least_bytes,
                                         "measuring the mean deviation", "raise the budget");
            !status)
            return status;
        std::uint64_t left = budget_bytes(options_.execution.budget) - fixed;
        // Lists that grow take three times their size.
        constexpr std::uint64_t shared_bytes =
            3 * sizeof(MeanPart) * (most_shared_parts + most_groups * MeanSearch::most_left);
        const std::uint64_t more_groups =
            bytes_of_groups(most_groups) - bytes_of_groups(std::min(groups, most_groups));
        is_shared_ = left / 4 >= shared_bytes + more_groups;
        if (is_shared_) left -= shared_bytes + more_groups;
        bytes_ = std::min(left, MeanSearch::most_bytes);
        threads_ = at_most(options_.execution.threads, left / bytes_);
        return {};
    }

    [[nodiscard]] std::uint64_t bytes_of_groups(std::size_t groups) const noexcept
    {
        return groups * (sizeof(Group) + options_.histogram_bins * sizeof(double));
    }

    /// Adds so many items in groups of `size`; what these leave is parts_.
    template <class Add>
    void round(std::size_t count, std::size_t size, std::uint64_t splits, const Add& add)
    {
        std::vector<Group> groups(chunk_count(count, size), {MeanSums(empty_), {}, 0});
        const double spare = spare_;
        parallel_chunks(count, size, threads_, [&](std::size_t first, std::size_t end) {
            MeanSearch search(pair_, vertices_,
                              {.tolerance = tolerance_,
                               .root = root_,
                               .spare = spare,
                               .most_splits = splits,
                               .bytes = bytes_},
                              progress());
            Group& group = groups[first / size];
            for (std::size_t i = first; i < end; ++i) {
                if (is_cancelled(progress())) return;
                add(i, search, group);
            }
            group.spare = search.spare();
            advance_stage(progress(), end - first);
        });
        double spares = 0;
        LongSum area;
        for (const Group& group : groups) {
            sums_.add(group.sums);
            spares += group.spare;
            for (const MeanPart& part : group.left) {
                area.add(area_of(pair_.a().triangle(part.row)) * part.part.weight);
                parts_.push_back(part);
            }
        }
        spare_ = area.value() > 0 ? std::max(spares, 0.0) / area.value() : 0;
    }

    const SurfacePair& pair_;
    const MeasuredVertices& vertices_;
    const MeanDeviationOptions& options_;
    double tolerance_;
    double root_;
    AreaHistogram empty_;
    MeanSums sums_;
    std::vector<MeanPart> parts_; ///< left to further rounds
    double spare_ = 0;            ///< of their tolerance that others left to them, as a distance
    bool is_shared_ = false;      ///< whether there is memory for parts
    std::uint64_t bytes_ = 0;     ///< of a search
    Threads threads_;
};

} // namespace

Result<MeanSums> sum_means(const SurfacePair& pair, const MeasuredVertices& vertices,
                           const MeanDeviationOptions& options, double tolerance, double root,
                           std::uint64_t max_splits)
{
    return MeanRounds(pair, vertices, options, tolerance, root).run(max_splits);
}

} // namespace proxima
