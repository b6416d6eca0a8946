#include "haptics/tool/tool_contacts.h"

#include "geometry/closest_point.h"
#include "haptics/tool/tool_bench.h"
#include "haptics/touch_meshes.h"
#include "index/index_parts.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <iostream>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace proxima::testing::tool_contacts_test {
namespace {

/// A mesh in a pose, and all that find_contacts needs of it.
struct Placed {
    TriangleMesh mesh;
    MeshIndex index;
    ContactFeatures features;
    RigidTransform pose;

    explicit Placed(const TriangleMesh& given, const RigidTransform& at = {})
        : mesh(given), index(index_of(mesh)), features(ContactFeatures::build(index).value()),
          pose(at)
    {}
    [[nodiscard]] std::uint32_t rows() const { return index.triangle_count(); }
    [[nodiscard]] Triangle row(std::uint32_t at) const { return index.parts().triangle(at); }
};

/// The contacts of all pairs of triangles. Their `pair` is the scene's row times the tool's number of rows,
/// plus the tool's row.
std::vector<FeatureContact> contacts_of(const Placed& scene, const Placed& tool, double farthest)
{
    std::vector<FeatureContact> all;
    for (std::uint32_t i = 0; i < scene.rows(); ++i) {
        for (std::uint32_t k = 0; k < tool.rows(); ++k) {
            NearPair pair;
            pair.scene = scene.pose(scene.row(i));
            pair.tool = tool.row(k);
            pair.scene_row = i;
            pair.tool_row = k;
            std::array<FeatureContact, 32> found;
            const std::size_t count = find_contacts(pair, {&scene.features, scene.pose},
                                                    {&tool.features, tool.pose}, farthest, found);
            for (const FeatureContact& each : std::span(found).first(count)) {
                all.push_back(each);
                all.back().pair = i * tool.rows() + k;
            }
        }
    }
    return all;
}

/// What a mesh is at a point, by looking at all of its triangles.
struct Surroundings {
    bool is_edge = false; ///< on the sides of triangles, and on no corner
    double toward = -1; ///< greatest cosine of the angle between a direction and what surrounds it
    double foot_error = 1; ///< distance of the point from the mesh
};
Surroundings around(const Placed& mesh, const Vec3& p, const Vec3& direction)
{
    Surroundings result;
    int sides = 0;
    bool corner = false;
    for (std::uint32_t i = 0; i < mesh.rows(); ++i) {
        const Triangle triangle = mesh.pose(mesh.row(i));
        const TrianglePoint foot = closest_point(triangle, p);
        const double off = (foot.point - p).norm();
        result.foot_error = std::min(result.foot_error, off);
        if (off > 1e-9) continue;
        for (const double weight : foot.weights) corner = corner || weight > 1 - 1e-6;
        for (const double weight : foot.weights) sides += weight < 1e-9 ? 1 : 0;
        for (const Vec3& v : triangle.vertices)
            result.toward = std::max(result.toward, direction.dot(v - p) / (v - p).norm());
    }
    result.is_edge = sides > 0 && !corner;
    return result;
}

/// Against all triangles: where two edges touch, no neighbour of either is nearer but by the small
/// angle that is allowed.
TEST(ToolContacts, OfEdgesAreWhereTheDistanceIsLeast)
{
    const auto scaled = [](const TriangleMesh& mesh, double s) {
        return moved(mesh, [s](const Vec3& p) { return Vec3(s * p); });
    };
    const std::vector<TriangleMesh> meshes = {box_mesh(Vec3::Ones()), scaled(bumpy_sheet(5), 1.5),
                                              *sample_mesh("icosphere:1"),
                                              *sample_mesh("torus:8x6")};
    int edges = 0;
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto vector = [&] { return random_vector(random); };
        const Placed scene(meshes[seed % meshes.size()], pose_at(0.1 * vector(), vector()));
        const Placed tool(meshes[seed / 4 % meshes.size()],
                          pose_at(1.9 * vector().normalized(), 2 * vector()));
        for (const FeatureContact& contact : contacts_of(scene, tool, 0.5)) {
            const Surroundings on_scene = around(scene, contact.scene_point, contact.normal);
            const Surroundings on_tool = around(tool, contact.tool_point, -contact.normal);
            ASSERT_LT(on_scene.foot_error + on_tool.foot_error, 1e-9);
            if (!on_scene.is_edge || !on_tool.is_edge) continue;
            ++edges;
            EXPECT_LT(on_scene.toward, 0.01 + 1e-6);
            EXPECT_LT(on_tool.toward, 0.01 + 1e-6);
        }
    }
    std::cout << edges << " contacts of edges\n";
    EXPECT_GT(edges, 60);
}

