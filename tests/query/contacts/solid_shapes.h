// Solids for tests of contacts, penetration depths by brute force, and what every depth promises.
#pragma once

#include "index/test_meshes.h"
#include "proxima/contacts.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/mesh_index.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace proxima::testing {

inline Solid solid_of(const TriangleMesh& mesh)
{
    return build_solid(build_mesh_index(mesh).value()).value();
}

/// Twelve triangles, outward.
inline TriangleMesh box_mesh(const Box& box)
{
    const Vec3 half = 0.5 * box.extent();
    return moved(cube_mesh(Vec3::Zero(), 1),
                 [&](const Vec3& p) { return Vec3(box.center() + p.cwiseProduct(half)); });
}

/// The surface of a bounded polyhedron.
inline TriangleMesh surface_of(const ConvexPolyhedron& hull)
{
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
        const auto loop = hull.facet_loop(f);
        for (std::size_t i = 2; i < loop.size(); ++i)
            triangles.push_back({loop[0], loop[i - 1], loop[i]});
    }
    return mesh_of({hull.points().begin(), hull.points().end()}, std::move(triangles));
}

inline TriangleMesh random_hull(std::mt19937_64& random, int points, double size)
{
    std::uniform_real_distribution<double> unit(-size, size);
    std::vector<Vec3> positions;
    for (int i = 0; i < points; ++i) {
        const double x = unit(random);
        const double y = unit(random);
        positions.emplace_back(x, y, unit(random));
    }
    return surface_of(convex_hull(positions).value());
}

using LongVec = Eigen::Matrix<long double, 3, 1>;

/// By all normals that can be the direction of the least translation: of faces of either mesh, and
/// of an edge of one and one of the other. \pre both convex
inline long double convex_depth_by_brute_force(const TriangleMesh& a, const TriangleMesh& b,
                                               const RigidTransform& pose_b)
{
    std::vector<LongVec> of_a;
    std::vector<LongVec> of_b;
    for (const Vec3& p : a.positions()) of_a.push_back(p.cast<long double>());
    for (const Vec3& p : b.positions()) of_b.push_back(pose_b(p).cast<long double>());
    long double least = HUGE_VALL;
    const auto consider = [&](const LongVec& product) {
        const long double length = product.norm();
        if (!(length > 0)) return;
        for (const long double sign : {1.0L, -1.0L}) {
            const LongVec n = sign / length * product;
            long double top = -HUGE_VALL;
            for (const LongVec& p : of_a) top = std::max(top, n.dot(p));
            long double low = HUGE_VALL;
            for (const LongVec& p : of_b) low = std::min(low, n.dot(p));
            least = std::min(least, top - low);
        }
    };
    const auto edges_of = [&](const TriangleMesh& mesh, const std::vector<LongVec>& points) {
        std::vector<LongVec> edges;
        for (const TriangleCorners& t : mesh.triangles()) {
            consider((points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]));
            for (std::size_t i = 0; i < 3; ++i) {
                if (t[i] < t[(i + 1) % 3]) edges.push_back(points[t[(i + 1) % 3]] - points[t[i]]);
            }
        }
        return edges;
    };
    const auto edges_a = edges_of(a, of_a);
    const auto edges_b = edges_of(b, of_b);
    for (const LongVec& u : edges_a)
        for (const LongVec& v : edges_b) consider(u.cross(v));
    return std::max(least, 0.0L);
}

/// Solids made of boxes: as a mesh each box is a component.
struct Boxes {
    std::vector<Box> boxes;

    [[nodiscard]] TriangleMesh mesh() const
    {
        TriangleMesh all = box_mesh(boxes.front());
        for (std::size_t i = 1; i < boxes.size(); ++i) all = joined(all, box_mesh(boxes[i]));
        return all;
    }
};

/// B moved by t overlaps A exactly if t is in one of the boxes A_i - B_k. The nearest point of what lies
/// outside of all of them has coordinates that are 0 or those of a box's planes. \pre coordinates are
/// whole numbers
inline double boxes_depth(const Boxes& a, const Boxes& b)
{
    std::vector<Box> sums;
    std::array<std::vector<double>, 3> planes;
    for (int axis = 0; axis < 3; ++axis) planes[static_cast<std::size_t>(axis)] = {0};
    for (const Box& p : a.boxes) {
        for (const Box& q : b.boxes) {
            const Box sum = {p.lower - q.upper, p.upper - q.lower};
            sums.push_back(sum);
            for (int axis = 0; axis < 3; ++axis) {
                planes[static_cast<std::size_t>(axis)].push_back(sum.lower[axis]);
                planes[static_cast<std::size_t>(axis)].push_back(sum.upper[axis]);
            }
        }
    }
    const auto is_in = [&](const Vec3& t) {
        for (const Box& sum : sums)
            if (sum.contains(t)) return true;
        return false;
    };
    double least = HUGE_VAL;
    for (const double x : planes[0]) {
        for (const double y : planes[1]) {
            for (const double z : planes[2]) {
                const Vec3 t(x, y, z);
                if (t.norm() >= least) continue;
                for (int octant = 0; octant < 8; ++octant) {
                    const Vec3 aside((octant & 1) != 0 ? 0.25 : -0.25,
                                     (octant & 2) != 0 ? 0.25 : -0.25,
                                     (octant & 4) != 0 ? 0.25 : -0.25);
                    if (is_in(t + aside)) continue;
                    least = t.norm();
                    break;
                }
            }
        }
    }
    return least;
}

inline RigidTransform moved_by(const Vec3& translation)
{
    RigidTransform pose;
    pose.translation = translation;
    return pose;
}

/// What an answer promises by itself.
inline void expect_true_bounds(const Solid& a, const Solid& b, const RigidTransform& pose,
                               const PenetrationDepth& found)
{
    EXPECT_EQ(solids_overlap(a, b, pose), found.method != PenetrationMethod::apart);
    EXPECT_GE(found.lower, 0);
    EXPECT_LE(found.lower, found.upper);
    EXPECT_LE(found.translation.norm(), found.upper * (1 + 1e-15));
    RigidTransform free = pose;
    free.translation += found.translation;
    EXPECT_FALSE(solids_overlap(a, b, free));
    if (found.method == PenetrationMethod::apart) {
        EXPECT_EQ(found.upper, 0);
        EXPECT_EQ(found.direction, Vec3::Zero());
    } else {
        EXPECT_NEAR(found.direction.norm(), 1, 1e-12);
        EXPECT_LT((found.direction - found.translation.normalized()).norm(), 1e-12);
    }
}

} // namespace proxima::testing
