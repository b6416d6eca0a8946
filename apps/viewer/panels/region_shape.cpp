#include "viewer/panels/region_shape.h"

#include "base/progress.h"
#include "proxima/closest_feature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <span>

namespace proxima {
namespace {

constexpr std::uint32_t steps = 8; // between a corner and the next

/// How far a half-line stays with its feature: a point of it is as far from the feature as from its
/// base.
void reach(RegionSample& sample, const MeshIndex& with, double length)
{
    constexpr double rounding = 1e-9;
    constexpr int halvings = 24;
    const auto is_closest = [&](double away) {
        const double nearest = std::sqrt(closest_feature(with, sample.at(away))->squared_distance);
        return nearest >= away * (1.0 - rounding);
    };
    sample.reach = length;
    sample.goes_on = is_closest(length);
    if (sample.goes_on) return;
    double inside = 0.0;
    double beyond = length;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (inside + beyond);
        (is_closest(middle) ? inside : beyond) = middle;
    }
    sample.reach = inside;
}

RegionSample between(const std::array<RegionSample, 3>& corners, double u, double v)
{
    const double w = 1.0 - u - v;
    RegionSample sample;
    sample.base = w * corners[0].base + u * corners[1].base + v * corners[2].base;
    sample.direction =
        (w * corners[0].direction + u * corners[1].direction + v * corners[2].direction)
            .normalized();
    return sample;
}

/// Samples over the triangle of three corners, of which the first is the middle's.
void add_fan(RegionShape& shape, const std::array<RegionSample, 3>& corners)
{
    const auto first = static_cast<std::uint32_t>(shape.samples.size());
    // Row i has i + 1 samples, the last row lies between the two corners.
    const auto number = [&](std::uint32_t row, std::uint32_t i) {
        return first + row * (row + 1) / 2 + i;
    };
    for (std::uint32_t row = 0; row <= steps; ++row) {
        for (std::uint32_t i = 0; i <= row; ++i) {
            shape.samples.push_back(between(corners, static_cast<double>(row - i) / steps,
                                            static_cast<double>(i) / steps));
        }
    }
    for (std::uint32_t row = 0; row < steps; ++row) {
        for (std::uint32_t i = 0; i <= row; ++i) {
            shape.cap.push_back({number(row, i), number(row + 1, i), number(row + 1, i + 1)});
            if (i < row)
                shape.cap.push_back({number(row, i), number(row + 1, i + 1), number(row, i + 1)});
        }
    }
    std::vector<std::uint32_t>& side = shape.sides.emplace_back();
    for (std::uint32_t i = 0; i <= steps; ++i) side.push_back(number(steps, i));
}

/// The fans of all sides, and the borders between them.
void add_fans(RegionShape& shape, std::span<const ConeCorner> corners)
{
    const std::size_t count = corners.size();
    std::vector<RegionSample> around;
    RegionSample middle;
    for (const ConeCorner& corner : corners) {
        around.push_back({corner.base, corner.direction});
        middle.base += corner.base / static_cast<double>(count);
        middle.direction += corner.direction;
    }
    middle.direction.normalize();
    const bool is_row = shape.shape == ConeShape::flat;
    for (std::size_t i = 0; i + (is_row ? 1 : 0) < count; ++i) {
        add_fan(shape, {middle, around[i], around[(i + 1) % count]});
        if (corners[i].is_border) shape.borders.push_back(shape.sides.back().front());
    }
    if (!is_row) return;
    shape.cap.clear();
    shape.borders.push_back(shape.sides.back().back());
}

/// One flat piece.
void add_quad(SceneSurface& surface, const std::array<Vec3, 4>& corners)
{
    const auto first = static_cast<std::uint32_t>(surface.positions.size());
    surface.positions.insert(surface.positions.end(), corners.begin(), corners.end());
    if (corners[0] != corners[1]) surface.triangles.push_back({first, first + 1, first + 2});
    surface.triangles.push_back({first, first + 2, first + 3});
}

} // namespace

