#include "octree/classify_cells.h"

#include "code_of.h"
#include "octree/check_structure.h"
#include "octree/slow_builder.h"
#include "octree/small_meshes.h"
#include "octree/winding_number.h"
#include "proxima/octree.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::classify_cells_test {
namespace {

using namespace testing;

struct Leaf {
    CellKey key;
    Box box;
    CellClass type = CellClass::unclassified;
};

/// Empty leaves; of a uniform octree the largest empty cells.
std::vector<Leaf> empty_leaves(const Octree& octree)
{
    std::vector<Leaf> leaves;
    const std::function<void(const Cell&)> visit = [&](const Cell& cell) {
        if (cell.type != CellClass::boundary) {
            leaves.push_back({cell.key, octree.box(cell), cell.type});
        } else if (!octree.is_leaf(cell)) {
            for (int octant = 0; octant < 8; ++octant) visit(octree.child(cell, octant));
        }
    };
    visit(octree.root());
    return leaves;
}

/// Components of leaves that share part of a face, by comparing pairs of boxes.
std::vector<std::size_t> slow_components(const std::vector<Leaf>& leaves)
{
    // From left to right, so that leaves that lie beyond one end the search for its neighbours.
    std::vector<std::size_t> order(leaves.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::sort(order, {}, [&](std::size_t i) { return leaves[i].box.lower.x(); });
    std::vector<std::pair<std::size_t, std::size_t>> neighbours;
    for (std::size_t a = 0; a < order.size(); ++a) {
        const Box& one = leaves[order[a]].box;
        for (std::size_t b = a + 1; b < order.size(); ++b) {
            const Box& other = leaves[order[b]].box;
            if (other.lower.x() > one.upper.x()) break;
            const auto common =
                (one.upper.cwiseMin(other.upper) - one.lower.cwiseMax(other.lower)).eval();
            int flat = 0;
            int thick = 0;
            for (int axis = 0; axis < 3; ++axis) {
                flat += common[axis] == 0.0 ? 1 : 0;
                thick += common[axis] > 0.0 ? 1 : 0;
            }
            if (flat == 1 && thick == 2) neighbours.emplace_back(order[a], order[b]);
        }
    }
    std::vector<std::size_t> component(leaves.size());
    std::iota(component.begin(), component.end(), 0U);
    for (bool changed = true; changed;) {
        changed = false;
        for (const auto& [i, j] : neighbours) {
            if (component[i] == component[j]) continue;
            component[i] = component[j] = std::min(component[i], component[j]);
            changed = true;
        }
    }
    return component;
}

struct Truth {
    ClassificationSummary summary;
    std::vector<CellClass> types;
};

/// Every leaf by the sum over all triangles, every component by comparing pairs.
Truth slow_classes(const Octree& octree, const TriangleMesh& mesh)
{
    const std::vector<Leaf> leaves = empty_leaves(octree);
    const std::vector<std::size_t> component = slow_components(leaves);
    const Box root = octree.box(octree.root());
    Truth truth;
    std::vector<bool> inner(leaves.size());
    std::vector<bool> outer(leaves.size());
    std::vector<std::uint64_t> size(leaves.size());
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const bool inside = brute_is_inside(mesh, leaves[i].box.center());
        truth.types.push_back(inside ? CellClass::inner : CellClass::outer);
        const bool at_root = (leaves[i].box.lower.array() == root.lower.array()).any() ||
                             (leaves[i].box.upper.array() == root.upper.array()).any();
        if (inside) inner[component[i]] = true;
        if (!inside || at_root) outer[component[i]] = true;
        const int levels = octree.parameters().max_depth - depth(leaves[i].key);
        size[component[i]] += octree.parameters().subdivision == Subdivision::uniform
                                  ? std::uint64_t{1} << (3 * levels)
                                  : 1U;
    }
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (component[i] != i) continue;
        ++truth.summary.components;
        if (inner[i] && outer[i]) {
            ++truth.summary.leaked_components;
            truth.summary.leaked_leaves += size[i];
        }
    }
    return truth;
}

