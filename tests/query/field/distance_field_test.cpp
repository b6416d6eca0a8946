#include "proxima/distance_field.h"

#include "code_of.h"
#include "geometry/exact_predicates.h"
#include "index/index_parts.h"
#include "index/test_meshes.h"
#include "proxima/index_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"
#include "query/closest/signed_mesh.h"
#include "query/field/cut_meshes.h"
#include "query/field/search_grid.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <string>
#include <unistd.h>
#include <vector>

namespace proxima::distance_field_test {
namespace {

using namespace testing;

struct Field {
    explicit Field(const PointGrid& g)
        : grid(g), distances(g.point_count()), gradients(g.point_count()), methods(g.point_count())
    {}

    [[nodiscard]] Status fill(const MeshIndex& index, const FieldOptions& options = {})
    {
        return distance_field(index, grid,
                              {.distances = distances, .gradients = gradients, .methods = methods},
                              options);
    }

    PointGrid grid;
    std::vector<double> distances;
    std::vector<Vec3> gradients;
    std::vector<SignMethod> methods;
};

template <class Visit>
void for_each_point(const PointGrid& grid, const Visit& visit)
{
    for (std::uint32_t k = 0; k < grid.size[2]; ++k) {
        for (std::uint32_t j = 0; j < grid.size[1]; ++j) {
            for (std::uint32_t i = 0; i < grid.size[0]; ++i)
                visit(grid.position(i, j, k), grid.point(i, j, k));
        }
    }
}

/// Whether all points have the bits of single queries, beyond the band its width with the sign.
void expect_single_answers(const Signed& of, const PointGrid& grid, double band = HUGE_VAL)
{
    Field all(grid);
    ASSERT_TRUE(all.fill(of.index, {.band = band}));
    std::vector<double> plain(grid.point_count());
    ASSERT_TRUE(distance_field(of.index, grid, {.distances = plain}, {.band = band}));
    std::size_t different = 0;
    std::size_t at = 0;
    for_each_point(grid, [&](std::size_t position, const Vec3& p) {
        EXPECT_EQ(position, at++);
        const SignedDistance single = of.at(p);
        const bool beyond = !(std::abs(single.distance) <= band);
        const double wanted = beyond ? std::copysign(band, single.distance) : single.distance;
        const SignMethod method = beyond ? SignMethod::winding_number : single.method;
        if (all.distances[position] != wanted || plain[position] != wanted ||
            all.methods[position] != method) {
            if (different++ == 0) {
                ADD_FAILURE() << "first at " << p.transpose() << ": " << all.distances[position]
                              << " and alone " << plain[position] << ", not " << wanted;
            }
        }
        const Vec3& gradient = all.gradients[position];
        if (beyond) {
            EXPECT_EQ(gradient, Vec3::Zero());
        } else if (single.distance != 0 && std::isfinite(single.distance)) {
            const Vec3 foot = p - single.distance * gradient;
            EXPECT_LT((foot - single.closest.point).norm(),
                      1e-12 * (p.norm() + std::abs(single.distance)));
            EXPECT_NEAR(gradient.stableNorm(), 1, 1e-12);
            if (single.closest.feature.kind == FeatureKind::face) {
                // However near: along the normal, to the side where the point is or away from it.
                const Triangle t = of.mesh.triangle(single.closest.triangle);
                const double along = gradient.dot(unit_normal({t[0], t[1]}, {t[0], t[2]}));
                const int side = orient3d(t[0], t[1], t[2], p);
                EXPECT_NEAR(along, (single.distance > 0) == (side > 0) ? 1 : -1, 1e-9);
            }
        } else if (const Triangle t = of.mesh.triangle(single.closest.triangle);
                   single.distance == 0 && !is_degenerate(t)) {
            EXPECT_NEAR(gradient.dot(unit_normal({t[0], t[1]}, {t[0], t[2]})), 1, 1e-12);
        } else if (!is_degenerate(t)) {
            EXPECT_NEAR(gradient.norm(), 1, 1e-12);
        }
    });
    EXPECT_EQ(different, 0U);
}

PointGrid grid_of(const TriangleMesh& mesh, std::uint32_t resolution, double margin = 0.1)
{
    return grid_around(bounding_box(mesh), {.resolution = resolution, .margin = margin}).value();
}

TEST(DistanceField, HasTheBitsOfSingleQueries)
{
    const std::vector<NamedMesh> meshes = {
        {"sphere", sample_mesh("icosphere:4").value()},
        {"torus", sample_mesh("torus:40x20").value()},
        {"cube", cube_mesh(Vec3(0.3, 0, 0), 1)},
        {"parts that meet", sample_mesh("spaceship:1300").value()},
        {"nested", joined(ball(Vec3::Zero(), 1), inverted(ball(Vec3::Zero(), 0.5)))},
        {"slivers", sliver_strip()},
        {"one triangle", mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}})},
        {"one point", mesh_of({Vec3(1, 2, 3), Vec3(1, 2, 3), Vec3(1, 2, 3)}, {{0, 1, 2}})},
        {"tiny", moved(ball(Vec3::Zero(), 1), [](const Vec3& p) { return Vec3(1e-30 * p); })},
        {"huge", moved(ball(Vec3::Zero(), 1), [](const Vec3& p) { return Vec3(1e30 * p); })},
        {"far away", moved(ball(Vec3::Zero(), 1),
                           [](const Vec3& p) { return Vec3(p + Vec3(1e9, -1e9, 1e9)); })}};
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const Signed of(named.mesh);
        PointGrid grid{.origin = Vec3(0.9, 1.9, 2.9), .spacing = 0.05, .size = {7, 5, 6}};
        if (bounding_box(of.mesh).extent().maxCoeff() > 0) grid = grid_of(of.mesh, 37);
        expect_single_answers(of, grid);
        const double size = grid.spacing * grid.size[0];
        for (const double band : {0.02 * size, 0.3 * size}) expect_single_answers(of, grid, band);
    }
}