Result<RegionShape> region_shape(const ViewModel& model, const MeshIndex& with, Feature feature,
                                 double length, const Progress* progress)
{
    const auto cone = local_cone(model.mesh, model.topology, feature);
    if (!cone) return tl::unexpected(cone.error());
    RegionShape shape;
    shape.shape = cone->shape;
    shape.side = cone->side;
    if (cone->shape == ConeShape::line) {
        shape.samples.push_back({cone->corners[0].base, cone->corners[0].direction});
        shape.borders.push_back(0);
    } else if (cone->shape != ConeShape::empty) {
        add_fans(shape, cone->corners);
    }
    for (RegionSample& sample : shape.samples) {
        if (is_cancelled(progress)) return cancelled("finding the region");
        reach(sample, with, length);
    }
    return shape;
}

void add_region(DrawnScene& scene, const RegionShape& shape, const Color& color)
{
    // What goes on fades towards where it is cut off: the first half is one band.
    struct Band {
        double from, to;
        float opacity;
    };
    constexpr int fading = 8;
    std::vector<Band> bands = {{0.0, 0.5, 1.0F}};
    for (int i = 0; i < fading; ++i) {
        const double from = bands.back().to;
        bands.push_back(
            {from, from + 0.5 / fading, 1.0F - (static_cast<float>(i) + 0.7F) / fading});
    }
    constexpr float glass = 0.55F;
    const Color ink = srgb(0x333333);
    const auto& samples = shape.samples;
    const auto goes_on = [&](std::uint32_t sample) { return samples[sample].goes_on; };
    for (const Band& band : bands) {
        SceneSurface surface;
        surface.name = "region";
        surface.color = color;
        surface.opacity = glass * band.opacity;
        SceneLines lines = {"region's edges", {}, ink, 1.6, band.opacity};
        const bool is_first = band.from == 0.0;
        for (const auto& side : shape.sides) {
            for (std::size_t i = 0; i + 1 < side.size(); ++i) {
                const RegionSample& a = samples[side[i]];
                const RegionSample& b = samples[side[i + 1]];
                const bool fades = a.goes_on && b.goes_on;
                if (!fades && !is_first) continue;
                const double to = fades ? band.to : 1.0;
                add_quad(surface, {a.at(band.from * a.reach), b.at(band.from * b.reach),
                                   b.at(to * b.reach), a.at(to * a.reach)});
                if (!fades) lines.segments.push_back({a.end(), b.end()});
            }
        }
        for (const std::uint32_t border : shape.borders) {
            const RegionSample& sample = samples[border];
            if (!sample.goes_on && !is_first) continue;
            const double to = sample.goes_on ? band.to : 1.0;
            lines.segments.push_back(
                {sample.at(band.from * sample.reach), sample.at(to * sample.reach)});
        }
        if (is_first) {
            // Its end, where it has one.
            for (const TriangleCorners& triangle : shape.cap) {
                if (std::ranges::all_of(triangle, goes_on)) continue;
                const auto first = static_cast<std::uint32_t>(surface.positions.size());
                for (const std::uint32_t corner : triangle)
                    surface.positions.push_back(samples[corner].end());
                surface.triangles.push_back({first, first + 1, first + 2});
            }
        }
        if (!surface.triangles.empty()) scene.surfaces.push_back(std::move(surface));
        if (!lines.segments.empty()) scene.lines.push_back(std::move(lines));
    }
}

std::string words_for_region(const RegionShape& shape)
{
    if (shape.shape == ConeShape::empty) {
        return "empty: from no other point it is the closest, for the surface bends both ways "
               "there";
    }
    std::string words = shape.shape == ConeShape::line   ? "drawn, a line"
                        : shape.shape == ConeShape::flat ? "drawn, flat"
                                                         : "drawn";
    if (shape.side == ConeSide::behind)
        words += ", behind the surface: outside, where that bends inward, there is none";
    return words;
}

std::string words_for_end(const RegionShape& shape)
{
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0.0;
    std::size_t going_on = 0;
    for (const RegionSample& sample : shape.samples) {
        nearest = std::min(nearest, sample.reach);
        farthest = std::max(farthest, sample.reach);
        going_on += sample.goes_on ? 1 : 0;
    }
    if (farthest <= 0.0) return "at once: other parts of the mesh are as near";
    if (going_on == shape.samples.size()) return "none as far as it is drawn";
    if (going_on > 0) return fmt::format("{:.4g} away and more", nearest);
    return fmt::format("{:.4g} to {:.4g} away", nearest, farthest);
}

} // namespace proxima
