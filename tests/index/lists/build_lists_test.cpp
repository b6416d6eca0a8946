// The answers of lists are those of brute force, for any mesh, budget, place and instruction set.
#include "index/listed_index.h"

#include "base/simd.h"
#include "cancellation.h"
#include "code_of.h"
#include "counted_allocations.h"
#include "index/index_parts.h"
#include "index/lists/grow_cells.h"
#include "index/lists/local_features.h"
#include "index/lists/proximity_lists.h"
#include "index/lists/query_density.h"
#include "index/lists/root_frame.h"
#include "index/test_meshes.h"
#include "proxima/closest_feature.h"
#include "proxima/sample_meshes.h"
#include "query/closest/brute_force.h"
#include "query/closest/find_closest.h"

#include <array>
#include <cmath>
#include <cstring>
#include <ctime>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace proxima::build_lists_test {
namespace {

using testing::NamedMesh;
using testing::proximity_meshes;
using testing::proximity_points;

MeshIndex build(const TriangleMesh& mesh, const ListOptions& options = {})
{
    auto index = testing::listed_index(mesh, options);
    EXPECT_TRUE(index) << describe(index.error());
    return *index;
}

/// Points where cells and regions meet: corners of cells, points straight above vertices and sides.
std::vector<Vec3> boundary_points(const TriangleMesh& mesh, const RootFrame& frame, int count,
                                  unsigned seed)
{
    std::mt19937_64 random(seed);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis) {
            const double cells = std::ldexp(1.0, static_cast<int>(random() % 10));
            const double part =
                static_cast<double>(random() % static_cast<std::uint64_t>(cells + 1));
            point[axis] = frame.center[axis] + frame.half * (2 * part / cells - 1);
        }
        points.push_back(point);
        const Triangle triangle =
            mesh.triangle(TriangleId{static_cast<std::uint32_t>(random() % mesh.triangle_count())});
        const Vec3 normal = scaled_normal(triangle);
        const double length = normal.norm();
        if (!(length > 0)) continue;
        const double height = frame.half * std::ldexp(1.0, -static_cast<int>(random() % 12));
        points.emplace_back(triangle[0] + height / length * normal);
        points.emplace_back(0.5 * triangle[0] + 0.5 * triangle[1] - height / length * normal);
    }
    return points;
}

/// Whether two answers have the same bits.
bool same_answer(const ClosestFeature& a, const ClosestFeature& b)
{
    return a.feature == b.feature && a.triangle == b.triangle && a.point == b.point &&
           a.barycentric == b.barycentric && a.squared_distance == b.squared_distance;
}

/// Bit for bit those of brute force, within the promised number of steps.
void expect_answers(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology,
                    std::span<const Vec3> points)
{
    for (const Vec3& p : points) {
        QuerySteps steps;
        const ClosestFeature found = closest_feature(index, p, {}, steps).value();
        ASSERT_TRUE(same_answer(found, closest_feature_by_brute_force(mesh, topology, p)))
            << "at " << p.transpose();
        if (index.parts().lists()->frame().contains(p)) {
            ASSERT_LE(steps.steps, index.parts().lists()->statistics().worst_case_steps);
            ASSERT_LE(steps.blocks, index.parts().lists()->statistics().worst_case_blocks);
        }
    }
}

TEST(Lists, AnswerLikeBruteForce)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const auto topology = build_topology(named.mesh);
        ASSERT_TRUE(topology);
        for (const std::uint64_t bytes_per_triangle : {125ULL, 325ULL, 525ULL, 12000ULL}) {
            SCOPED_TRACE(bytes_per_triangle);
            ListOptions options;
            options.list_bytes = bytes_per_triangle * named.mesh.triangle_count() + 4096;
            const MeshIndex index = build(named.mesh, options);
            EXPECT_LE(index.parts().lists()->bytes(), options.list_bytes);
            expect_answers(index, named.mesh, *topology, proximity_points(named.mesh, 200, 1));
            expect_answers(index, named.mesh, *topology,
                           boundary_points(named.mesh, index.parts().lists()->frame(), 60, 2));
        }
    }
}