TEST(DistanceField, HasThemOnBrokenMeshesAndGridsOfAnyShape)
{
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Signed of(grid_mesh(seed));
        // Points on vertices, edges and faces, and others.
        expect_single_answers(of,
                              {.origin = Vec3(-1, -1, -1), .spacing = 0.5, .size = {13, 11, 12}},
                              seed % 3 == 0 ? 0.7 : HUGE_VAL);
    }
    const Signed of(sample_mesh("icosphere:4").value());
    using Size = std::array<std::uint32_t, 3>;
    for (const Size& size : {Size{1, 1, 1}, Size{70, 1, 1}, Size{1, 66, 2}, Size{33, 3, 34}}) {
        expect_single_answers(of,
                              {.origin = Vec3(-1.1, -0.2, -0.3), .spacing = 0.031, .size = size});
    }
    // From so far that floats tell nothing apart, and farther; with points that are apart by more
    // than the mesh is large.
    for (const double away : {60.0, 70.0, 1e5, 1e160})
        expect_single_answers(of, {.origin = Vec3(away, 1, 0), .spacing = 0.5, .size = {5, 4, 3}});
    expect_single_answers(of,
                          {.origin = Vec3(-100, -90, -80), .spacing = 13, .size = {17, 16, 15}});
}

/// Each triangle with vertices of its own: all edges are border.
TriangleMesh unjoined(const TriangleMesh& mesh)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        const Triangle t = mesh.triangle(TriangleId{id});
        positions.insert(positions.end(), {t[0], t[1], t[2]});
        triangles.push_back({first, first + 1, first + 2});
    }
    return mesh_of(positions, triangles);
}

TEST(DistanceField, HasThemOnOpenMeshes)
{
    const TriangleMesh sphere = sample_mesh("icosphere:4").value();
    const TriangleMesh torus = sample_mesh("torus:40x20").value();
    const std::vector<NamedMesh> meshes = {
        {"small hole", cut_off(sphere, 0.98)},
        {"half", cut_off(sphere, 0)},
        {"bowl", cut_off(sphere, -0.7)},
        {"inside out", inverted(cut_off(sphere, 0.5))},
        {"twice", joined(cut_off(sphere, 0.5), cut_off(sphere, 0.5))},
        {"nested",
         joined(cut_off(sphere, 0.9),
                moved(cut_off(sphere, 0.4), [](const Vec3& p) { return Vec3(0.5 * p); }))},
        {"torus", cut_off(torus, 0.1)},
        {"unjoined", unjoined(sphere)},
        {"far away", moved(cut_off(sphere, 0.5),
                           [](const Vec3& p) { return Vec3(p + Vec3(1e6, 2e6, -1e6)); })}};
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const Signed of(named.mesh);
        ASSERT_FALSE(of.arrays().is_closed());
        expect_single_answers(of, grid_of(of.mesh, 24));
        expect_single_answers(of, grid_of(of.mesh, 3)); // too few points to measure the border
        const Box box = bounding_box(of.mesh);
        // Far finer than the triangles, across the border.
        const Vec3 corner(box.center().x(), box.center().y(), box.upper.z() - 0.1);
        expect_single_answers(of, {.origin = corner, .spacing = 0.011, .size = {34, 12, 18}}, 0.2);
    }
}

