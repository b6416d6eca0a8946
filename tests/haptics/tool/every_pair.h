// The distance of two meshes by all pairs of their triangles, and random numbers, for tests of tools.
#pragma once

#include "geometry/triangle_distance.h"
#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace proxima::testing {

class Random {
public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    double operator()(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    Vec3 direction()
    {
        while (true) {
            const Vec3 v{(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)};
            if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
        }
    }

private:
    std::mt19937 engine_;
};

/// A triangle and its box.
struct BoxedTriangle {
    Vec3 lower = Vec3::Zero();
    Vec3 upper = Vec3::Zero();
    Triangle triangle;
};

inline std::vector<BoxedTriangle> boxed(const TriangleMesh& mesh, const RigidTransform& pose = {})
{
    std::vector<BoxedTriangle> all;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        BoxedTriangle each;
        each.triangle = pose(mesh.triangle(TriangleId{i}));
        const auto& v = each.triangle.vertices;
        each.lower = v[0].cwiseMin(v[1]).cwiseMin(v[2]);
        each.upper = v[0].cwiseMax(v[1]).cwiseMax(v[2]);
        all.push_back(each);
    }
    return all;
}

/// Whether boxes are farther apart than that along an axis.
inline bool apart(const BoxedTriangle& a, const Vec3& lower, const Vec3& upper, double distance)
{
    return (lower - a.upper).cwiseMax(a.lower - upper).maxCoeff() > distance;
}

/// Those whose boxes a ball may meet: all are looked at, one by one, with no tree and no lanes.
inline std::vector<BoxedTriangle> near_ball(const std::vector<BoxedTriangle>& all,
                                            const Vec3& center, double radius)
{
    std::vector<BoxedTriangle> near;
    for (const BoxedTriangle& each : all)
        if (!apart(each, center, center, radius)) near.push_back(each);
    return near;
}

/// The distance of two sets of triangles, or `farthest` where it is more: all pairs.
inline double distance_of(const std::vector<BoxedTriangle>& first,
                          const std::vector<BoxedTriangle>& second, double farthest)
{
    double least = farthest;
    for (const BoxedTriangle& a : first) {
        for (const BoxedTriangle& b : second) {
            if (apart(a, b.lower, b.upper, least)) continue;
            const double squared = closest_points(a.triangle, b.triangle).squared_distance;
            least = std::min(least, std::sqrt(squared));
        }
    }
    return least;
}

} // namespace proxima::testing