/// Triangles in turn at each of six places, each with vertices of its own: points, or all of a size.
TriangleMesh triangles_at_six_places(std::uint32_t count, bool are_points)
{
    const std::array<Vec3, 6> places = {Vec3(0, 0, 0), Vec3(1, 0, 0),   Vec3(0, 1, 0),
                                        Vec3(0, 0, 1), Vec3(1, 1, 0.5), Vec3(0.3, 0.2, 0.9)};
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t k = 0; k < 3; ++k)
            positions.push_back(places[(i + (are_points ? 0 : k)) % places.size()]);
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        if (are_points) triangles.back() = {3 * i, 3 * i, 3 * i};
    }
    return testing::mesh_of(std::move(positions), std::move(triangles));
}

TEST(Lists, OfABallAreNotLongAboutItsCenter)
{
    // All triangles are about equally near there: cells are split until they are not.
    const TriangleMesh ball = sample_mesh("icosphere:4").value();
    EXPECT_LT(build(ball).parts().lists()->statistics().max_list, ball.triangle_count() / 6);
}

TEST(Lists, AreBuiltInReasonWhereManyTrianglesAreInTheSamePlace)
{
    for (const bool are_points : {true, false}) {
        SCOPED_TRACE(are_points);
        const auto seconds = [&](std::uint32_t count) {
            const MeshIndex index =
                build_mesh_index(triangles_at_six_places(count, are_points)).value();
            const std::clock_t start = std::clock();
            EXPECT_TRUE(with_lists(index));
            return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        };
        // Cells that cannot tell them apart were split to the last level: 80 and more times as long.
        EXPECT_LT(seconds(480), 20 * seconds(240) + 0.1);
        const TriangleMesh mesh = triangles_at_six_places(240, are_points);
        const auto topology = build_topology(mesh);
        ASSERT_TRUE(topology);
        expect_answers(build(mesh), mesh, *topology, proximity_points(mesh, 300, 4));
    }
}

/// A cube, and triangles without area at its middle, each with vertices of its own.
TriangleMesh cube_with_points_at_its_middle(std::uint32_t count)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    std::vector<Vec3> positions(cube.positions().begin(), cube.positions().end());
    std::vector<TriangleCorners> triangles(cube.triangles().begin(), cube.triangles().end());
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        positions.insert(positions.end(), 3, Vec3::Zero());
        triangles.push_back({first, first + 1, first + 2});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles)).value();
}

/// What cells are grown from.
struct Grown {
    explicit Grown(const TriangleMesh& mesh)
        : index(build_mesh_index(mesh).value()), bounds(checked_bounding_box(mesh).value()),
          frame(make_root_frame(bounds, ListOptions{}.margin)),
          features(collect_local_features(mesh, build_topology(mesh).value(), index.ids(), frame,
                                          nullptr)
                       .value()),
          density(QueryDensity::sample(mesh, bounds, frame, nullptr).value())
    {}

    [[nodiscard]] GrownTop top(const GrowOptions& options = {}) const
    {
        return grow_top(features, density, frame.frame_half(), options).value();
    }
    /// Grows a tree below each of the open cells.
    [[nodiscard]] std::vector<GrownTree> below(const GrownTop& top,
                                               const GrowOptions& options) const
    {
        std::vector<const OpenCell*> open;
        for (const OpenCell& cell : top.open) open.push_back(&cell);
        return grow_below(features, density, open, options).value();
    }

    MeshIndex index;
    Box bounds;
    RootFrame frame;
    LocalFeatures features;
    QueryDensity density;
};

TEST(Lists, TopmostCellsAreNotSplitWhereNearlyAllOfThemKeepNearlyAll)
{
    const Grown grown(cube_with_points_at_its_middle(300));
    std::size_t open = 0;
    for (const OpenCell& cell : grown.top().open) open += cell.features.size();
    // Split to the fourth level, they list the features 204 times.
    EXPECT_LT(open, 200 * grown.features.features.size());
}

