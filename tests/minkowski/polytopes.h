// Polyhedra for the tests: of whole coordinates, nasty and plain, from a seed.
#pragma once

#include "proxima/convex_polyhedron.h"

#include <cstdint>
#include <ctime>
#include <random>
#include <vector>

namespace proxima::test {

using Points = std::vector<Vec3>;

/// The processor time of the whole program for some work, in ticks.
template <class Work>
double processor_time(const Work& work)
{
    const std::clock_t start = std::clock();
    work();
    return static_cast<double>(std::clock() - start);
}

/// Whole random points in [-reach, reach]^3.
inline Points whole_points(std::mt19937& random, int count, int reach)
{
    std::uniform_int_distribution<int> coordinate(-reach, reach);
    Points points(static_cast<std::size_t>(count));
    for (Vec3& point : points) {
        point.x() = coordinate(random);
        point.y() = coordinate(random);
        point.z() = coordinate(random);
    }
    return points;
}

/// About on a sphere of the given radius, whole.
inline Points round_points(std::mt19937& random, int count, double radius)
{
    std::normal_distribution<double> normal;
    Points points(static_cast<std::size_t>(count));
    for (Vec3& point : points) {
        const Vec3 direction = Vec3{normal(random), normal(random), normal(random)}.normalized();
        point = (radius * direction).array().round();
    }
    return points;
}

inline Points cube_points(double half)
{
    Points points;
    for (const double x : {-half, half}) {
        for (const double y : {-half, half})
            for (const double z : {-half, half}) points.emplace_back(x, y, z);
    }
    return points;
}

inline Points octahedron_points(double radius)
{
    Points points;
    for (int axis = 0; axis < 3; ++axis) {
        points.emplace_back(radius * Vec3::Unit(axis));
        points.emplace_back(-radius * Vec3::Unit(axis));
    }
    return points;
}

/// One of many shapes: boxes, prisms, pyramids, few values and many duplicates, flat ones,
/// segments, points.
inline Points nasty_points(std::mt19937& random)
{
    const auto pick = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
    switch (pick(9)) {
    case 0:
        return whole_points(random, 1 + pick(12), 1);
    case 1:
        return whole_points(random, 1 + pick(30), 2);
    case 2:
        return whole_points(random, 4 + pick(20), 10);
    case 3:
        return round_points(random, 4 + pick(30), 1000);
    case 4:
        return cube_points(1 + pick(3));
    case 5:
        return octahedron_points(1 + pick(3));
    case 6: { // a prism over a polygon
        Points base = whole_points(random, 3 + pick(6), 4);
        const Vec3 up = whole_points(random, 1, 3)[0];
        const std::size_t count = base.size();
        for (std::size_t i = 0; i < count; ++i) {
            base[i].z() = 0;
            base.emplace_back(base[i] + up);
        }
        return base;
    }
    case 7: { // flat, in a plane of any direction
        const Points frame = whole_points(random, 3, 3);
        Points flat;
        for (int i = 0, n = 1 + pick(10); i < n; ++i)
            flat.emplace_back(frame[0] + (pick(7) - 3) * frame[1] + (pick(7) - 3) * frame[2]);
        return flat;
    }
    default:
        return whole_points(random, 1 + pick(3), 3);
    }
}

inline ConvexPolyhedron hull_of(const Points& points, const Points& rays = {})
{
    auto hull = convex_hull(points, rays);
    if (!hull) throw std::runtime_error(describe(hull.error()));
    return *hull;
}

} // namespace proxima::test