void expect_right(const Octree& octree, const TriangleMesh& mesh)
{
    const auto classified = classify_cells(octree, mesh, {.execution = {.threads = {1}}});
    ASSERT_TRUE(classified) << describe(classified.error());
    const Status status = check_structure(*classified);
    EXPECT_TRUE(status) << describe(status.error());
    const Truth truth = slow_classes(octree, mesh);
    EXPECT_EQ(classified->parameters().classification.components, truth.summary.components);
    EXPECT_EQ(classified->parameters().classification.leaked_components,
              truth.summary.leaked_components);
    EXPECT_EQ(classified->parameters().classification.leaked_leaves, truth.summary.leaked_leaves);
    const std::vector<Leaf> leaves = empty_leaves(*classified);
    ASSERT_EQ(leaves.size(), truth.types.size());
    int wrong = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        wrong += leaves[i].type != truth.types[i] ? 1 : 0;
    EXPECT_EQ(wrong, 0) << "of " << leaves.size();
    EXPECT_EQ(octree_statistics(*classified).unclassified, 0U);
    EXPECT_EQ(classified->references().data(), octree.references().data());
}

/// Exact lists, unclassified: rays may be cast through it.
Octree exact_octree(const TriangleMesh& mesh, OctreeOptions options)
{
    options.classification = Classification::none;
    return build_octree(mesh, options).value();
}

void expect_right(const TriangleMesh& mesh)
{
    for (const int max_depth : {0, 2, 4, 5}) {
        for (const std::uint32_t threshold : {1U, 30U}) {
            SCOPED_TRACE(::testing::Message()
                         << "depth " << max_depth << " threshold " << threshold);
            expect_right(slow_octree(mesh, {.max_depth = max_depth, .threshold = threshold}), mesh);
            SCOPED_TRACE("exact lists");
            expect_right(exact_octree(mesh, {.max_depth = max_depth, .threshold = threshold}),
                         mesh);
        }
    }
    SCOPED_TRACE("uniform");
    expect_right(slow_octree(mesh, {.max_depth = 4, .subdivision = Subdivision::uniform}), mesh);
    expect_right(exact_octree(mesh, {.max_depth = 4, .subdivision = Subdivision::uniform}), mesh);
}

const TriangleMesh& torus()
{
    static const TriangleMesh mesh = torus_mesh(1.0, 0.45, 20, 12);
    return mesh;
}

TEST(ClassifyCells, AgreesWithBruteForceOnClosedSurfaces)
{
    const Vec3 center(0.1, 0.2, 0.3);
    const TriangleMesh ball = sphere_mesh(center, 1.0, 12, 12);
    const TriangleMesh core = sphere_mesh(center, 0.5, 8, 8);
    const std::vector<std::pair<const char*, TriangleMesh>> meshes = {
        {"cube", cube_mesh(Vec3::Zero(), 1.0)},
        {"sphere", ball},
        {"torus", torus()},
        {"hollow shell",
         joined(cube_mesh(Vec3::Zero(), 1.0), inverted(cube_mesh(Vec3::Zero(), 0.5)))},
        {"nested, same way round", joined(ball, core)},
        {"overlapping",
         joined(ball, moved(ball, [](const Vec3& p) { return Vec3(p + Vec3(0.9, 0.1, 0)); }))},
        {"inside out", inverted(ball)}};
    for (const auto& [name, mesh] : meshes) {
        SCOPED_TRACE(name);
        expect_right(mesh);
        const auto classified = classify_cells(slow_octree(mesh, {.max_depth = 4}), mesh).value();
        EXPECT_EQ(classified.parameters().classification.leaked_components, 0U);
        const std::uint64_t inner = octree_statistics(classified).inner;
        if (std::string(name) == "inside out") {
            EXPECT_EQ(inner, 0U);
        } else {
            EXPECT_GT(inner, 0U);
        }
    }
}

TEST(ClassifyCells, FindsTheCavityOfAShellOutside)
{
    const TriangleMesh shell =
        joined(cube_mesh(Vec3::Zero(), 1.0), inverted(cube_mesh(Vec3::Zero(), 0.5)));
    const auto classified = classify_cells(slow_octree(shell, {.max_depth = 5}), shell).value();
    int cavity = 0;
    int wall = 0;
    for (const Leaf& leaf : empty_leaves(classified)) {
        const double distance = leaf.box.center().cwiseAbs().maxCoeff();
        const bool in_wall = distance > 0.5 && distance < 1.0;
        EXPECT_EQ(leaf.type, in_wall ? CellClass::inner : CellClass::outer);
        (in_wall ? wall : cavity) += 1;
    }
    EXPECT_GT(cavity, 0);
    EXPECT_GT(wall, 0);
}