TEST(DistanceField, HasThemWhereTrianglesAreFarApartAndFine)
{
    // Blocks with many triangles, with a few, and with one.
    const Signed fine(sample_mesh("torus:300x150").value());
    expect_single_answers(fine, grid_of(fine.mesh, 36));
    const Signed coarse(sample_mesh("icosphere:0").value());
    expect_single_answers(coarse, grid_of(coarse.mesh, 37));
    // In the middle of a ball all triangles are as near.
    const Signed ball(sample_mesh("icosphere:5").value());
    expect_single_answers(
        ball, {.origin = Vec3::Constant(-0.01), .spacing = 0.002, .size = {11, 10, 12}});
}

TEST(DistanceField, HasThemWhereSquaresLeaveTheDoubles)
{
    for (const double size : {1e-200, 1e-160, 1e150, 1e160}) {
        SCOPED_TRACE(size);
        const Signed of(moved(sample_mesh("octahedron").value(),
                              [&](const Vec3& p) { return Vec3(size * p); }));
        const PointGrid grid = grid_of(of.mesh, 8);
        Field field(grid);
        std::vector<double> plain(grid.point_count());
        for (const double band : {HUGE_VAL, 0.4 * size}) {
            ASSERT_TRUE(field.fill(of.index, {.band = band}));
            ASSERT_TRUE(distance_field(of.index, grid, {.distances = plain}, {.band = band}));
            for_each_point(grid, [&](std::size_t at, const Vec3& p) {
                const SignedDistance single = of.at(p);
                const bool beyond = !(std::abs(single.distance) <= band);
                const double wanted =
                    beyond ? std::copysign(band, single.distance) : single.distance;
                EXPECT_EQ(field.distances[at], wanted) << p.transpose();
                EXPECT_EQ(plain[at], wanted) << p.transpose();
            });
        }
    }
}

