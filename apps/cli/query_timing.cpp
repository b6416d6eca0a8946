#include "cli/query_timing.h"

#include "proxima/proximity/closest_feature.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <vector>

namespace proxima {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int query_count = 10'000;
constexpr int repeats = 5;

/// [0, 1) from the generator's bits: the same on every machine.
double unit_random(std::mt19937_64& random)
{
    return static_cast<double>(random() >> 11U) * 0x1p-53;
}

std::vector<Vec3> sample_queries(const TriangleMesh& mesh)
{
    std::mt19937_64 random(1);
    const Box bounds = bounding_box(mesh);
    const Vec3 center = bounds.center();
    const Vec3 extent = bounds.extent();
    const auto offset = [&] {
        const double x = unit_random(random) - 0.5;
        const double y = unit_random(random) - 0.5;
        return Vec3(x, y, unit_random(random) - 0.5);
    };
    std::vector<Vec3> points;
    points.reserve(query_count);
    while (points.size() < query_count / 2)
        points.emplace_back(center + 1.2 * extent.cwiseProduct(offset()));
    const double diagonal = extent.norm();
    while (points.size() < query_count) {
        const auto id = static_cast<std::uint32_t>(random() % mesh.triangle_count());
        const Triangle triangle = mesh.triangle(TriangleId{id});
        const double root = std::sqrt(unit_random(random));
        const double part = unit_random(random);
        const Vec3 on_surface =
            (1 - root) * triangle[0] + root * (1 - part) * triangle[1] + root * part * triangle[2];
        points.emplace_back(on_surface + 0.02 / std::sqrt(3.0) * diagonal * offset());
    }
    return points;
}

/// The least time between two readings of the clock with `work` between them.
template <class Work>
double least_nanoseconds(Work&& work)
{
    double least = HUGE_VAL;
    for (int i = 0; i < repeats; ++i) {
        const auto start = Clock::now();
        work();
        const std::chrono::duration<double, std::nano> taken = Clock::now() - start;
        least = std::min(least, taken.count());
    }
    return least;
}

} // namespace

QueryTiming time_queries(const ProximityOctree& octree, const TriangleMesh& mesh)
{
    const double clock = least_nanoseconds([] {});
    std::vector<double> times;
    times.reserve(query_count);
    volatile double sink = 0; // keeps the queries
    for (const Vec3& point : sample_queries(mesh)) {
        const double taken =
            least_nanoseconds([&] { sink = closest_feature(octree, point).squared_distance; });
        times.push_back(std::max(0.0, taken - clock));
    }
    std::ranges::sort(times);
    return {query_count, times[times.size() / 2], times.back()};
}

} // namespace proxima
