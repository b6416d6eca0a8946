#include "haptics/surface/triangle_tree.h"

#include "base/simd.h"
#include "code_of.h"
#include "counted_allocations.h"
#include "index/test_meshes.h"
#include "mesh/triangle_order.h"
#include "oracles/quad_distance.h"

#include <gtest/gtest.h>

namespace proxima::triangle_tree_test {
namespace {

using namespace testing;

std::vector<TriangleId> order_of(const TriangleMesh& mesh)
{
    const auto items = triangle_order(mesh, bounding_box(mesh), SpaceCurve::hilbert, nullptr);
    std::vector<TriangleId> order;
    for (const KeyedIndex& item : *items) order.push_back(TriangleId{item.index});
    return order;
}

/// Tight box of a group.
Box group_box(const TriangleMesh& mesh, std::span<const TriangleId> ids)
{
    Box box;
    for (const TriangleId id : ids) {
        for (const Vec3& vertex : mesh.triangle(id).vertices) box.extend(vertex);
    }
    return box;
}

/// Squared distance of two boxes in numbers that do not round.
oracle::Quad squared_gap(const Box& a, const Box& b)
{
    oracle::Quad sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const oracle::Quad before = oracle::Quad(a.lower[axis]) - b.upper[axis];
        const oracle::Quad behind = oracle::Quad(b.lower[axis]) - a.upper[axis];
        const oracle::Quad gap = std::max({before, behind, oracle::Quad(0)});
        sum += gap * gap;
    }
    return sum;
}

/// Checks that all groups within the distance are visited, each once, and few others.
void expect_all_within(const TriangleMesh& mesh, const std::vector<TriangleId>& order,
                       const TriangleTree& tree, const Box& query, double distance)
{
    std::vector<int> visits((order.size() + 7) / 8, 0);
    std::uint32_t triangles = 0;
    visit_within(tree, query, distance * distance, [&](RowRange ranks) noexcept {
        EXPECT_EQ(ranks.first % 8, 0U);
        EXPECT_LE(ranks.first + ranks.count, order.size());
        triangles += ranks.count;
        ++visits[ranks.first / 8];
    });
    std::uint32_t expected_triangles = 0;
    const Box bounds = bounding_box(mesh);
    const double slack =
        1e-6 * bounds.extent().maxCoeff() +
        1e-14 * std::max({bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff(),
                          query.lower.cwiseAbs().maxCoeff(), distance});
    for (std::size_t group = 0; group < visits.size(); ++group) {
        const std::size_t count = std::min<std::size_t>(8, order.size() - 8 * group);
        const oracle::Quad squared =
            squared_gap(group_box(mesh, std::span(order).subspan(8 * group, count)), query);
        EXPECT_LE(visits[group], 1);
        expected_triangles += static_cast<std::uint32_t>(visits[group] * count);
        if (squared <= oracle::Quad(distance) * distance) {
            EXPECT_EQ(visits[group], 1) << "group " << group;
        }
        const oracle::Quad far = oracle::Quad(distance) + 2 * slack;
        if (squared > far * far) {
            EXPECT_EQ(visits[group], 0) << "group " << group;
        }
    }
    EXPECT_EQ(triangles, expected_triangles);
}

TEST(TriangleTree, VisitsAllGroupsWithinADistanceAndNoOthers)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const std::vector<TriangleId> order = order_of(mesh);
        const auto tree = build_triangle_tree(mesh, order);
        ASSERT_TRUE(tree);
        EXPECT_EQ(tree->triangle_count(), mesh.triangle_count());
        const double size = bounding_box(mesh).extent().maxCoeff();
        std::mt19937 random(4);
        const auto below = [&](unsigned n) { return static_cast<int>(random() % n); };
        for (const Vec3& p : proximity_points(mesh, 60, 5)) {
            const double distance = std::ldexp(size, -below(12));
            expect_all_within(mesh, order, *tree, {p, p}, distance);
            const Vec3 half =
                0.1 * size * Eigen::Vector3i{below(3), below(3), below(3)}.cast<double>();
            expect_all_within(mesh, order, *tree, {p - half, p + half}, below(2) * distance);
        }
    }
}

TEST(TriangleTree, HasTheRightShapeForAnyNumberOfTriangles)
{
    // Numbers of triangles round the powers of eight, where levels end.
    for (const std::uint32_t count : {1U, 7U, 8U, 9U, 63U, 64U, 65U, 512U, 513U, 4097U}) {
        SCOPED_TRACE(count);
        std::vector<Vec3> positions;
        std::vector<TriangleCorners> triangles;
        for (std::uint32_t i = 0; i < count; ++i) {
            positions.emplace_back(i, 0.5 * (i % 3), 0);
            triangles.push_back({i, i, i});
        }
        const TriangleMesh mesh = mesh_of(std::move(positions), std::move(triangles));
        std::vector<TriangleId> order(count);
        for (std::uint32_t i = 0; i < count; ++i) order[i] = TriangleId{i};
        const TriangleTree tree = build_triangle_tree(mesh, order).value();
        EXPECT_EQ(tree.levels().back().entries, std::min((count + 7) / 8, [&] {
                      std::uint32_t entries = (count + 7) / 8;
                      while (entries > 8) entries = (entries + 7) / 8;
                      return entries;
                  }()));
        for (const double at : {-3.0, 0.0, 0.4 * count, count - 1.0, 2.0 * count}) {
            expect_all_within(mesh, order, tree, {Vec3(at, 0, 0), Vec3(at, 0, 0)}, 5.0);
        }
    }
}