TEST(ClassifyCells, AgreesWithBruteForceOnSurfacesWithHoles)
{
    std::mt19937 random(17);
    for (int round = 0; round < 12; ++round) {
        SCOPED_TRACE(::testing::Message() << "round " << round << " of seed 17");
        const TriangleMesh base =
            round % 2 == 0 ? torus() : sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 12);
        std::vector<bool> drop(base.triangle_count());
        for (int k = 0; k < (1 << (round / 2)); ++k) drop[random() % drop.size()] = true;
        const TriangleMesh open = without(base, [&](std::size_t i) { return drop[i]; });
        const int max_depth = 3 + round % 3;
        const Octree octree = slow_octree(open, {.max_depth = max_depth, .threshold = 2});
        expect_right(octree, open);
        expect_right(slow_octree(open, {.max_depth = 4, .subdivision = Subdivision::uniform}),
                     open);
    }
}

TEST(ClassifyCells, KeepsCellsAwayFromAHoleAndReportsTheLeak)
{
    const TriangleMesh closed = sphere_mesh(Vec3::Zero(), 1.0, 24, 24);
    const auto at_top = [&](std::size_t i) {
        const Triangle triangle = closed.triangle(TriangleId{static_cast<std::uint32_t>(i)});
        return triangle[0][2] + triangle[1][2] + triangle[2][2] > 3 * 0.94;
    };
    const TriangleMesh open = without(closed, at_top);
    const SlowOctreeOptions options{.max_depth = 5, .threshold = 1, .root = slow_root(closed)};
    const auto whole = classify_cells(slow_octree(closed, options), closed).value();
    const auto leaky = classify_cells(slow_octree(open, options), open).value();
    EXPECT_EQ(leaky.parameters().classification.leaked_components, 1U);
    EXPECT_GT(leaky.parameters().classification.leaked_leaves, 1000U);
    Box hole;
    for (std::uint32_t i = 0; i < closed.triangle_count(); ++i) {
        if (!at_top(i)) continue;
        for (const Vec3& p : closed.triangle(TriangleId{i}).vertices) hole.extend(p);
    }
    const double size = hole.extent().norm();
    std::vector<Leaf> expected;
    for (const Leaf& leaf : empty_leaves(whole)) expected.push_back(leaf);
    int compared = 0;
    for (const Leaf& leaf : empty_leaves(leaky)) {
        const Vec3 center = leaf.box.center();
        if ((center - hole.center()).norm() < size) continue;
        for (const Leaf& other : expected) {
            if (!other.box.contains(center)) continue;
            EXPECT_EQ(leaf.type, other.type);
            ++compared;
            break;
        }
    }
    EXPECT_GT(compared, 1000);
}

TEST(ClassifyCells, AgreesWithBruteForceOnBadSurfaces)
{
    const TriangleMesh ball = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 12, 12);
    {
        SCOPED_TRACE("flipped patch");
        std::vector<TriangleCorners> triangles(ball.triangles().begin(), ball.triangles().end());
        for (std::size_t i = 40; i < 60; ++i) std::swap(triangles[i][1], triangles[i][2]);
        expect_right(mesh_of({ball.positions().begin(), ball.positions().end()}, triangles));
    }
    {
        SCOPED_TRACE("vertices not shared");
        std::vector<Vec3> positions;
        std::vector<TriangleCorners> triangles;
        for (std::uint32_t i = 0; i < ball.triangle_count(); ++i) {
            for (const Vec3& p : ball.triangle(TriangleId{i}).vertices) positions.push_back(p);
            triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
        const TriangleMesh soup = mesh_of(positions, triangles);
        expect_right(soup);
        EXPECT_EQ(classify_cells(slow_octree(soup, {.max_depth = 4}), soup)
                      ->parameters()
                      .classification.leaked_components,
                  0U);
    }
    {
        SCOPED_TRACE("every triangle twice");
        expect_right(joined(ball, ball));
    }
    {
        SCOPED_TRACE("one triangle");
        expect_right(mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0.3), Vec3(0, 1, 0.7)}, {{0, 1, 2}}));
    }
    {
        SCOPED_TRACE("degenerate triangles");
        expect_right(
            mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0.3), Vec3(0, 1, 0.7)}, {{0, 1, 1}, {2, 2, 2}}));
    }
    {
        SCOPED_TRACE("half a sphere");
        expect_right(without(ball, [&](std::size_t i) {
            return ball.triangle(TriangleId{static_cast<std::uint32_t>(i)})[0][2] < 0.25;
        }));
    }
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    for (int round = 0; round < 6; ++round) {
        SCOPED_TRACE(::testing::Message() << "random triangles, round " << round << " of seed 9");
        std::vector<Vec3> positions;
        std::vector<TriangleCorners> triangles;
        for (int i = 0; i < 12; ++i)
            positions.emplace_back(place(random), place(random), place(random));
        for (int i = 0; i < 20; ++i) {
            triangles.push_back({static_cast<std::uint32_t>(random() % 12),
                                 static_cast<std::uint32_t>(random() % 12),
                                 static_cast<std::uint32_t>(random() % 12)});
        }
        expect_right(mesh_of(positions, triangles));
    }
}

