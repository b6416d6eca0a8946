// Runs peers against each other on one mesh: passes in turn, tails, and who was wrong.
//
//     round 1    set a: A B C, then the batches A B C; set b ...
//     round 2    set a: B C A, ...
//
// Passes are timed by the processor time of this process, single queries by the steady clock.
#pragma once

#include "lab/query_sets.h"
#include "proximity_peers.h"
#include "query_sample.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima::bench {

/// How far a distance may be off, over the diagonal of the mesh's box: all peers answer in double.
inline constexpr double answer_tolerance = 1e-12;

/// What one contender answered to some points of a set.
struct GivenAnswers {
    std::span<const Vec3> points;
    std::span<const std::uint32_t> places; ///< of the points in the set; empty: its first ones
    std::span<const PeerAnswer> answers;   ///< one for each point, or none at all
};

struct Agreement {
    /// The most that a distance was off, over the diagonal of the mesh's box: from the true
    /// distance of the triangle that was named, or from the least distance that any peer found.
    double deviation = 0;
    std::size_t wrong = 0; ///< answers off by more than answer_tolerance

    void add(const Agreement& other)
    {
        deviation = std::max(deviation, other.deviation);
        wrong += other.wrong;
    }
};

/// Compares answers with the mesh and with each other. One result for each, in their order.
/// `points` is the size of the set.
[[nodiscard]] std::vector<Agreement>
compare(const TriangleMesh& mesh, std::span<const GivenAnswers> given, std::size_t points);

struct RaceOptions {
    int rounds = 5;
    int tail_passes = 5; ///< each query's least time of so many is kept; 0: no tails
};

/// Nanoseconds of single queries at these ranks.
struct Tail {
    double p50 = 0;
    double p99 = 0;
    double p9999 = 0;
    double worst = 0;
};

/// What one peer did on one set.
struct SetResult {
    std::size_t queries = 0;
    std::vector<double> single; ///< mean nanoseconds per query, by round
    std::vector<double> batch;
    Tail tail;
    Agreement agreement;    ///< of single queries and of batches
    std::uint64_t hash = 0; ///< of the distances and triangles of single queries
};

struct RaceResult {
    std::array<SetResult, 3> sets;
};

/// One result for each contender, in their order.
[[nodiscard]] std::vector<RaceResult> race(const TriangleMesh& mesh,
                                           std::span<const std::unique_ptr<Contender>> contenders,
                                           const std::array<QuerySet, 3>& sets,
                                           const RaceOptions& options);

} // namespace proxima::bench
