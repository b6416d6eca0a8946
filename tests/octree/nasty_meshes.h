// Random meshes that hurt overlap tests: slivers, coplanar and touching cases, huge and tiny
// triangles together, far from the origin, at any scale.
#pragma once

#include "proxima/triangle_mesh.h"

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace proxima::testing {

/// Reproducible by its seed.
inline TriangleMesh nasty_mesh(std::uint32_t seed)
{
    std::mt19937_64 random(seed);
    const auto below = [&](std::uint64_t limit) { return random() % limit; };
    const auto real = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    const std::uint64_t kind = below(5);
    const std::size_t count = 1 + below(kind == 0 ? 400 : 60);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        positions.insert(positions.end(), {a, b, c});
        triangles.push_back({first, first + 1, first + 2});
    };
    const auto random_point = [&] { return Vec3{real(), real(), real()}; };
    const auto grid_point = [&] {
        return Vec3(static_cast<double>(below(9)), static_cast<double>(below(9)),
                    static_cast<double>(below(9)));
    };
    for (std::size_t i = 0; i < count; ++i) {
        switch (kind) {
        case 0: { // small triangles of very uneven sizes
            const Vec3 at = random_point();
            const double size = std::pow(10.0, 3 * real() - 3);
            add(at, at + size * random_point(), at + size * random_point());
            break;
        }
        case 1: // corners on cell planes: touching everywhere
            add(grid_point(), grid_point(), grid_point());
            break;
        case 2: { // slivers, nearly or exactly collinear
            const Vec3 a = random_point();
            const Vec3 b = random_point();
            const double width = below(2) == 0 ? 0.0 : 1e-12 * real();
            add(a, b, a + real() * (b - a) + width * random_point());
            break;
        }
        case 3: // across the whole root
            add(random_point(), random_point(), random_point());
            break;
        default: { // grid corners moved by an ulp, points and segments
            const Vec3 a = grid_point();
            Vec3 b = below(3) == 0 ? a : grid_point();
            if (below(2) == 0) b[0] = std::nextafter(b[0], 100.0);
            add(a, b, below(3) == 0 ? a : grid_point());
            break;
        }
        }
    }
    constexpr double scales[] = {1, 1, 1e-30, 1e30, 3.7, 1e-6};
    const double scale = scales[below(6)];
    const Vec3 offset = below(3) == 0 ? Vec3(1e3 * scale * random_point()) : Vec3(Vec3::Zero());
    for (Vec3& position : positions) position = scale * position + offset;
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace proxima::testing
