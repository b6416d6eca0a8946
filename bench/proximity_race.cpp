#include "proximity_race.h"

#include "proxima/geometry/closest_point.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>

namespace proxima::bench {
namespace {

constexpr double tolerance = 1e-12; ///< of the diagonal

double processor_nanoseconds()
{
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

/// One contender on one set: what it is asked and what it said.
struct Entry {
    Contender* contender;
    QuerySample sample;
    std::vector<PeerAnswer> answers;
    SetResult result;
};

/// The mean time of a query, in nanoseconds, of one pass.
template <class Pass>
double mean_time(Entry& entry, Pass pass)
{
    const double start = processor_nanoseconds();
    pass(entry.sample.points, entry.answers);
    return (processor_nanoseconds() - start) / static_cast<double>(entry.sample.points.size());
}

void run_round(std::span<Entry> entries, std::size_t round)
{
    const auto each = [&](auto run) {
        for (std::size_t i = 0; i < entries.size(); ++i) run(entries[(i + round) % entries.size()]);
    };
    each([](Entry& entry) {
        entry.result.single.push_back(mean_time(entry, [&](auto& points, auto& answers) {
            entry.contender->answer_singly(points, answers);
        }));
    });
    each([](Entry& entry) {
        if (!entry.contender->takes_batches()) return;
        entry.result.batch.push_back(mean_time(entry, [&](auto& points, auto& answers) {
            entry.contender->answer_batch(points, answers);
        }));
    });
}

Tail tail_of(std::vector<double> nanoseconds)
{
    std::ranges::sort(nanoseconds);
    const auto rank = [&](double share) {
        const double place = std::ceil(share * static_cast<double>(nanoseconds.size()));
        return nanoseconds[static_cast<std::size_t>(std::max(place, 1.0)) - 1];
    };
    return {rank(0.5), rank(0.99), rank(0.9999), nanoseconds.back()};
}

void measure_tails(std::span<Entry> entries, int passes)
{
    if (passes == 0) return;
    const double overhead = clock_overhead();
    std::vector<std::vector<double>> least;
    for (const Entry& entry : entries)
        least.emplace_back(entry.sample.points.size(), std::numeric_limits<double>::infinity());
    for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t i = 0; i < entries.size(); ++i)
            entries[i].contender->time_each(entries[i].sample.points, overhead, least[i]);
    }
    for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i].result.tail = tail_of(std::move(least[i]));
}

/// Holds the answers of all contenders against the mesh and against each other.
void compare(const TriangleMesh& mesh, std::span<Entry> entries, std::size_t queries)
{
    const double diagonal = bounding_box(mesh).extent().norm();
    std::vector<double> best(queries, std::numeric_limits<double>::infinity());
    std::vector<std::vector<double>> true_distances;
    for (const Entry& entry : entries) {
        auto& distances = true_distances.emplace_back();
        for (std::size_t i = 0; i < entry.answers.size(); ++i) {
            const Vec3& point = entry.sample.points[i];
            const Triangle triangle = mesh.triangle(entry.answers[i].triangle);
            distances.push_back((closest_point(triangle, point).point - point).norm());
            double& least = best[entry.sample.places[i]];
            least = std::min(least, distances.back());
        }
    }
    for (std::size_t e = 0; e < entries.size(); ++e) {
        Entry& entry = entries[e];
        for (std::size_t i = 0; i < entry.answers.size(); ++i) {
            const auto& [squared, triangle] = entry.answers[i];
            const double distance = true_distances[e][i];
            const double off = std::max(std::abs(std::sqrt(squared) - distance),
                                        distance - best[entry.sample.places[i]]) /
                               diagonal;
            entry.result.deviation = std::max(entry.result.deviation, off);
            entry.result.wrong += off <= tolerance ? 0 : 1;
            entry.result.hash = (entry.result.hash ^ std::bit_cast<std::uint64_t>(squared) ^
                                 (std::uint64_t{index(triangle)} << 32U)) *
                                0x9E3779B97F4A7C15U;
        }
    }
}

} // namespace

std::vector<RaceResult> race(const TriangleMesh& mesh,
                             std::span<const std::unique_ptr<Contender>> contenders,
                             const std::array<QuerySet, 3>& sets, const RaceOptions& options)
{
    std::vector<RaceResult> results(contenders.size());
    std::array<std::vector<Entry>, 3> fields;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        for (const auto& contender : contenders) {
            QuerySample sample = sample_of(sets[s].points, contender->at_most);
            const std::size_t queries = sample.points.size();
            fields[s].push_back({contender.get(), std::move(sample),
                                 std::vector<PeerAnswer>(queries), SetResult{.queries = queries}});
        }
    }
    for (int round = 0; round < options.rounds; ++round)
        for (auto& field : fields) run_round(field, static_cast<std::size_t>(round));
    for (std::size_t s = 0; s < sets.size(); ++s) {
        measure_tails(fields[s], options.tail_passes);
        compare(mesh, fields[s], sets[s].points.size());
        for (std::size_t i = 0; i < results.size(); ++i)
            results[i].sets[s] = std::move(fields[s][i].result);
    }
    return results;
}

} // namespace proxima::bench
