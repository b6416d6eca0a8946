#include "haptics/tool/tool_contacts.h"

#include "geometry/closest_point.h"
#include "haptics/tool/tool_bench.h"
#include "haptics/touch_meshes.h"
#include "index/index_parts.h"
#include "proxima/sample_meshes.h"

#include <array>
#include <gtest/gtest.h>
#include <random>
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
            all.insert(all.end(), found.begin(), found.begin() + count);
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

/// Against all triangles: where two edges touch, no neighbour of either is nearer.
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
        const auto vector = [&] {
            std::uniform_real_distribution<double> unit(-1, 1);
            const double x = unit(random);
            const double y = unit(random);
            return Vec3(x, y, unit(random));
        };
        const Placed scene(meshes[seed % meshes.size()], pose_at(0.1 * vector(), vector()));
        const Placed tool(meshes[seed / 4 % meshes.size()],
                          pose_at(1.9 * vector().normalized(), 2 * vector()));
        for (const FeatureContact& contact : contacts_of(scene, tool, 0.5)) {
            const Surroundings on_scene = around(scene, contact.scene_point, contact.normal);
            const Surroundings on_tool = around(tool, contact.tool_point, -contact.normal);
            ASSERT_LT(on_scene.foot_error + on_tool.foot_error, 1e-9);
            if (!on_scene.is_edge || !on_tool.is_edge) continue;
            ++edges;
            EXPECT_LT(on_scene.toward, 1e-6);
            EXPECT_LT(on_tool.toward, 1e-6);
        }
    }
    std::cout << edges << " contacts of edges\n";
    EXPECT_GT(edges, 60);
}

} // namespace
} // namespace proxima::testing::tool_contacts_test
