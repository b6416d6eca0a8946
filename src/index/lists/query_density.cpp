#include "index/lists/query_density.h"

#include "base/progress.h"
#include "base/radix_sort.h"
#include "geometry/length.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr std::uint32_t grid = 1U << QueryDensity::max_depth;
constexpr std::size_t points_per_triangle = 4;
constexpr std::size_t max_points = std::size_t{1} << 25U;

/// Points of a low-discrepancy sequence in three dimensions (powers of the plastic number's
/// relative) [roberts-2018].
struct Sequence {
    std::uint64_t x = 0x8000000000000000U;
    std::uint64_t y = 0x8000000000000000U;
    std::uint64_t z = 0x8000000000000000U;

    [[nodiscard]] std::array<double, 3> next() noexcept
    {
        x += 0xD1B54A32D192ED03U;
        y += 0xABC98388FB8FAC03U;
        z += 0x8CB92BA72F3D8DD7U;
        const auto unit = [](std::uint64_t bits) {
            return static_cast<double>(bits >> 11U) * 0x1p-53;
        };
        return {unit(x), unit(y), unit(z)};
    }
};

std::uint64_t key_of(const Vec3& p, double frame_half)
{
    std::array<std::uint32_t, 3> position{};
    for (int axis = 0; axis < 3; ++axis) {
        const double part = (p[axis] / frame_half + 1) / 2 * grid;
        position[static_cast<std::size_t>(axis)] =
            static_cast<std::uint32_t>(std::clamp(part, 0.0, static_cast<double>(grid - 1)));
    }
    return cell_key(position, QueryDensity::max_depth).bits;
}

} // namespace

std::optional<QueryDensity> QueryDensity::sample(const TriangleMesh& mesh, const Box& bounds,
                                                 const RootFrame& frame, Progress* progress)
{
    QueryDensity density;
    density.frame_half_ = frame.frame_half();
    const Vec3 half = 0.6 * frame.scale * bounds.extent();
    density.box_half_ = half.cwiseMax(0.01 * half.maxCoeff());
    const double band = 0.01 * half.norm() / 0.6 * 2;

    double area = 0;
    std::vector<double> areas(mesh.triangle_count());
    for (std::uint32_t i = 0; i < areas.size(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vec3 ab = (triangle[1] - triangle[0]) * frame.scale;
        const Vec3 ac = (triangle[2] - triangle[0]) * frame.scale;
        areas[i] = ab.cross(ac).norm();
        area += areas[i];
    }
    const std::size_t count = std::min(points_per_triangle * mesh.triangle_count(), max_points);
    StageSteps steps(progress, "expected queries", count);
    std::vector<KeyedIndex> items;
    items.reserve(count);
    Sequence sequence;
    double due = 0.5;
    for (std::uint32_t i = 0; i < areas.size(); ++i) {
        due += area > 0 ? areas[i] / area * static_cast<double>(count)
                        : static_cast<double>(count) / static_cast<double>(areas.size());
        const Triangle triangle = mesh.triangle(TriangleId{i});
        while (due >= 1) {
            due -= 1;
            auto [u, v, w] = sequence.next();
            if (u + v > 1) {
                u = 1 - u;
                v = 1 - v;
            }
            const Vec3 a = frame.to_frame(triangle[0]);
            const Vec3 ab = (triangle[1] - triangle[0]) * frame.scale;
            const Vec3 ac = (triangle[2] - triangle[0]) * frame.scale;
            const Vec3 normal = unit_of(ab.cross(ac));
            const Vec3 p = a + u * ab + v * ac + (2 * w - 1) * band * normal;
            items.push_back({key_of(p, density.frame_half_), 0});
            if (!steps.done(1)) return std::nullopt;
        }
    }
    StageSteps sorting(progress, "expected queries",
                       items.size() * radix_passes(3 * max_depth + 1));
    if (!radix_sort(items, 3 * max_depth + 1, sorting)) return std::nullopt;
    density.keys_.reserve(items.size());
    for (const KeyedIndex& item : items) density.keys_.push_back(item.key);
    return density;
}

std::array<CellDensity, 8> QueryDensity::split(const CellDensity& cell, CellKey key) const
{
    std::array<CellDensity, 8> children;
    const int below = max_depth - depth(key) - 1;
    std::uint32_t first = cell.first;
    const double total = static_cast<double>(cell.last - cell.first) + 8;
    for (int octant = 0; octant < 8; ++octant) {
        const std::uint64_t end = (child(key, octant).bits + 1) << 3 * below;
        const auto begin = keys_.begin();
        const auto last = std::lower_bound(begin + first, begin + cell.last, end);
        CellDensity& result = children[static_cast<std::size_t>(octant)];
        result.first = first;
        result.last = static_cast<std::uint32_t>(last - begin);
        // One more for each: few samples shall not make a cell worthless.
        result.surface = cell.surface * (static_cast<double>(result.last - first) + 1) / total;
        first = result.last;
    }
    return children;
}

double QueryDensity::probability(const CellDensity& cell, CellKey key) const
{
    const auto position = cell_coordinates(key);
    const double edge = 2 * frame_half_ / static_cast<double>(1U << depth(key));
    double part = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = -frame_half_ + edge * position[static_cast<std::size_t>(axis)];
        const double inside =
            std::min(low + edge, box_half_[axis]) - std::max(low, -box_half_[axis]);
        // A box that is a single place is in a cell or not.
        part *= box_half_[axis] > 0 ? std::max(inside, 0.0) / (2 * box_half_[axis])
                                    : static_cast<double>(inside >= 0);
    }
    return 0.5 * part + 0.5 * cell.surface;
}

} // namespace proxima
