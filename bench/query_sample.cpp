#include "query_sample.h"

#include <algorithm>

namespace proxima::bench {
namespace {

constexpr std::size_t longest_run = 1000;

} // namespace

QuerySample sample_of(std::span<const Vec3> points, std::size_t count)
{
    QuerySample sample;
    // Ten runs at least, so that a walk is seen in many places.
    const std::size_t run = std::clamp<std::size_t>(count / 10, 1, longest_run);
    const std::size_t runs = (count + run - 1) / run;
    for (std::size_t r = 0; r < runs; ++r) {
        const std::size_t start = r * (points.size() - run) / std::max<std::size_t>(runs - 1, 1);
        for (std::size_t i = start; i < start + run; ++i) {
            sample.points.push_back(points[i]);
            sample.places.push_back(static_cast<std::uint32_t>(i));
        }
    }
    return sample;
}

} // namespace proxima::bench
