#include "cli/query_timing.h"

#include "lab/query_sets.h"
#include "proxima/closest_feature.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace proxima {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t estimated_queries = 10'000;
constexpr int repeats = 5;

/// Between two readings of the clock with `work` between them.
template <class Work>
double nanoseconds(Work&& work)
{
    const auto start = Clock::now();
    work();
    const std::chrono::duration<double, std::nano> taken = Clock::now() - start;
    return taken.count();
}

template <class Work>
double least_nanoseconds(const Work& work)
{
    double least = HUGE_VAL;
    for (int i = 0; i < repeats; ++i) least = std::min(least, nanoseconds(work));
    return least;
}

} // namespace

std::vector<Vec3> estimate_queries(const TriangleMesh& mesh)
{
    const auto sets = query_sets(mesh, estimated_queries / 2, 1);
    std::vector<Vec3> points = sets[0].points;
    points.insert(points.end(), sets[1].points.begin(), sets[1].points.end());
    return points;
}

QueryTiming time_queries(const MeshIndex& index, std::span<const Vec3> points)
{
    const double clock = least_nanoseconds([] {});
    std::vector<double> times;
    times.reserve(points.size());
    volatile double sink = 0; // keeps the queries
    for (const Vec3& point : points) {
        const double taken =
            least_nanoseconds([&] { sink = closest_feature(index, point)->squared_distance; });
        times.push_back(std::max(0.0, taken - clock));
    }
    std::ranges::sort(times);
    return {points.size(), times[times.size() / 2], times.back()};
}

double time_pass(const MeshIndex& index, std::span<const Vec3> points)
{
    volatile double sink = 0;
    std::array<double, repeats> rounds{};
    for (double& round : rounds) {
        round = nanoseconds([&] {
            double sum = 0;
            for (const Vec3& point : points) sum += closest_feature(index, point)->squared_distance;
            sink = sum;
        });
    }
    std::ranges::sort(rounds);
    return rounds[repeats / 2] / static_cast<double>(points.size());
}

} // namespace proxima
