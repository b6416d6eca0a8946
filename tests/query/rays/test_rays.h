// Rays that find what is wrong: through corners and edges, along faces, from the surface, from far
// away, of any length, with ranges that begin or end near hits.
#pragma once

#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace proxima::testing {

inline constexpr std::array all_faces = {Faces::both, Faces::front, Faces::back};

inline MeshIndex ray_index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

class RayGenerator {
public:
    RayGenerator(const TriangleMesh& mesh, std::uint64_t seed)
        : mesh_(mesh), box_(bounding_box(mesh)), random_(seed)
    {
        size_ = box_.extent().maxCoeff();
        if (!(size_ > 0)) size_ = std::max(box_.upper.cwiseAbs().maxCoeff(), 1.0);
    }

    Ray operator()()
    {
        Ray ray;
        const Vec3 target = place();
        switch (below(6)) {
        case 0:
            ray.origin = place();
            break;
        case 1:
            ray.origin = box_.center() + std::ldexp(size_, int(below(90)) - 2) * direction();
            break;
        default:
            ray.origin = box_.center() + size_ * Vec3{signed_unit(), signed_unit(), signed_unit()};
        }
        ray.direction = target - ray.origin;
        switch (below(8)) {
        case 0: // along an axis, through the target
            ray.direction = Vec3::Unit(static_cast<int>(below(3)));
            if (below(2) == 0) ray.direction = -ray.direction;
            ray.origin = target - std::ldexp(size_, int(below(6)) - 3) * ray.direction;
            break;
        case 1: // across an axis
            ray.direction = target - ray.origin;
            ray.direction[static_cast<int>(below(3))] = 0;
            ray.origin = target - ray.direction;
            break;
        case 2: { // along a side of a triangle, in its plane
            const Triangle triangle = some_triangle();
            ray.direction = triangle[1] - triangle[0];
            ray.origin = (below(2) != 0 ? triangle[2] : triangle[0]) - 2 * ray.direction;
            break;
        }
        case 3:
            ray.origin = target, ray.direction = direction();
            break;
        default:
            break;
        }
        ray.direction *= std::ldexp(1.0, int(below(40)) - 20);
        if ((ray.direction.array() == 0).all()) ray.direction = Vec3::UnitX();
        const double to_target = (target - ray.origin).norm() / ray.direction.norm();
        switch (below(6)) {
        case 0:
            ray.t_min = to_target * unit() * 1.5;
            break;
        case 1:
            ray.t_max = to_target * unit() * 1.5;
            break;
        case 2:
            ray.t_min = to_target, ray.t_max = to_target * (1 + unit());
            break;
        case 3:
            ray.t_min = -std::numeric_limits<double>::infinity();
            break;
        default:
            break;
        }
        return ray;
    }

private:
    std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
    double unit() { return std::uniform_real_distribution<double>()(random_); }
    double signed_unit() { return 2 * unit() - 1; }
    Vec3 direction()
    {
        const double x = signed_unit();
        const double y = signed_unit();
        return Vec3(x, y, signed_unit() + 1e-3).normalized();
    }
    Triangle some_triangle()
    {
        return mesh_.triangle(
            TriangleId{static_cast<std::uint32_t>(below(mesh_.triangle_count()))});
    }
    /// A corner, the middle of an edge, a point of a face, or of the box.
    Vec3 place()
    {
        const Triangle triangle = some_triangle();
        switch (below(4)) {
        case 0:
            return triangle[0];
        case 1:
            return 0.5 * (triangle[0] + triangle[1]);
        case 2:
            return 0.25 * triangle[0] + 0.5 * triangle[1] + 0.25 * triangle[2];
        default:
            const double x = unit();
            const double y = unit();
            return box_.lower + Vec3(x, y, unit()).cwiseProduct(box_.extent());
        }
    }

    const TriangleMesh& mesh_;
    Box box_;
    double size_ = 1;
    std::mt19937_64 random_;
};

} // namespace proxima::testing
