#include "haptics/soak/every_triangle.h"

#include "geometry/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima::soak {

namespace {

constexpr float far_off = 1e18F;

/// What single precision may be off by at p, several times over.
double float_rounding(const Vec3& p, const SurfaceScale& scale)
{
    return 0x1p-20 * (scale.reach + p.cwiseAbs().maxCoeff());
}

std::array<float, 3> rounded(const Vec3& p)
{
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

template <std::size_t Size>
std::uint32_t count_within(const std::array<float, Size>& squared, float limit)
{
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < Size; ++i) count += squared[i] <= limit ? 1U : 0U;
    return count;
}

} // namespace

EveryTriangle::EveryTriangle(const TriangleMesh& mesh) : mesh_(mesh), scale_(scale_of(mesh))
{
    const std::size_t count = mesh.triangle_count();
    padded_ = (count + group - 1) / group * group;
    constexpr float infinity = std::numeric_limits<float>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lower_[axis].assign(padded_, far_off);
        upper_[axis].assign(padded_, far_off);
        for (std::uint32_t id = 0; id < count; ++id) {
            const Box box = bounding_box(mesh.triangle(TriangleId{id}));
            const auto along = static_cast<Eigen::Index>(axis);
            lower_[axis][id] = std::nextafter(static_cast<float>(box.lower[along]), -infinity);
            upper_[axis][id] = std::nextafter(static_cast<float>(box.upper[along]), infinity);
        }
    }
}

void EveryTriangle::bound(std::size_t first, const std::array<float, 3>& p,
                          std::array<float, group>& squared) const noexcept
{
    squared.fill(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const lower = lower_[axis].data() + first;
        const float* const upper = upper_[axis].data() + first;
        const float at = p[axis];
        for (std::size_t i = 0; i < group; ++i) {
            const float below = lower[i] - at;
            const float above = at - upper[i];
            const float outside = below > above ? below : above;
            const float gap = outside > 0 ? outside : 0;
            squared[i] += gap * gap;
        }
    }
}

std::size_t EveryTriangle::collect(const Vec3& p, double distance,
                                   std::span<ContactTriangle> buffer) const noexcept
{
    const auto at = rounded(p);
    const double near = distance + float_rounding(p, scale_);
    const auto limit = static_cast<float>(near * near * (1 + 0x1p-18));
    std::array<float, group> squared;
    std::size_t count = 0;
    for (std::size_t first = 0; first < padded_; first += group) {
        bound(first, at, squared);
        if (count_within(squared, limit) == 0) continue;
        for (std::size_t i = 0; i < group; ++i) {
            if (squared[i] > limit || first + i >= mesh_.triangle_count()) continue;
            const TriangleId id{static_cast<std::uint32_t>(first + i)};
            const Triangle triangle = mesh_.triangle(id);
            const Box box = bounding_box(triangle);
            const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
            if (gap.squaredNorm() > distance * distance) continue;
            if (count < buffer.size()) buffer[count] = {triangle, id};
            ++count;
        }
    }
    return count;
}

double EveryTriangle::clearance(const Vec3& p) const noexcept
{
    const auto at = rounded(p);
    const double rounding = float_rounding(p, scale_);
    // A triangle's distance is at least that of its box: those of nearer boxes are asked, a group
    // that has the nearest of them first.
    std::array<float, group> squared;
    std::size_t best_group = 0;
    float least_bound = std::numeric_limits<float>::infinity();
    for (std::size_t first = 0; first < padded_; first += group) {
        bound(first, at, squared);
        if (count_within(squared, least_bound) == 0) continue;
        least_bound = *std::min_element(squared.begin(), squared.end());
        best_group = first;
    }
    double least = std::numeric_limits<double>::infinity();
    const auto ask_group = [&](std::size_t first) {
        bound(first, at, squared);
        const double near = std::sqrt(least) + rounding;
        const auto limit = static_cast<float>(near * near * (1 + 0x1p-18));
        if (count_within(squared, limit) == 0) return;
        for (std::size_t i = 0; i < group && first + i < mesh_.triangle_count(); ++i) {
            if (squared[i] > limit) continue;
            const TriangleId id{static_cast<std::uint32_t>(first + i)};
            const TrianglePoint closest = closest_point(mesh_.triangle(id), p);
            least = std::min(least, (closest.point - p).squaredNorm());
        }
    };
    ask_group(best_group);
    for (std::size_t first = 0; first < padded_; first += group) ask_group(first);
    const double margin = 0x1p-46 * (scale_.reach + p.cwiseAbs().maxCoeff());
    return std::sqrt(least) - margin;
}

} // namespace proxima::soak
