#include "cli/ray_picture.h"

#include "cli/canvas.h"
#include "proxima/query/cells_along_ray.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

void put_pixel(Image& image, std::size_t pixel, const Color& color)
{
    for (std::size_t channel = 0; channel < 3; ++channel) {
        // sRGB by its exponent alone: near enough for pictures.
        const float linear = std::clamp(color[static_cast<int>(channel)], 0.0F, 1.0F);
        image.bytes[3 * pixel + channel] =
            static_cast<std::uint8_t>(std::lround(255 * std::pow(linear, 1 / 2.2F)));
    }
}

Image empty_image(const PictureSize& size)
{
    Image image{size.width, size.height, {}};
    image.bytes.resize(3 * static_cast<std::size_t>(size.width) *
                       static_cast<std::size_t>(size.height));
    return image;
}

} // namespace

Image draw_weights(const Octree& octree, std::span<const Ray> rays, const PictureSize& size,
                   Threads threads, Progress* progress)
{
    Image image = empty_image(size);
    constexpr double opacity = 0.3;
    const Color yellow = srgb(0xFFE23D);
    if (progress != nullptr)
        progress->begin_stage("casting rays", static_cast<std::uint64_t>(size.height));
    parallel_for(static_cast<std::size_t>(size.height), threads, [&](std::size_t y) {
        if (is_cancelled(progress)) return;
        const auto width = static_cast<std::size_t>(size.width);
        for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel) {
            double weight = 0;
            cells_along_ray(octree, rays[pixel], [&](const CellOnRay& at) {
                if (at.cell.type != CellClass::boundary) return;
                const double edge = octree.box(at.cell).extent().maxCoeff();
                weight += at.penetration * at.chord / edge;
            });
            put_pixel(image, pixel, yellow * static_cast<float>(1 - std::exp(-opacity * weight)));
        }
        if (progress != nullptr) progress->advance(1);
    });
    return image;
}

Image draw_hits(const TriangleMesh& mesh, std::span<const Ray> rays,
                std::span<const std::optional<RayHit>> hits, const PictureSize& size)
{
    Image image = empty_image(size);
    const Color background = srgb(0xF1F4F8);
    const Color front = srgb(0xE9D8B8);
    const Color back = srgb(0x7FA6C9);
    for (std::size_t pixel = 0; pixel < rays.size(); ++pixel) {
        if (!hits[pixel]) {
            put_pixel(image, pixel, background);
            continue;
        }
        const Vec3 normal = scaled_normal(mesh.triangle(hits[pixel]->triangle)).stableNormalized();
        const double cosine = -normal.dot(rays[pixel].direction);
        const auto light = static_cast<float>(0.06 + 0.94 * std::abs(cosine));
        put_pixel(image, pixel, (cosine >= 0 ? front : back) * light);
    }
    return image;
}

} // namespace proxima
