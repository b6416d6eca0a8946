#include "cli/ray_picture.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "cli/canvas.h"
#include "proxima/cells_along_ray.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace proxima {

namespace {

void add_pixel(Image& image, const Color& color)
{
    for (int channel = 0; channel < 3; ++channel) {
        // sRGB by its exponent alone: near enough for pictures.
        const float linear = std::clamp(color[channel], 0.0F, 1.0F);
        image.bytes.push_back(
            static_cast<std::uint8_t>(std::lround(255 * std::pow(linear, 1 / 2.2F))));
    }
}

/// From black over purple, red and orange to pale yellow, each step as much lighter to the eye as
/// the last: black and eight of the colours of matplotlib's "inferno", in sRGB. Beyond 1 as 1.
Color heat(float share)
{
    constexpr std::array<unsigned, 9> stops = {0x000000, 0x210C4A, 0x57106E, 0x8A226A, 0xBC3754,
                                               0xE45A31, 0xF98E09, 0xF9CB35, 0xFCFFA4};
    const float at = std::clamp(share, 0.0F, 1.0F) * (stops.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), stops.size() - 2);
    const float part = at - static_cast<float>(below);
    Color color;
    for (int channel = 0; channel < 3; ++channel) {
        const auto of = [&](unsigned stop) {
            return static_cast<float>(stop >> (16 - 8 * channel) & 0xFFU) / 255;
        };
        color[channel] = (1 - part) * of(stops[below]) + part * of(stops[below + 1]);
    }
    return color;
}

/// What one in a hundred of the weights above zero exceeds, to a two-thousandth of it, so that a few
/// do not darken the rest; 1 where there are none.
class UsualMost {
public:
    void add(float weight)
    {
        if (!(weight > 0)) return;
        ++counts_[std::bit_cast<std::uint32_t>(weight) >> dropped_bits];
        ++all_;
    }

    [[nodiscard]] float value() const
    {
        if (all_ == 0) return 1;
        std::uint64_t below = (all_ - 1) * 99 / 100;
        std::uint32_t at = 0;
        while (below >= counts_[at]) below -= counts_[at++];
        return std::bit_cast<float>(at << dropped_bits);
    }

private:
    // The bits of numbers above zero have the order of the numbers. The first 20 of them count.
    static constexpr unsigned dropped_bits = 12;
    std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(1U << (32 - dropped_bits));
    std::uint64_t all_ = 0;
};

} // namespace

Image empty_image(ViewSize size)
{
    Image image{size.width, size.height, {}};
    image.bytes.reserve(3 * static_cast<std::size_t>(size.width) *
                        static_cast<std::size_t>(size.height));
    return image;
}

Image draw_weights(const Octree& octree, const RayList& rays, ViewSize size, Threads threads,
                   Progress* progress)
{
    const auto width = static_cast<std::size_t>(size.width);
    const auto height = static_cast<std::size_t>(size.height);
    const auto weights = std::make_unique_for_overwrite<float[]>(width * height);
    begin_stage(progress, "casting rays", height);
    parallel_for(height, threads, [&](std::size_t y) {
        if (is_cancelled(progress)) return;
        for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel) {
            double weight = 0;
            cells_along_ray(octree, rays[pixel], [&](const CellOnRay& at) {
                if (at.cell.type != CellClass::boundary) return Flow::proceed;
                const double edge = octree.box(at.cell).extent().maxCoeff();
                weight += at.penetration * at.chord / edge;
                return Flow::proceed;
            });
            weights[pixel] = static_cast<float>(weight);
        }
        advance_stage(progress, 1);
    });
    Image image = empty_image(size);
    if (is_cancelled(progress)) return image;
    UsualMost most;
    StageSteps steps(progress, "drawing the weights", 2 * width * height);
    for (std::size_t pixel = 0; pixel < width * height; ++pixel) {
        most.add(weights[pixel]);
        if (!steps.done(1)) return image;
    }
    const float full = most.value();
    for (std::size_t pixel = 0; pixel < width * height; ++pixel) {
        const Color color = heat(weights[pixel] / full);
        for (int channel = 0; channel < 3; ++channel) {
            image.bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * color[channel])));
        }
        if (!steps.done(1)) return image;
    }
    steps.finish();
    return image;
}

void draw_hits(const TriangleMesh& mesh, std::span<const Ray> rays,
               std::span<const std::optional<RayHit>> hits, Image& image)
{
    const Color background = srgb(0xF1F4F8);
    const Color front = srgb(0xE9D8B8);
    const Color back = srgb(0x7FA6C9);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i]) {
            add_pixel(image, background);
            continue;
        }
        const Vec3 normal = scaled_normal(mesh.triangle(hits[i]->triangle)).stableNormalized();
        const double cosine = -normal.dot(rays[i].direction);
        const auto light = static_cast<float>(0.06 + 0.94 * std::abs(cosine));
        add_pixel(image, (cosine >= 0 ? front : back) * light);
    }
}

} // namespace proxima