TEST(TriangleTree, VisitsNearGroupsFirstAndObeysTheBound)
{
    const TriangleMesh mesh = sample_mesh("sphere:60x60").value();
    const std::vector<TriangleId> order = order_of(mesh);
    const TriangleTree tree = build_triangle_tree(mesh, order).value();
    for (const Vec3& p : proximity_points(mesh, 200, 6)) {
        // Each group lowers the bound to its own box: what is left must be nearer.
        double bound = std::numeric_limits<double>::infinity();
        double nearest = bound;
        int visits = 0;
        visit_nearest(tree, p, bound, [&](RowRange ranks) noexcept {
            const Box box = group_box(mesh, std::span(order).subspan(ranks.first, ranks.count));
            const auto squared = static_cast<double>(squared_gap(box, {p, p}));
            EXPECT_LE(squared, bound * (1 + 1e-5) + 1e-6);
            nearest = std::min(nearest, squared);
            bound = nearest;
            ++visits;
            return bound;
        });
        double truth = std::numeric_limits<double>::infinity();
        for (std::size_t group = 0; 8 * group < order.size(); ++group) {
            const std::size_t count = std::min<std::size_t>(8, order.size() - 8 * group);
            const Box box = group_box(mesh, std::span(order).subspan(8 * group, count));
            truth = std::min(truth, static_cast<double>(squared_gap(box, {p, p})));
        }
        EXPECT_EQ(nearest, truth);
        // The nearest group of 885 lies in the first node of eight, or in one beside it.
        EXPECT_LE(visits, 2 * 8);
    }
    int visits = 0;
    visit_nearest(tree, Vec3(0, 0, 5), 1.0, [&](RowRange) noexcept {
        ++visits;
        return 1.0;
    });
    EXPECT_EQ(visits, 0);
}

TEST(TriangleTree, AnswersForAnyFinitePoint)
{
    const TriangleMesh mesh = sample_mesh("icosphere:2").value();
    const std::vector<TriangleId> order = order_of(mesh);
    const TriangleTree tree = build_triangle_tree(mesh, order).value();
    for (const double far : {1e3, 1e9, 1e18, 1e100, 1e160, 1.7e308}) {
        SCOPED_TRACE(far);
        // The pole is closest to points above: the group that has it must be seen.
        bool seen = false;
        const Vec3 p(0.1 * far, 0.05 * far, far);
        double bound = std::numeric_limits<double>::infinity();
        visit_nearest(tree, p, bound, [&](RowRange ranks) noexcept {
            for (const TriangleId id : std::span(order).subspan(ranks.first, ranks.count)) {
                for (const Vec3& vertex : mesh.triangle(id).vertices) {
                    bound = std::min(bound, (p - vertex).squaredNorm());
                }
            }
            seen = true;
            return bound;
        });
        EXPECT_TRUE(seen);
        double truth = std::numeric_limits<double>::infinity();
        for (const Vec3& vertex : mesh.positions()) {
            truth = std::min(truth, (p - vertex).squaredNorm());
        }
        EXPECT_EQ(bound, truth);
    }
}

TEST(TriangleTree, HasTheSameBitsForAnyThreadsAndInstructions)
{
    const TriangleMesh mesh = sample_mesh("spaceship:20000").value();
    const std::vector<TriangleId> order = order_of(mesh);
    const TriangleTree one = build_triangle_tree(mesh, order, {.threads = {1}}).value();
    const TriangleTree three = build_triangle_tree(mesh, order, {.threads = {3}}).value();
    ASSERT_EQ(one.blocks().size(), three.blocks().size());
    for (std::size_t i = 0; i < one.blocks().size(); ++i) {
        EXPECT_EQ(one.blocks()[i].lower, three.blocks()[i].lower);
        EXPECT_EQ(one.blocks()[i].upper, three.blocks()[i].upper);
    }
    EXPECT_LT(one.bytes(), 4 * mesh.triangle_count());

    std::vector<std::vector<std::uint32_t>> walks;
    for (const SimdTarget& target : simd_targets()) {
        force_simd_target(target);
        walks.emplace_back();
        for (const Vec3& p : proximity_points(mesh, 50, 7)) {
            visit_within(one, {p, p}, 0.01,
                         [&](RowRange ranks) noexcept { walks.back().push_back(ranks.first); });
        }
    }
    restore_simd_targets();
    for (const auto& walk : walks) EXPECT_EQ(walk, walks.front());
}

TEST(TriangleTree, DoesNotAllocateInQueries)
{
    const TriangleMesh mesh = sample_mesh("sphere:40x40").value();
    const TriangleTree tree = build_triangle_tree(mesh, order_of(mesh)).value();
    std::uint32_t groups = 0;
    const std::size_t before = allocation_count();
    visit_within(tree, {Vec3(0, 0, 0), Vec3(1, 1, 1)}, 0.5, [&](RowRange) noexcept { ++groups; });
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(groups, 10U);
    EXPECT_EQ(before > 10, allocations_are_counted());
}

TEST(TriangleTree, RefusesInvalidMeshesAndStopsOnRequest)
{
    EXPECT_EQ(code_of(build_triangle_tree(TriangleMesh{}, {})), ErrorCode::invalid_mesh);
    const auto scaled = [](double scale) {
        return moved(cube_mesh(Vec3::Zero(), 1.0), [&](const Vec3& p) { return Vec3(scale * p); });
    };
    std::vector<TriangleId> order(12);
    for (std::uint32_t i = 0; i < 12; ++i) order[i] = TriangleId{i};
    for (const double scale : {std::nan(""), 1e150, 1e308}) {
        EXPECT_EQ(code_of(build_triangle_tree(scaled(scale), order)), ErrorCode::invalid_mesh);
    }
    EXPECT_TRUE(build_triangle_tree(scaled(1e149), order));
    EXPECT_TRUE(build_triangle_tree(scaled(1e-300), order));
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(build_triangle_tree(scaled(1.0), order, {.progress = &progress})),
              ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::triangle_tree_test
