// Voronoi regions as far as they are true, held against distances to all features of the mesh.
#include "code_of.h"
#include "index/listed_index.h"
#include "proxima/sample_meshes.h"
#include "query/closest/brute_force.h"
#include "viewer/panels/region_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace proxima::region_shape_test {
namespace {

constexpr std::array kinds = {FeatureKind::vertex, FeatureKind::edge, FeatureKind::face};

struct Built {
    std::shared_ptr<const ViewModel> model;
    MeshIndex listed;

    [[nodiscard]] std::size_t count(FeatureKind kind) const
    {
        return kind == FeatureKind::vertex ? model->mesh.vertex_count()
               : kind == FeatureKind::edge ? model->topology.edge_count()
                                           : model->mesh.triangle_count();
    }
    [[nodiscard]] double distance(const Vec3& p) const
    {
        return std::sqrt(
            closest_feature_by_brute_force(model->mesh, model->topology, p).squared_distance);
    }
};

Built built(TriangleMesh mesh)
{
    auto model = make_view_model("mesh", std::move(mesh), Vec3::UnitZ(), 0, {}).value();
    auto listed = testing::listed_index(model->mesh).value();
    return {std::move(model), std::move(listed)};
}

/// Cubes from -1 to 1, the second one `gap` farther along x.
TriangleMesh two_cubes(double gap)
{
    const TriangleMesh cube = make_cube();
    const double side = cube.positions()[0].cwiseAbs().x() * 2.0;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (const double shift : {0.0, side + gap}) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const Vec3& p : cube.positions()) positions.emplace_back(p + Vec3(shift, 0.0, 0.0));
        for (const TriangleCorners& t : cube.triangles())
            triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

TEST(RegionShape, OfConvexBodiesIsUnbounded)
{
    const Built sphere = built(make_icosphere(1));
    for (const FeatureKind kind : kinds) {
        for (std::uint32_t id = 0; id < sphere.count(kind); ++id) {
            const auto shape = region_shape(*sphere.model, sphere.listed, {kind, id}, 3.0);
            ASSERT_TRUE(shape) << describe(shape.error());
            EXPECT_GE(shape->sides.size(), 3U);
            for (const RegionSample& sample : shape->samples) {
                EXPECT_TRUE(sample.goes_on);
                EXPECT_EQ(sample.reach, 3.0);
            }
            EXPECT_EQ(words_for_end(*shape), "none as far as it is drawn");
        }
    }
}

TEST(RegionShape, IsNotSoughtAnyMoreOnRequest)
{
    const Built cube = built(make_cube());
    Progress stopped;
    stopped.cancel();
    const auto shape =
        region_shape(*cube.model, cube.listed, {FeatureKind::vertex, 0}, 1.0, &stopped);
    ASSERT_FALSE(shape);
    EXPECT_EQ(code_of(shape), ErrorCode::cancelled);
}

TEST(RegionShape, EndsHalfwayBetweenTwoCubes)
{
    constexpr double gap = 0.5;
    const Built cubes = built(two_cubes(gap));
    const double facing = make_cube().positions()[0].cwiseAbs().x(); // the side of the first one
    std::array<std::size_t, 3> ended = {};
    for (const FeatureKind kind : kinds) {
        for (std::uint32_t id = 0; id < cubes.count(kind); ++id) {
            const auto shape = region_shape(*cubes.model, cubes.listed, {kind, id}, 4.0);
            ASSERT_TRUE(shape) << describe(shape.error());
            for (const RegionSample& sample : shape->samples) {
                if (sample.base.x() != facing || sample.direction.x() < 0.2) continue;
                // The other cube mirrors the first one.
                EXPECT_FALSE(sample.goes_on);
                EXPECT_NEAR(sample.end().x(), facing + 0.5 * gap, 1e-6);
                ++ended[static_cast<std::size_t>(kind)];
            }
        }
    }
    for (const std::size_t count : ended) EXPECT_GT(count, 50U);
}

TEST(RegionShape, EndsWhereAnotherFeatureIsAsNear)
{
    std::size_t ending = 0;
    std::size_t going_on = 0;
    for (const char* const name : {"torus:20x10", "spaceship:2000"}) {
        const Built shape_of = built(sample_mesh(name).value());
        const double length = 0.7 * shape_of.model->box.extent().norm();
        for (const FeatureKind kind : kinds) {
            for (std::uint32_t id = 0; id < shape_of.count(kind); id += 37) {
                const auto shape =
                    region_shape(*shape_of.model, shape_of.listed, {kind, id}, length);
                ASSERT_TRUE(shape) << describe(shape.error());
                for (std::size_t i = 0; i < shape->samples.size(); i += 5) {
                    const RegionSample& sample = shape->samples[i];
                    const double near = 0.97 * sample.reach;
                    EXPECT_GE(shape_of.distance(sample.at(near)), near * (1.0 - 1e-7))
                        << name << " feature " << id << " sample " << i;
                    if (sample.goes_on) {
                        ++going_on;
                        continue;
                    }
                    ++ending;
                    // A corner beside an edge that is bent inward has no region at all.
                    const double beyond = 1.03 * sample.reach + 1e-3 * length;
                    EXPECT_LT(shape_of.distance(sample.at(beyond)), beyond)
                        << name << " feature " << id << " sample " << i;
                }
            }
        }
    }
    EXPECT_GT(ending, 200U);
    EXPECT_GT(going_on, 200U);
}

TEST(RegionShape, IsDrawnOpenWhereItContinues)
{
    const Built cubes = built(two_cubes(0.5));
    const auto triangles_of = [&](const RegionShape& shape) {
        DrawnScene scene;
        add_region(scene, shape, srgb(0x4A7FD0));
        std::size_t count = 0;
        for (const SceneSurface& surface : scene.surfaces) count += surface.triangles.size();
        return std::pair(scene.surfaces.size(), count);
    };
    bool has_ended = false;
    bool has_gone_on = false;
    for (std::uint32_t id = 0; id < cubes.count(FeatureKind::face); ++id) {
        const auto shape = region_shape(*cubes.model, cubes.listed, {FeatureKind::face, id}, 4.0);
        ASSERT_TRUE(shape);
        const auto [surfaces, triangles] = triangles_of(*shape);
        const std::size_t around = 2 * 3 * (shape->sides[0].size() - 1);
        if (std::ranges::all_of(shape->samples, &RegionSample::goes_on)) {
            EXPECT_GT(surfaces, 1U) << "it fades";
            EXPECT_EQ(triangles, surfaces * around) << "it has no end";
            has_gone_on = true;
        } else {
            EXPECT_EQ(surfaces, 1U);
            EXPECT_EQ(triangles, around + shape->cap.size());
            has_ended = true;
        }
    }
    EXPECT_TRUE(has_ended);
    EXPECT_TRUE(has_gone_on);
}

TEST(RegionShape, OfConcaveFeaturesLiesBehindTheSurface)
{
    const Built torus = built(make_torus(24, 12));
    std::array<std::size_t, 3> found = {}; // outside, behind, empty
    for (const FeatureKind kind : kinds) {
        for (std::uint32_t id = 0; id < torus.count(kind); id += 5) {
            const auto shape = region_shape(*torus.model, torus.listed, {kind, id}, 1.0);
            ASSERT_TRUE(shape) << describe(shape.error());
            const std::string words = words_for_region(*shape);
            if (shape->shape == ConeShape::empty) {
                EXPECT_TRUE(shape->samples.empty());
                EXPECT_TRUE(words.starts_with("empty: ")) << words;
                ++found[2];
                continue;
            }
            const bool is_behind = shape->side == ConeSide::behind;
            EXPECT_EQ(words.find("behind the surface") != std::string::npos, is_behind) << words;
            ++found[is_behind ? 1 : 0];
            for (std::size_t i = 0; i < shape->samples.size(); i += 7) {
                const RegionSample& sample = shape->samples[i];
                // The ring round its middle line tells inside from outside.
                const Vec3 at = sample.at(0.05);
                const double from_line = std::hypot(std::hypot(at.x(), at.y()) - 1.0, at.z());
                const Vec3 base = sample.base;
                const double of_base = std::hypot(std::hypot(base.x(), base.y()) - 1.0, base.z());
                if (sample.reach > 0.05) {
                    EXPECT_EQ(from_line < of_base, is_behind);
                }
                const double near = 0.97 * sample.reach;
                EXPECT_GE(torus.distance(sample.at(near)), near * (1.0 - 1e-7));
            }
        }
    }
    for (const std::size_t count : found) EXPECT_GT(count, 0U);
}

TEST(RegionShape, OfVerticesInFlatPartsIsALine)
{
    std::vector<Vec3> positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}};
    const Built square = built(
        *make_triangle_mesh(std::move(positions), {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}));
    const auto shape = region_shape(*square.model, square.listed, {FeatureKind::vertex, 4}, 0.3);
    ASSERT_TRUE(shape) << describe(shape.error());
    EXPECT_EQ(words_for_region(*shape), "drawn, a line");
    DrawnScene scene;
    add_region(scene, *shape, srgb(0x4A7FD0));
    EXPECT_TRUE(scene.surfaces.empty());
    double length = 0.0;
    for (const SceneLines& lines : scene.lines)
        for (const auto& segment : lines.segments) length += (segment[1] - segment[0]).norm();
    EXPECT_NEAR(length, 0.3, 1e-12);
}

} // namespace
} // namespace proxima::region_shape_test