TEST(Lists, GrowWithinLimits)
{
    const Grown grown(sample_mesh("icosphere:3").value());
    // The root's list alone has a byte for each triangle.
    const GrownTop small = grown.top({.most_list_bytes = 4000});
    EXPECT_LE(small.tree.lists.size(), 4000U);
    EXPECT_GE(small.open.size(), 1U);
    const GrownTop top = grown.top();
    GrowOptions options = {.cost = {.price = 0x1p-40}};
    const auto longest = [&] {
        std::size_t most = 0;
        for (const GrownTree& tree : grown.below(top, options))
            most = std::max(most, tree.lists.size());
        return most;
    };
    const std::size_t free = longest();
    options.most_list_bytes = free / 4;
    EXPECT_LT(longest(), free / 2);
}

TEST(Lists, AreNoLargerThanAskedForAndUseWhatTheyMay)
{
    for (const char* const name :
         {"icosphere:3", "spaceship:1300", "sphere:16x20", "torus:30x40"}) {
        const TriangleMesh mesh = sample_mesh(name).value();
        const auto topology = build_topology(mesh);
        for (const std::uint64_t bytes : {1024U, 8000U, 80000U}) {
            for (const int depth : {0, 2, 14}) {
                SCOPED_TRACE(std::string(name) + ' ' + std::to_string(bytes));
                const MeshIndex index = build(mesh, {.list_bytes = bytes, .max_depth = depth});
                EXPECT_LE(index.parts().lists()->bytes(), bytes) << depth;
                expect_answers(index, mesh, *topology, proximity_points(mesh, 20, 4));
            }
        }
    }
    // Deeper cells are never worse than coarser ones of the same size.
    const TriangleMesh sphere = sample_mesh("sphere:16x20").value();
    const auto expected = [&](int depth) {
        return build(sphere, {.list_bytes = 40000, .max_depth = depth})
            .parts()
            .lists()
            ->statistics()
            .expected_list;
    };
    EXPECT_LT(expected(14), 1.05 * expected(2));
}

TEST(Lists, RootsContainWhatIsRoundedOutOfTheMiddle)
{
    // The middle of the box rounds to one of its ends.
    const TriangleMesh mesh =
        make_triangle_mesh({Vec3(1, 0, 0), Vec3(1 + 0x1p-52, 0, 0)}, {{0, 1, 1}}).value();
    EXPECT_DOUBLE_EQ(build(mesh).parts().lists()->frame().half, 0x1p-52);
    for (const auto& [margin, half] :
         {std::pair{0.0, 1.0}, std::pair{1.0, 2.0}, std::pair{3.0, 4.0}}) {
        const MeshIndex index = build(sample_mesh("cube").value(), {.margin = margin});
        EXPECT_DOUBLE_EQ(index.parts().lists()->frame().half, half);
    }
}

TEST(Lists, AnswerAtAnyScale)
{
    const TriangleMesh sphere = testing::sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 16);
    for (const double scale : {1e-120, 1e-30, 1e-6, 1e6, 1e30, 1e120}) {
        SCOPED_TRACE(scale);
        const TriangleMesh mesh =
            testing::moved(sphere, [&](const Vec3& p) { return Vec3(scale * p); });
        const auto topology = build_topology(mesh);
        ASSERT_TRUE(topology);
        const MeshIndex index = build(mesh);
        expect_answers(index, mesh, *topology, proximity_points(mesh, 300, 3));
    }
}

TEST(Lists, TiesGoToTheLowestDimensionAndId)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const auto topology = build_topology(cube);
    const MeshIndex index = build(cube);
    const Box box = bounding_box(cube);
    // The centre is as far from all faces; points on the diagonals from three of them.
    for (int i = 0; i < 27; ++i) {
        const Vec3 at(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        const Vec3 p = box.center() + 0.25 * box.extent().cwiseProduct(at);
        const ClosestFeature truth = closest_feature_by_brute_force(cube, *topology, p);
        const ClosestFeature found = closest_feature(index, p).value();
        EXPECT_EQ(found.feature, truth.feature) << p.transpose();
        EXPECT_EQ(found.triangle, truth.triangle);
        EXPECT_EQ(found.squared_distance, truth.squared_distance);
    }
}

