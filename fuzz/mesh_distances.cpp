// Distances of two meshes of any triangles against all pairs, and bounds of how far one is from the
// other against points of it.
#include "base/check.h"
#include "decoded_mesh.h"
#include "geometry/closest_point.h"
#include "geometry/length.h"
#include "geometry/triangle_distance.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "query/contact/test_poses.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace {

using namespace proxima;

struct LeastDistance {
    double squared = std::numeric_limits<double>::infinity();
    TriangleId a = {};
    TriangleId b = {};
};

LeastDistance distance_by_brute_force(const TriangleMesh& a, const TriangleMesh& b,
                                      const RigidTransform& pose_b)
{
    LeastDistance least;
    for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
        for (std::uint32_t k = 0; k < b.triangle_count(); ++k) {
            const double squared =
                closest_points(a.triangle(TriangleId{i}), pose_b(b.triangle(TriangleId{k})))
                    .squared_distance;
            if (squared < least.squared) least = {squared, TriangleId{i}, TriangleId{k}};
        }
    }
    return least;
}

/// `size`: of the larger mesh. The bits and which pair is named are promised for meshes that are near
/// each other.
void expect_distance(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose,
                     const LeastDistance& truth, double size)
{
    const double least = std::sqrt(truth.squared);
    const auto found = mesh_distance(a, b, pose);
    PROXIMA_CHECK(found.has_value());
    if (truth.squared < 0x1p-960) { // the squares here vanish, and those of the library need not
        PROXIMA_CHECK_LE(found->distance, 0x1p-480);
        return;
    }
    if (!(least < 0x1p25 * size)) {
        PROXIMA_CHECK_LE(least, found->distance);
        PROXIMA_CHECK_LE(found->distance, least * (1 + 0x1p-46));
        return;
    }
    PROXIMA_CHECK_EQ(found->distance, least);
    if (least > 0) PROXIMA_CHECK(found->triangle_a == truth.a && found->triangle_b == truth.b);
    const auto again = mesh_distance(a, b, pose, {.farthest = least, .start_from = &*found});
    PROXIMA_CHECK(again && again->distance == least);
    if (least > 0)
        PROXIMA_CHECK(!mesh_distance(a, b, pose, {.farthest = std::nextafter(least, 0.0)}));
}

double distance_from(const TriangleMesh& mesh, const Vec3& p)
{
    double least = HUGE_VAL;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        least =
            std::min(least, length_of(closest_point(mesh.triangle(TriangleId{i}), p).point - p));
    }
    return least;
}

/// 2^exponent times the mesh. \pre no coordinate gets too large
TriangleMesh scaled(const TriangleMesh& mesh, int exponent)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    for (Vec3& position : positions)
        for (double& coordinate : position) coordinate = std::ldexp(coordinate, exponent);
    return *make_triangle_mesh(std::move(positions),
                               {mesh.triangles().begin(), mesh.triangles().end()});
}

/// The truth is found in meshes as large as 1, where no products vanish.
void expect_deviation(const MeshIndex& a, const MeshIndex& b, const TriangleMesh& mesh_a,
                      const TriangleMesh& mesh_b, double size)
{
    const int exponent = std::max(0, -std::ilogb(size));
    const TriangleMesh large_a = scaled(mesh_a, exponent);
    const TriangleMesh large_b = scaled(mesh_b, exponent);
    const auto scale_up = [&](double length) { return std::ldexp(length, exponent); };
    const Execution alone{.threads = {1}};
    const auto greatest = greatest_deviation(
        a, b, {.tolerance = 1e-3 * size, .max_places = 4, .max_splits = 500, .execution = alone});
    PROXIMA_CHECK(greatest.has_value());
    const DistanceBounds& bounds = greatest->distance;
    constexpr double steps = 2 * std::numeric_limits<double>::denorm_min(); // as answers round
    const double slack = 1e-13 * size + steps;
    PROXIMA_CHECK(0 <= bounds.lower && bounds.lower <= bounds.upper);
    if (greatest->is_complete) PROXIMA_CHECK_LE(bounds.upper - bounds.lower, 1e-3 * size + slack);
    const Vec3 farthest = greatest->point_a.unaryExpr(scale_up);
    PROXIMA_CHECK(distance_from(large_b, farthest) >= scale_up(bounds.lower - slack));
    for (std::uint32_t i = 0; i < large_a.triangle_count(); ++i) {
        const Triangle triangle = large_a.triangle(TriangleId{i});
        for (const Vec3& p : {triangle[0], Vec3(0.5 * triangle[1] + 0.5 * triangle[2]),
                              Vec3((triangle[0] + triangle[1] + triangle[2]) / 3)})
            PROXIMA_CHECK_LE(distance_from(large_b, p), scale_up(bounds.upper + slack));
    }
    const auto mean =
        mean_deviation(a, b, {.tolerance = 1e-2 * size, .max_splits = 500, .execution = alone});
    if (!mean) return; // no area
    PROXIMA_CHECK(0 <= mean->mean.lower && mean->mean.lower <= mean->mean.upper);
    PROXIMA_CHECK_LE(mean->mean.lower, mean->root_mean_square.upper);
    PROXIMA_CHECK_LE(mean->root_mean_square.lower, bounds.upper + slack);
}

/// Few triangles, for what takes their product in time.
TriangleMesh first_triangles(const TriangleMesh& mesh, std::size_t count)
{
    const auto triangles = mesh.triangles().first(std::min(count, mesh.triangle_count()));
    return *make_triangle_mesh({mesh.positions().begin(), mesh.positions().end()},
                               {triangles.begin(), triangles.end()});
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint32_t seed = bytes.next_word();
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh_a = fuzz::decode_mesh(bytes, code);
    const TriangleMesh mesh_b = first_triangles(fuzz::decode_mesh(bytes, code), 20);
    const Execution alone{.threads = {1}};
    const MeshIndex a = build_mesh_index(mesh_a, {.execution = alone}).value();
    MeshIndex b = build_mesh_index(mesh_b, {.execution = alone}).value();
    if (seed % 2 == 0) b = with_slabs(b, {.execution = alone}).value();
    Box box = bounding_box(mesh_a);
    const Box box_b = bounding_box(mesh_b);
    const double extent = std::max(box.extent().maxCoeff(), box_b.extent().maxCoeff());
    proxima::testing::PoseGenerator pose(mesh_a, mesh_b, seed);
    for (const RigidTransform& pose_b : {RigidTransform(), pose()})
        expect_distance(a, b, pose_b, distance_by_brute_force(mesh_a, mesh_b, pose_b), extent);
    box.extend(box_b.lower);
    box.extend(box_b.upper);
    const double largest =
        std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
    if (largest > 0) expect_deviation(a, b, mesh_a, mesh_b, largest);
    return 0;
}
