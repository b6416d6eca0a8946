// Poses that find what is wrong with intersections: the same place, touching in corners and sides,
// along the axes, hardly turned, anyhow; and all pairs by brute force.
#pragma once

#include "geometry/triangle_contact.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/triangle_mesh.h"

#include <Eigen/Geometry>

#include <random>
#include <vector>

namespace proxima::testing {

/// Every pair asked exactly, unless its boxes are apart.
inline std::vector<TrianglePair> pairs_by_brute_force(const TriangleMesh& a, const TriangleMesh& b,
                                                      const RigidTransform& pose_b)
{
    std::vector<Triangle> others;
    std::vector<Box> boxes;
    for (std::uint32_t j = 0; j < b.triangle_count(); ++j) {
        others.push_back(pose_b(b.triangle(TriangleId{j})));
        boxes.push_back(bounding_box(others.back()));
    }
    std::vector<TrianglePair> pairs;
    for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
        const Triangle triangle = a.triangle(TriangleId{i});
        const Box box = bounding_box(triangle);
        for (std::uint32_t j = 0; j < b.triangle_count(); ++j) {
            if ((box.lower.array() > boxes[j].upper.array()).any() ||
                (boxes[j].lower.array() > box.upper.array()).any())
                continue;
            if (triangles_meet(triangle, others[j]))
                pairs.push_back({TriangleId{i}, TriangleId{j}});
        }
    }
    return pairs;
}

/// For two meshes of any size anywhere.
class PoseGenerator {
public:
    PoseGenerator(const TriangleMesh& a, const TriangleMesh& b, std::uint64_t seed)
        : a_(a), b_(b), random_(seed),
          reach_((bounding_box(a).extent().norm() + bounding_box(b).extent().norm()) / 2)
    {}

    RigidTransform operator()()
    {
        RigidTransform pose;
        switch (below(4)) {
        case 0:
            pose.rotation = quarter_turns();
            break;
        case 1:
            pose.rotation = turn(std::ldexp(unit(), -static_cast<int>(below(60))));
            break;
        default:
            pose.rotation = turn(4 * unit());
        }
        const Vec3 place = pose.rotation * some_point(b_);
        switch (below(6)) {
        case 0:
            pose.translation = bounding_box(a_).center() - place;
            break;
        case 1: // beside it, so that they meet in little or nothing
            pose.translation = some_point(a_) - place + reach_ * unit() * direction();
            break;
        case 2: // exactly on the grid where both are
            pose.translation =
                (some_corner(a_) - some_corner(b_)) + Vec3{whole(3), whole(3), whole(3)};
            break;
        case 3:
            pose.translation = Vec3{whole(2), whole(2), whole(2)};
            break;
        default:
            pose.translation = some_point(a_) - place;
        }
        return pose;
    }

private:
    std::uint32_t below(std::uint32_t limit)
    {
        return static_cast<std::uint32_t>(random_() % limit);
    }
    double unit() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    double whole(int reach) { return static_cast<int>(below(2 * reach + 1)) - reach; }
    Vec3 direction()
    {
        const double x = unit();
        const double y = unit();
        return Vec3(x, y, unit() + 2e-3).normalized();
    }
    Mat3 turn(double angle) { return Eigen::AngleAxisd(angle, direction()).toRotationMatrix(); }
    Mat3 quarter_turns()
    {
        Mat3 rotation = Mat3::Zero();
        const int first = static_cast<int>(below(3));
        const int second = (first + 1 + static_cast<int>(below(2))) % 3;
        rotation(first, 0) = below(2) == 0 ? 1 : -1;
        rotation(second, 1) = below(2) == 0 ? 1 : -1;
        rotation.col(2) = rotation.col(0).cross(rotation.col(1));
        return rotation;
    }
    Triangle some_triangle(const TriangleMesh& mesh)
    {
        const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
        return mesh.triangle(TriangleId{below(count)});
    }
    Vec3 some_corner(const TriangleMesh& mesh)
    {
        return some_triangle(mesh)[static_cast<int>(below(3))];
    }
    Vec3 some_point(const TriangleMesh& mesh)
    {
        const Triangle triangle = some_triangle(mesh);
        const int first = static_cast<int>(below(3));
        const Vec3& a = triangle[first];
        const Vec3& b = triangle[(first + 1) % 3];
        const Vec3& c = triangle[(first + 2) % 3];
        const double along = std::abs(unit());
        switch (below(3)) {
        case 0:
            return a;
        case 1:
            return a + along * (b - a);
        default:
            return (a + along * (b - a)) * 0.75 + c * 0.25;
        }
    }

    const TriangleMesh& a_;
    const TriangleMesh& b_;
    std::mt19937_64 random_;
    double reach_;
};

} // namespace proxima::testing