TEST(Lists, HaveTheSameBitsForAnyThreadsAndInstructionSet)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    const std::vector<Vec3> points = proximity_points(mesh, 500, 4);
    const MeshIndex one = build(mesh, {.execution = {.threads = {1}}});
    std::vector<ClosestFeature> answers(points.size());
    ASSERT_TRUE(closest_features(one, points, {.answers = answers}));
    const auto expect_same = [&](const MeshIndex& other) {
        const ProximityArrays& a = one.parts().lists()->arrays();
        const ProximityArrays& b = other.parts().lists()->arrays();
        EXPECT_TRUE(std::ranges::equal(a.table, b.table));
        EXPECT_TRUE(std::ranges::equal(a.nodes, b.nodes));
        EXPECT_TRUE(std::ranges::equal(a.arena, b.arena));
        EXPECT_EQ(one.parts().lists()->statistics(), other.parts().lists()->statistics());
        for (std::size_t i = 0; i < points.size(); ++i)
            ASSERT_TRUE(same_answer(answers[i], closest_feature(other, points[i]).value())) << i;
    };
    for (const int threads : {2, 3, 8})
        expect_same(build(mesh, {.execution = {.threads = {threads}}}));
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        expect_same(build(mesh, {.execution = {.threads = {2}}}));
        restore_simd_targets();
    }
}

TEST(Lists, BatchesAnswerLikeSingleQueries)
{
    const TriangleMesh mesh = sample_mesh("spaceship:1300").value();
    const MeshIndex index = build(mesh);
    const std::vector<Vec3> points = proximity_points(mesh, 9001, 5);
    std::vector<ClosestFeature> answers(points.size());
    for (const int threads : {1, 2}) {
        for (const BatchOrder order :
             {BatchOrder::automatic, BatchOrder::as_given, BatchOrder::sorted}) {
            std::ranges::fill(answers, ClosestFeature{});
            ASSERT_TRUE(closest_features(index, points, {.answers = answers},
                                         {.order = order, .execution = {.threads = {threads}}}));
            for (std::size_t i = 0; i < points.size(); ++i) {
                ASSERT_TRUE(same_answer(answers[i], closest_feature(index, points[i]).value()))
                    << i;
            }
        }
    }
}

TEST(Lists, RefuseInvalidBatches)
{
    const MeshIndex index = build(sample_mesh("cube").value());
    std::vector<Vec3> points(5000, Vec3::Zero());
    std::vector<ClosestFeature> answers(points.size());
    EXPECT_EQ(code_of(closest_features(index, points, {.answers = std::span(answers).first(3)})),
              ErrorCode::invalid_argument);
    points[4321][1] = std::numeric_limits<double>::quiet_NaN();
    points[4999][1] = std::numeric_limits<double>::infinity();
    for (const BatchOrder order : {BatchOrder::automatic, BatchOrder::sorted}) {
        const Status status = closest_features(index, points, {.answers = answers},
                                               {.order = order, .execution = {.threads = {2}}});
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().message.find("4321"), std::string::npos) << status.error().message;
    }
}

TEST(Lists, FindNothingBeyondTheRadius)
{
    const MeshIndex index = build(sample_mesh("cube").value());
    const double edge = index.parts().lists()->frame().half;
    const Vec3 p = index.parts().lists()->frame().center + Vec3(10 * edge, 0, 0);
    const double distance = std::sqrt(closest_feature(index, p)->squared_distance);
    EXPECT_FALSE(closest_feature(index, p, {.radius = 0.999 * distance}));
    EXPECT_TRUE(closest_feature(index, p, {.radius = 1.001 * distance}));
}