TEST(ClassifyCells, AgreesWithBruteForceAtAnyPoseAndScale)
{
    const TriangleMesh open = without(torus(), [](std::size_t i) { return i % 40 == 0; });
    const Octree octree = slow_octree(open, {.max_depth = 5});
    const auto classified = classify_cells(octree, open).value();
    for (const double scale : {0x1p-90, 0x1p-3, 0x1p90}) {
        const TriangleMesh scaled = moved(open, [&](const Vec3& p) { return Vec3(p * scale); });
        const OctreeFrame frame{octree.frame().lower * scale, octree.frame().edge * scale};
        const auto other =
            classify_cells(slow_octree(scaled, {.max_depth = 5, .root = frame}), scaled).value();
        EXPECT_TRUE(std::equal(classified.nodes().begin(), classified.nodes().end(),
                               other.nodes().begin(), other.nodes().end()));
    }
    const Eigen::Matrix3d turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
    expect_right(moved(open, [&](const Vec3& p) { return Vec3(turn * p + Vec3(100, -50, 7)); }));
}

TEST(ClassifyCells, IsTheSameAtTheEndOfDoubles)
{
    // Whole multiples of 2^-16, so that nothing is rounded at 2^-1050 either.
    const auto rounded = [](const Vec3& p) { return Vec3((p * 0x1p16).array().round() * 0x1p-16); };
    const TriangleMesh open =
        moved(without(torus(), [](std::size_t i) { return i % 40 == 0; }), rounded);
    const auto classified = [&](int exponent) {
        const auto scale = [&](const Vec3& p) { return Vec3(p * std::ldexp(1.0, exponent)); };
        const OctreeFrame frame{scale(Vec3::Constant(-2)), scale(Vec3::Constant(4))};
        const TriangleMesh scaled = moved(open, scale);
        return classify_cells(slow_octree(scaled, {.max_depth = 6, .root = frame}), scaled).value();
    };
    const Octree expected = classified(0);
    EXPECT_GT(expected.parameters().classification.leaked_components, 0U);
    for (const int exponent : {-1000, -1030, -1050}) {
        const Octree other = classified(exponent);
        EXPECT_TRUE(std::ranges::equal(other.nodes(), expected.nodes())) << exponent;
    }
}

TEST(ClassifyCells, HasTheSameBitsForAnyNumberOfThreads)
{
    const TriangleMesh open =
        without(torus_mesh(1.0, 0.4, 60, 30), [](std::size_t i) { return i < 200; });
    const Octree octree = exact_octree(open, {.max_depth = 6});
    const auto one = classify_cells(octree, open, {.execution = {.threads = {1}}}).value();
    for (const int threads : {2, 5}) {
        const auto more =
            classify_cells(octree, open, {.execution = {.threads = {threads}}}).value();
        EXPECT_EQ(one.parameters(), more.parameters());
        EXPECT_TRUE(std::equal(one.nodes().begin(), one.nodes().end(), more.nodes().begin(),
                               more.nodes().end()));
    }
    // Classes already there are replaced.
    const auto again = classify_cells(one, open).value();
    EXPECT_TRUE(std::equal(one.nodes().begin(), one.nodes().end(), again.nodes().begin()));
}

TEST(ClassifyCells, RefusesInvalidInputAndStopsOnRequest)
{
    const TriangleMesh ball = sphere_mesh(Vec3::Zero(), 1.0, 12, 12);
    const Octree octree = slow_octree(ball, {.max_depth = 4});
    EXPECT_EQ(code_of(classify_cells(octree, torus())), ErrorCode::invalid_argument);
    EXPECT_EQ(code_of(classify_cells(octree, ball, {.execution = {.budget = {1000}}})),
              ErrorCode::budget_exceeded);
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(classify_cells(octree, ball, {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::classify_cells_test
