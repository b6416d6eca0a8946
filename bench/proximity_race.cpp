#include "proximity_race.h"

#include "geometry/closest_point.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace proxima::bench {
namespace {

/// One contender on one set: what it is asked and what it said.
struct Entry {
    Contender* contender = nullptr;
    QuerySample sample; ///< empty where it is asked the whole set
    std::span<const Vec3> points;
    std::vector<PeerAnswer> single;
    std::vector<PeerAnswer> batch; ///< empty where the contender takes no batches
    SetResult result;
};

Entry make_entry(Contender& contender, const QuerySet& set)
{
    Entry entry;
    entry.contender = &contender;
    entry.points = set.points;
    if (contender.at_most != 0 && contender.at_most < set.points.size()) {
        entry.sample = sample_of(set.points, contender.at_most);
        entry.points = entry.sample.points;
    }
    entry.single.resize(entry.points.size());
    if (contender.takes_batches()) entry.batch.resize(entry.points.size());
    entry.result.queries = entry.points.size();
    return entry;
}

/// The mean time of a query of one pass, in nanoseconds.
template <class Pass>
double mean_time(const Entry& entry, Pass pass)
{
    const double start = processor_seconds();
    pass();
    return 1e9 * (processor_seconds() - start) / static_cast<double>(entry.points.size());
}

void run_round(std::span<Entry> entries, std::size_t round)
{
    const auto each = [&](auto run) {
        for (std::size_t i = 0; i < entries.size(); ++i) run(entries[(i + round) % entries.size()]);
    };
    each([](Entry& entry) {
        entry.result.single.push_back(
            mean_time(entry, [&] { entry.contender->answer_singly(entry.points, entry.single); }));
    });
    each([](Entry& entry) {
        if (entry.batch.empty()) return;
        entry.result.batch.push_back(
            mean_time(entry, [&] { entry.contender->answer_batch(entry.points, entry.batch); }));
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
        least.emplace_back(entry.points.size(), std::numeric_limits<double>::infinity());
    for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t i = 0; i < entries.size(); ++i)
            entries[i].contender->time_each(entries[i].points, overhead, least[i]);
    }
    for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i].result.tail = tail_of(std::move(least[i]));
}

std::uint64_t hash_of(std::span<const PeerAnswer> answers)
{
    std::uint64_t hash = 0;
    for (const auto& [squared, triangle] : answers) {
        const auto bits = std::bit_cast<std::uint64_t>(squared);
        hash = (hash ^ bits ^ std::uint64_t{to_index(triangle)} << 32U) * 0x9E3779B97F4A7C15U;
    }
    return hash;
}

/// Compares the last answers of all contenders, those of single queries and those of batches.
void compare_entries(const TriangleMesh& mesh, std::span<Entry> entries, std::size_t queries)
{
    std::vector<GivenAnswers> given;
    for (const Entry& entry : entries) {
        given.push_back({entry.points, entry.sample.places, entry.single});
        given.push_back({entry.points, entry.sample.places, entry.batch});
    }
    const auto agreements = compare(mesh, given, queries);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        SetResult& result = entries[i].result;
        result.agreement.add(agreements[2 * i]);
        result.agreement.add(agreements[2 * i + 1]);
        result.hash = hash_of(entries[i].single);
    }
}

} // namespace

std::vector<Agreement> compare(const TriangleMesh& mesh, std::span<const GivenAnswers> given,
                               std::size_t points)
{
    const double diagonal = bounding_box(mesh).extent().norm();
    const auto true_distance = [&](const PeerAnswer& answer, const Vec3& point) {
        return (closest_point(mesh.triangle(answer.triangle), point).point - point).norm();
    };
    const auto for_each_answer = [&](auto visit) {
        for (std::size_t g = 0; g < given.size(); ++g) {
            const auto& [at, places, answers] = given[g];
            for (std::size_t i = 0; i < answers.size(); ++i) {
                const std::size_t place = places.empty() ? i : places[i];
                visit(g, place, answers[i], true_distance(answers[i], at[i]));
            }
        }
    };
    std::vector<double> best(points, std::numeric_limits<double>::infinity());
    for_each_answer([&](std::size_t, std::size_t place, const PeerAnswer&, double distance) {
        best[place] = std::min(best[place], distance);
    });
    std::vector<Agreement> agreements(given.size());
    for_each_answer(
        [&](std::size_t g, std::size_t place, const PeerAnswer& answer, double distance) {
            const double claimed = std::sqrt(answer.squared_distance);
            const double off =
                std::max(std::abs(claimed - distance), distance - best[place]) / diagonal;
            agreements[g].add({off, off <= answer_tolerance ? std::size_t{0} : 1});
        });
    return agreements;
}

std::vector<RaceResult> race(const TriangleMesh& mesh,
                             std::span<const std::unique_ptr<Contender>> contenders,
                             const std::array<QuerySet, 3>& sets, const RaceOptions& options)
{
    std::vector<RaceResult> results(contenders.size());
    std::array<std::vector<Entry>, 3> fields;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        for (const auto& contender : contenders)
            fields[s].push_back(make_entry(*contender, sets[s]));
    }
    for (int round = 0; round < options.rounds; ++round)
        for (auto& field : fields) run_round(field, static_cast<std::size_t>(round));
    for (std::size_t s = 0; s < sets.size(); ++s) {
        measure_tails(fields[s], options.tail_passes);
        compare_entries(mesh, fields[s], sets[s].points.size());
        for (std::size_t i = 0; i < results.size(); ++i)
            results[i].sets[s] = std::move(fields[s][i].result);
    }
    return results;
}

} // namespace proxima::bench