TEST(Lists, SearchLessFromAnEarlierAnswer)
{
    const TriangleMesh mesh = sample_mesh("torus:60x40").value();
    const MeshIndex index = build(mesh, {.list_bytes = 125 * mesh.triangle_count()});
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> part(-1, 1);
    const auto step = [&](double length) {
        return Vec3(length * part(random), length * part(random), length * part(random));
    };
    QuerySteps cold;
    QuerySteps warm;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = step(4);
        const Vec3 near = p + step(1e-3);
        const ClosestFeature earlier = closest_feature(index, near).value();
        const ClosestFeature found = closest_feature(index, p, {}, cold).value();
        const ClosestFeature again =
            closest_feature(index, p, {.start_from = &earlier}, warm).value();
        ASSERT_EQ(again.feature, found.feature);
        ASSERT_EQ(again.squared_distance, found.squared_distance);
    }
    EXPECT_LT(warm.blocks, cold.blocks);
    EXPECT_LT(warm.rechecks, cold.rechecks);
}

TEST(Lists, QueriesDoNotAllocate)
{
    const TriangleMesh mesh = sample_mesh("sphere:20x20").value();
    const MeshIndex index = build(mesh, {.list_bytes = 175 * mesh.triangle_count()});
    const std::vector<Vec3> points = proximity_points(mesh, 500, 6);
    const std::size_t before = testing::allocation_count();
    double sum = 0;
    for (const Vec3& p : points) sum += closest_feature(index, p)->squared_distance;
    EXPECT_EQ(testing::allocation_count(), before);
    EXPECT_GT(sum, 0);
}

TEST(Lists, RefuseInvalidMeshesAndOptions)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const auto code = [](const Result<MeshIndex>& result) { return code_of(result); };
    EXPECT_EQ(code(testing::listed_index(TriangleMesh())), ErrorCode::invalid_mesh);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const TriangleMesh broken =
        make_triangle_mesh({Vec3(0, 0, nan), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}}).value();
    EXPECT_EQ(code(testing::listed_index(broken)), ErrorCode::invalid_mesh);
    EXPECT_EQ(code(testing::listed_index(cube, {.margin = -1})), ErrorCode::invalid_argument);
    EXPECT_EQ(code(testing::listed_index(cube, {.margin = nan})), ErrorCode::invalid_argument);
    EXPECT_EQ(code(testing::listed_index(cube, {.max_depth = 15})), ErrorCode::invalid_argument);
    const auto small = testing::listed_index(cube, {.list_bytes = 100});
    EXPECT_EQ(code(small), ErrorCode::budget_exceeded);
    EXPECT_NE(small.error().message.find("at least"), std::string::npos);
    EXPECT_EQ(code(testing::listed_index(sample_mesh("torus:30x40").value(),
                                         {.execution = {.budget = {1'000'000}}})),
              ErrorCode::budget_exceeded);
}

TEST(Lists, TakeOfTheirBudgetWhatThereIsRoomFor)
{
    const TriangleMesh mesh = sample_mesh("icosphere:4").value();
    const MeshIndex plain = build_mesh_index(mesh).value();
    const std::uint64_t scratch = 800 * mesh.triangle_count();
    const std::uint64_t usual = default_list_bytes(mesh.triangle_count());
    constexpr std::uint64_t endless = std::numeric_limits<std::uint64_t>::max();
    const auto bytes = [&](std::uint64_t list_bytes, std::uint64_t budget) {
        const auto index =
            with_lists(plain, {.list_bytes = list_bytes, .execution = {.budget = {budget}}});
        return index ? index->parts().lists()->bytes() : 0;
    };
    const std::uint64_t most = bytes(endless, 0);
    EXPECT_GT(most, usual);
    EXPECT_EQ(bytes(endless, scratch + usual - 1), 0U);
    EXPECT_EQ(bytes(0, scratch + usual - 1), 0U);
    EXPECT_GT(bytes(usual / 2, scratch + usual - 1), 0U);
    const std::uint64_t room = (usual + most) / 2;
    const std::uint64_t bounded = bytes(endless, scratch + 4 * room);
    EXPECT_LE(bounded, room);
    EXPECT_GT(bounded, usual / 2);
    EXPECT_LT(bounded, most);
}

TEST(Lists, StopOnRequest)
{
    const TriangleMesh mesh = sample_mesh("torus:30x40").value();
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return testing::listed_index(mesh, {.execution = {.progress = &progress}});
        },
        [] { return true; });
}

} // namespace
} // namespace proxima::build_lists_test