/// A bar along x over a block that is shorter, tilted so little: it touches both borders of the block's
/// top, for a turn about the one would take it into the other.
TEST(ToolContacts, OfAnEdgeThatAllButLiesInAFaceAreAtBothBorders)
{
    const Placed block(box_mesh(Vec3::Constant(0.5), {0, 0, -0.5}));
    for (const double tilt : {0.0, 1e-9, 4.7e-7, 1e-4, 0.009, 0.02}) {
        SCOPED_TRACE("tilt: " + std::to_string(tilt));
        // An edge of the bar is below.
        const Mat3 on_edge = pose_at(Vec3::Zero(), {std::numbers::pi / 4, 0, 0}).rotation;
        const double low = 0.1 * std::numbers::sqrt2;
        const Placed bar(
            box_mesh({2, 0.1, 0.1}),
            {pose_at(Vec3::Zero(), {0, tilt, 0}).rotation * on_edge, {0, 0, low + 0.02}});
        double least = 1;
        double most = -1;
        for (const FeatureContact& contact : contacts_of(block, bar, 0.05)) {
            if (contact.normal.z() < 0.9) continue;
            least = std::min(least, contact.scene_point.x());
            most = std::max(most, contact.scene_point.x());
        }
        EXPECT_NEAR(most, 0.5, 1e-9);
        EXPECT_NEAR(least, tilt < 0.01 ? -0.5 : 0.5, 1e-9);
    }
}

/// The gap after a motion is that which the same features have then.
TEST(ToolContacts, KnowTheirGapAfterAMotion)
{
    int crossings = 0;
    int turning = 0;
    int resting = 0;
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto vector = [&] { return random_vector(random); };
        const Placed scene(box_mesh({1, 0.7, 0.5}), pose_at(Vec3::Zero(), vector()));
        const RigidTransform from = pose_at(1.9 * vector().normalized(), 2 * vector());
        const RigidTransform to = {pose_at(Vec3::Zero(), 0.05 * vector()).rotation * from.rotation,
                                   from.translation + 0.05 * vector()};
        const Placed before(box_mesh({0.6, 0.5, 0.4}), from);
        const Placed after(box_mesh({0.6, 0.5, 0.4}), to);
        const Mat3 turn = to.rotation * from.rotation.transpose();
        const auto lies_along = [](const Vec3& direction, const Triangle& triangle) {
            return scaled_normal(triangle).normalized().cross(direction).norm() < 1e-6;
        };
        const std::vector<FeatureContact> then = contacts_of(scene, after, 0.5);
        for (const FeatureContact& contact : contacts_of(scene, before, 0.5)) {
            const Vec3 point = turn * (contact.tool_point - from.translation) + to.translation;
            const double gap = contact.gap_after(turn, point);
            const Triangle face = contact.turns
                                      ? before.pose(before.row(contact.pair % before.rows()))
                                      : scene.pose(scene.row(contact.pair / before.rows()));
            const bool crosses = !contact.scene_edge.isZero(0);
            if (!crosses && !lies_along(contact.normal, face)) continue;
            for (const FeatureContact& other : then) {
                if (other.pair != contact.pair) continue;
                const auto is_same = [](const Vec3& a, const Vec3& b) {
                    return (a - b).norm() < 1e-9;
                };
                if (crosses) {
                    if (!is_same(other.scene_edge, contact.scene_edge) ||
                        !is_same(other.tool_edge, turn * contact.tool_edge))
                        continue;
                    ++crossings;
                } else if (contact.turns) {
                    if (!other.turns || !is_same(other.scene_point, contact.scene_point) ||
                        !is_same(other.normal, turn * contact.normal))
                        continue;
                    ++turning;
                } else {
                    if (other.turns || !is_same(other.tool_point, point) ||
                        !is_same(other.normal, contact.normal))
                        continue;
                    ++resting;
                }
                EXPECT_NEAR(gap, other.gap, 1e-12);
            }
        }
    }
    std::cout << crossings << " crossings, " << turning << " on faces of the tool, " << resting
              << " of the scene\n";
    EXPECT_GT(std::min({crossings, turning, resting}), 20);
}

} // namespace
} // namespace proxima::testing::tool_contacts_test