// Points that are on a face exactly, though not as distances are computed.
TEST(DistanceField, HasThemOnTheSurfaceWithinTheNarrowestBand)
{
    constexpr std::uint32_t seed = 5;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> whole(-(1 << 30), 1 << 30);
    const auto in_plane = [&](double part) {
        const double x = part * std::ldexp(whole(random), -30);
        const double y = part * std::ldexp(whole(random), -30);
        return Vec3(x, y, -(x + y));
    };
    int beside = 0; // as computed
    for (int i = 0; i < 50; ++i) {
        const Vec3 first = in_plane(1);
        const Vec3 second = in_plane(1);
        const Signed of(mesh_of({first, second, -first - second, Vec3(1, 1, 1)},
                                {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
        for (int k = 0; k < 20; ++k) {
            const Vec3 p = in_plane(0.0625);
            expect_single_answers(of, {.origin = p, .spacing = 1, .size = {1, 1, 1}}, 1e-30);
            const SignedDistance single = of.at(p);
            if (single.distance == 0 && single.closest.squared_distance > 0) ++beside;
        }
    }
    EXPECT_GT(beside, 100);
}

// Where points of the grid are a rounding of their coordinates apart.
TEST(DistanceField, HasThemFarFromTheOrigin)
{
    constexpr std::uint32_t seed = 6;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> number(0, 39);
    std::uniform_int_distribution<std::uint32_t> corner(0, 11);
    for (int i = 0; i < 5; ++i) {
        std::vector<Vec3> corners;
        std::vector<TriangleCorners> triangles;
        for (int k = 0; k < 12; ++k) {
            const Vec3 place(number(random), number(random), number(random));
            corners.push_back(Vec3(0x1p50, 0, 0) + 0.25 * place);
            triangles.push_back({corner(random), corner(random), corner(random)});
        }
        const Signed of(mesh_of(corners, triangles));
        expect_single_answers(
            of, {.origin = Vec3(0x1p50 - 1, -1, -1), .spacing = 0.25, .size = {48, 48, 48}});
    }
}

TEST(DistanceField, HasThemFromIndexesThatWereMovedOrSaved)
{
    const TriangleMesh ball = sample_mesh("icosphere:4").value();
    const TriangleMesh bent = moved(ball, [](const Vec3& p) {
        return Vec3(p.x() + 0.3 * p.y() * p.y(), 1.5 * p.y(), p.z() - 0.2 * p.x());
    });
    Signed of(ball);
    of.index =
        with_signs(
            refit_index(build_mesh_index(ball).value(), bent, build_topology(bent).value()).value())
            .value();
    of.mesh = bent;
    expect_single_answers(of, grid_of(bent, 40));
    of.index = with_lists(of.index).value();
    expect_single_answers(of, grid_of(bent, 20));
    const auto file = std::filesystem::temp_directory_path() /
                      ("distance_field_test_" + std::to_string(::getpid()) + ".pxi");
    Signed whole(bent);
    ASSERT_TRUE(save_index(whole.index, file));
    whole.index = load_index(file).value();
    std::filesystem::remove(file);
    expect_single_answers(whole, grid_of(bent, 30));
    // Few points and many triangles: the tree is searched for each.
    const Signed fine(sample_mesh("icosphere:6").value());
    expect_single_answers(fine, grid_of(fine.mesh, 5));
}

TEST(DistanceField, IsThatOfASphere)
{
    const Signed of(sample_mesh("icosphere:5").value());
    Field field(grid_of(of.mesh, 24));
    ASSERT_TRUE(field.fill(of.index));
    for_each_point(field.grid, [&](std::size_t at, const Vec3& p) {
        EXPECT_NEAR(field.distances[at], p.norm() - 1, 1e-3);
        if (p.norm() < 0.2) return;
        EXPECT_GT(field.gradients[at].dot(p.normalized()), 0.99);
    });
}

TEST(DistanceField, IsTheSameForAnyNumberOfThreadsAndCanBeCancelled)
{
    const Signed of(sample_mesh("torus:40x20").value());
    const PointGrid grid = grid_of(of.mesh, 70);
    Field one(grid);
    Field many(grid);
    ASSERT_TRUE(one.fill(of.index, {.execution = {.threads = {1}}}));
    ASSERT_TRUE(many.fill(of.index, {.execution = {.threads = {3}}}));
    EXPECT_EQ(one.distances, many.distances);
    EXPECT_EQ(one.gradients, many.gradients);
    EXPECT_EQ(one.methods, many.methods);
    Progress progress;
    progress.cancel();
    const Status stopped = many.fill(of.index, {.execution = {.progress = &progress}});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(code_of(stopped), ErrorCode::cancelled);
}

TEST(DistanceField, StopsWithinABlock)
{
    const MeshIndex ball = build_mesh_index(sample_mesh("icosphere:5").value()).value();
    // All of the ball is about as near, and each point searches the tree; parts of a block choose
    // among leaves; floats tell nothing.
    for (const PointGrid& grid :
         {PointGrid{.origin = Vec3::Constant(-0.01), .spacing = 0.005, .size = {5, 5, 5}},
          PointGrid{.origin = Vec3::Constant(-1.5), .spacing = 0.1, .size = {32, 32, 32}},
          PointGrid{.origin = Vec3::Constant(70), .spacing = 0.1, .size = {4, 4, 4}}}) {
        SCOPED_TRACE(grid.origin.x());
        Progress progress;
        const auto count_found = [&] {
            std::uint64_t count = 0;
            const auto take = [&](const GridAnswers& answers) {
                count += static_cast<std::uint64_t>(
                    std::ranges::count_if(answers.found, &RowDistance::found));
            };
            const auto side_of = [](const ClearBall&) -> std::optional<bool> { return {}; };
            search_grid(ball.parts(), grid, {.size = grid.size},
                        {HUGE_VAL, false, side_of, take, &progress});
            return count;
        };
        EXPECT_EQ(count_found(), grid.point_count());
        progress.cancel();
        EXPECT_EQ(count_found(), 0U);
    }
}

TEST(DistanceField, CountsTheMemoryOfTheBorderOfAnOpenMesh)
{
    const Signed open(cut_off(sample_mesh("icosphere:4").value(), 0));
    const Signed closed(sample_mesh("icosphere:4").value());
    const auto fill = [](const Signed& of, std::uint32_t resolution, std::uint64_t bytes) {
        return Field(grid_of(of.mesh, resolution))
            .fill(of.index, {.execution = {.budget = {.bytes = bytes}}});
    };
    const std::uint64_t needed = 16 * std::uint64_t{open.mesh.triangle_count()};
    EXPECT_TRUE(fill(open, 16, needed));
    EXPECT_TRUE(fill(open, 3, needed / 2)) << "too few points to measure the border";
    EXPECT_TRUE(fill(closed, 16, needed / 2));
    const Status refused = fill(open, 16, needed / 2);
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::budget_exceeded);
}

TEST(DistanceField, RefusesBadArguments)
{
    const Signed of(sample_mesh("octahedron").value());
    std::vector<double> eight(8);
    const auto refused = [&](const MeshIndex& index, const PointGrid& grid, double band,
                             const std::string& words) {
        const Status status = distance_field(index, grid, {.distances = eight}, {.band = band});
        ASSERT_FALSE(status) << words;
        EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
        EXPECT_NE(status.error().message.find(words), std::string::npos) << status.error().message;
    };
    const PointGrid good{.spacing = 1, .size = {2, 2, 2}};
    refused(build_mesh_index(of.mesh).value(), good, 1, "no signs");
    refused(of.index, {.spacing = 0, .size = {2, 2, 2}}, 1, "spacing");
    refused(of.index, {.spacing = NAN, .size = {2, 2, 2}}, 1, "spacing");
    refused(of.index, {.spacing = 1e308, .size = {2, 2, 9}}, 1, "finite");
    refused(of.index, {.origin = Vec3(NAN, 0, 0), .size = {2, 2, 2}}, 1, "finite");
    refused(of.index, {.size = {2, 0, 2}}, 1, "without points");
    refused(of.index, {.size = {769546, 494770, 48448661}}, 1, "2^40"); // 2^64 + 4 points
    refused(of.index, good, 0, "band");
    refused(of.index, good, NAN, "band");
    refused(of.index, {.size = {2, 2, 3}}, 1, "12 points");
    std::vector<Vec3> gradients(7);
    std::vector<SignMethod> methods(9);
    for (const FieldOutputs& outputs :
         {FieldOutputs{.gradients = gradients}, FieldOutputs{.methods = methods}}) {
        const Status status = distance_field(of.index, good, outputs, {.band = 1});
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().message.find("8 points"), std::string::npos);
    }
    EXPECT_TRUE(distance_field(of.index, good, {}));
}

TEST(DistanceField, GridsReachRoundABox)
{
    const Box box{Vec3(-1, 0, 2), Vec3(1, 0.5, 2)};
    const PointGrid grid = grid_around(box, {.resolution = 11, .margin = 0}).value();
    EXPECT_EQ(grid.size, (std::array<std::uint32_t, 3>{11, 4, 2}));
    EXPECT_DOUBLE_EQ(grid.spacing, 0.2);
    EXPECT_EQ(grid.point(0, 0, 0).x(), -1);
    EXPECT_NEAR(grid.point(10, 0, 0).x(), 1, 1e-15);
    for (const double spacing : {0.1, 0.3, 5.0}) {
        const PointGrid wide = grid_around(box, {.spacing = spacing, .margin = 0.25}).value();
        EXPECT_EQ(wide.spacing, spacing);
        const auto [a, b, c] = wide.size;
        const Box covered{wide.origin, wide.point(a - 1, b - 1, c - 1)};
        EXPECT_TRUE((covered.lower.array() <= box.lower.array() - 0.5 + 1e-12).all());
        EXPECT_TRUE((covered.upper.array() >= box.upper.array() + 0.5 - 1e-12).all());
        EXPECT_TRUE((covered.extent().array() < box.extent().array() + 1 + 2 * spacing).all());
    }
    const auto refused = [](const Box& of, const GridOptions& options) {
        const auto made = grid_around(of, options);
        return !made && made.error().code == ErrorCode::invalid_argument;
    };
    EXPECT_TRUE(refused({}, {}));
    EXPECT_TRUE(refused({Vec3(0, 0, 0), Vec3(0, 0, 0)}, {}));
    EXPECT_TRUE(refused(box, {.resolution = 1}));
    EXPECT_TRUE(refused(box, {.margin = -1}));
    EXPECT_TRUE(refused(box, {.spacing = NAN}));
    EXPECT_TRUE(refused(box, {.margin = 1e308}));
    // Too many points are the fault of the option that was given.
    const auto too_many = [&](const GridOptions& options) {
        const Error error = grid_around(box, options).error();
        return error.where + ": " + error.message.substr(0, error.message.find(" makes "));
    };
    EXPECT_EQ(too_many({.spacing = 1e-6}), "spacing: a spacing of 1e-06");
    EXPECT_EQ(too_many({.resolution = 1U << 20U}), "resolution: a resolution of 1048576");
    const Box line{Vec3(0, 0, 0), Vec3(1, 0, 0)};
    EXPECT_EQ(grid_around(line, {.spacing = 0x1p-31, .margin = 0}).error().where, "spacing");
    EXPECT_EQ(grid_around(line, {.resolution = (1U << 31U) + 1U, .margin = 0}).error().where,
              "resolution");
}

} // namespace
} // namespace proxima::distance_field_test
