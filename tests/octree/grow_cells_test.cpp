#include "proxima/grow_cells.h"

#include "octree/distribute_children.h"
#include "octree/nasty_meshes.h"
#include "octree/random_octree_options.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace proxima::grow_cells_test {
namespace {

using testing::nasty_mesh;
using testing::random_octree_options;

/// A leaf by its key, and its list.
struct Leaf {
    CellKey key;
    std::vector<TriangleId> triangles;
    friend bool operator==(const Leaf&, const Leaf&) = default;
};

/// Collects leaves and their lists.
struct LeafCollector {
    std::vector<Leaf>& leaves;

    static bool should_enter(const Cell&) { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
    {
        leaves.push_back({cell.key, {triangles.begin(), triangles.end()}});
        return Flow::proceed;
    }
};

std::vector<Leaf> leaves_of(const Octree& octree)
{
    std::vector<Leaf> leaves;
    traverse(octree, LeafCollector{leaves});
    return leaves;
}

/// Cells that cut the tree: those at the routing depth and leaves above it, in Morton order. Some
/// cuts are deeper in one octant than in another.
std::vector<Cell> cut_of(const Octree& octree, int routing_depth, bool is_uneven)
{
    std::vector<Cell> cut;
    std::vector<Cell> pending = {octree.root()};
    while (!pending.empty()) {
        const Cell cell = pending.back();
        pending.pop_back();
        const int depth_here =
            routing_depth - (is_uneven ? static_cast<int>(cell.key.bits & 1) : 0);
        if (octree.is_leaf(cell) || depth(cell.key) >= depth_here) {
            cut.push_back(cell);
            continue;
        }
        for (int octant = 7; octant >= 0; --octant) pending.push_back(octree.child(cell, octant));
    }
    return cut;
}

/// The triangles of all leaves below a cell, ascending.
std::vector<TriangleId> triangles_below(const Octree& octree, const Cell& cell)
{
    std::vector<Leaf> leaves;
    traverse_below(octree, cell, LeafCollector{leaves});
    std::vector<TriangleId> ids;
    for (const Leaf& leaf : leaves) {
        ids.insert(ids.end(), leaf.triangles.begin(), leaf.triangles.end());
    }
    std::ranges::sort(ids);
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
}

/// A mesh of some triangles of another one, with vertices of its own.
TriangleMesh piece_of(const TriangleMesh& mesh, const std::vector<TriangleId>& ids)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (const TriangleId id : ids) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        const Triangle triangle = mesh.triangle(id);
        for (int k = 0; k < 3; ++k) positions.push_back(triangle[k]);
        triangles.push_back({first, first + 1, first + 2});
    }
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

/// Grows cut[begin, end) from a piece of the mesh that has no other triangle, and appends its leaves
/// with the ids of the whole.
void grow_piece(const TriangleMesh& mesh, const Octree& whole, std::span<const Cell> cut,
                std::vector<Leaf>& leaves)
{
    std::vector<std::vector<TriangleId>> lists;
    std::vector<TriangleId> all;
    for (const Cell& cell : cut) {
        lists.push_back(triangles_below(whole, cell));
        all.insert(all.end(), lists.back().begin(), lists.back().end());
    }
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    for (auto& list : lists) {
        for (TriangleId& id : list) {
            const auto at = std::ranges::lower_bound(all, id) - all.begin();
            id = TriangleId{static_cast<std::uint32_t>(at)};
        }
    }
    std::vector<CellTriangles> cells;
    for (std::size_t i = 0; i < cut.size(); ++i) cells.push_back({cut[i].key, lists[i]});
    const OctreeParameters& parameters = whole.parameters();
    const auto grown =
        grow_cells(piece_of(mesh, all), whole.frame(), cells,
                   {.max_depth = parameters.max_depth, .threshold = parameters.threshold});
    ASSERT_TRUE(grown) << describe(grown.error());
    ASSERT_EQ(grown->cells.size(), cut.size());
    const std::size_t first = leaves.size();
    for (std::size_t i = 0; i < cut.size(); ++i) {
        ASSERT_EQ(grown->cells[i].key, cut[i].key);
        traverse_below(grown->octree, grown->cells[i], LeafCollector{leaves});
    }
    for (std::size_t i = first; i < leaves.size(); ++i) {
        for (TriangleId& id : leaves[i].triangles) id = all[to_index(id)];
    }
}

void expect_parts_join(const TriangleMesh& mesh, const OctreeOptions& options, std::uint32_t seed)
{
    const auto whole = build_octree(mesh, options);
    ASSERT_TRUE(whole) << describe(whole.error());
    const auto expected = leaves_of(*whole);
    std::mt19937 random(seed);
    for (int routing_depth = 0; routing_depth <= options.max_depth; ++routing_depth) {
        const auto cut = cut_of(*whole, routing_depth, random() % 2 == 0);
        std::vector<Leaf> joined;
        const std::size_t pieces = 1 + random() % 4;
        for (std::size_t piece = 0; piece < pieces; ++piece) {
            const std::size_t begin = cut.size() * piece / pieces;
            const std::size_t end = cut.size() * (piece + 1) / pieces;
            ASSERT_NO_FATAL_FAILURE(
                grow_piece(mesh, *whole, std::span(cut).subspan(begin, end - begin), joined));
        }
        ASSERT_EQ(joined.size(), expected.size()) << "routing depth " << routing_depth;
        ASSERT_TRUE(joined == expected) << "routing depth " << routing_depth;
    }
}

TEST(GrowCells, PartsOfNastyMeshesJoinToTheWholeOctree)
{
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        ASSERT_NO_FATAL_FAILURE(
            expect_parts_join(nasty_mesh(seed), random_octree_options(seed), seed));
    }
}

TEST(GrowCells, PartsOfSurfacesJoinToTheWholeOctree)
{
    const OctreeOptions options{
        .max_depth = 7, .threshold = 4, .classification = Classification::none};
    ASSERT_NO_FATAL_FAILURE(expect_parts_join(make_sphere(60, 60), options, 1));
    ASSERT_NO_FATAL_FAILURE(expect_parts_join(*make_spaceship(6000), options, 2));
}

TEST(GrowCells, GrowsTheRootAsBuildOctreeDoes)
{
    const TriangleMesh mesh = *make_spaceship(3000);
    const auto whole = build_octree(
        mesh, {.max_depth = 6, .threshold = 8, .classification = Classification::none});
    ASSERT_TRUE(whole);
    const auto ids = triangles_below(*whole, whole->root());
    const CellTriangles root{{}, ids};
    const auto grown =
        grow_cells(mesh, whole->frame(), {&root, 1}, {.max_depth = 6, .threshold = 8});
    ASSERT_TRUE(grown) << describe(grown.error());
    EXPECT_TRUE(leaves_of(grown->octree) == leaves_of(*whole));
}

TEST(GrowCells, CellsWithoutTrianglesAreEmptyLeaves)
{
    const std::array<CellTriangles, 2> cells = {{{child({}, 1), {}}, {child({}, 4), {}}}};
    const auto grown = grow_cells(TriangleMesh{}, OctreeFrame{}, cells);
    ASSERT_TRUE(grown) << describe(grown.error());
    ASSERT_EQ(grown->cells.size(), 2U);
    for (const Cell& cell : grown->cells) EXPECT_TRUE(grown->octree.is_leaf(cell));
    EXPECT_TRUE(grown->octree.triangles(grown->cells[1]).empty());
    const auto none = grow_cells(make_cube(), {Vec3::Constant(-1), Vec3::Constant(2)}, {});
    ASSERT_TRUE(none);
    EXPECT_TRUE(none->cells.empty());
}

TEST(GrowCells, RefusesWhatItCannotGrow)
{
    const TriangleMesh cube = make_cube();
    const OctreeFrame frame{Vec3::Constant(-1), Vec3::Constant(2)};
    const std::vector<TriangleId> ids = {TriangleId{0}, TriangleId{3}};
    const std::vector<TriangleId> falling = {TriangleId{3}, TriangleId{0}};
    const std::vector<TriangleId> twice = {TriangleId{3}, TriangleId{3}};
    const std::vector<TriangleId> beyond = {TriangleId{12}};
    const auto says = [&](const OctreeFrame& root, std::vector<CellTriangles> cells,
                          const GrowCellsOptions& options = {}) {
        const auto grown = grow_cells(cube, root, cells, options);
        return grown ? std::string("grown") : describe(grown.error());
    };
    EXPECT_EQ(says(frame, {{{}, ids}}), "grown");
    EXPECT_NE(says(frame, {{{}, falling}}).find("ascend"), std::string::npos);
    EXPECT_NE(says(frame, {{{}, twice}}).find("ascend"), std::string::npos);
    EXPECT_NE(says(frame, {{{}, beyond}}).find("triangle 12"), std::string::npos);
    EXPECT_NE(says(frame, {{{}, ids}, {child({}, 0), ids}}).find("overlaps"), std::string::npos);
    EXPECT_NE(says(frame, {{child({}, 1), ids}, {child({}, 0), ids}}).find("Morton"),
              std::string::npos);
    EXPECT_NE(says(frame, {{{0}, ids}}).find("key 0"), std::string::npos);
    EXPECT_NE(says(frame, {{{2}, ids}}).find("key 2"), std::string::npos);
    EXPECT_NE(says(frame, {{child({}, 0), ids}}, {.max_depth = 0}).find("key 8"),
              std::string::npos);
    EXPECT_NE(says(frame, {{{}, ids}}, {.max_depth = 20}).find("not 20"), std::string::npos);
    EXPECT_NE(says({Vec3::Zero(), Vec3::Ones()}, {{{}, ids}}).find("out of the root"),
              std::string::npos);
    EXPECT_NE(says({Vec3::Zero(), Vec3::Zero()}, {{{}, ids}}).find("positive"), std::string::npos);
    for (int axis = 0; axis < 3; ++axis) { // which holds the lower corner, but not the upper one
        OctreeFrame small = frame;
        small.edge[axis] = 1.5;
        EXPECT_NE(says(small, {{{}, ids}}).find("out of the root"), std::string::npos);
        small.edge[axis] = 0;
        EXPECT_NE(says(small, {{{}, ids}}).find("positive"), std::string::npos);
    }
    const double infinity = std::numeric_limits<double>::infinity();
    for (const OctreeFrame& root : {OctreeFrame{Vec3::Constant(-9), Vec3(infinity, 20, 20)},
                                    OctreeFrame{Vec3(-infinity, -9, -9), Vec3::Constant(20)}})
        EXPECT_NE(says(root, {{{}, ids}}).find("finite corners"), std::string::npos);
    for (const double far : {-1.1e100, 1.1e100}) {
        const TriangleMesh huge =
            make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, far, 0}}, {{0, 1, 2}}).value();
        const std::vector<TriangleId> all = {TriangleId{0}};
        const std::vector<CellTriangles> cells = {{{}, all}};
        const auto grown =
            grow_cells(huge, {Vec3::Constant(-2e100), Vec3::Constant(4e100)}, cells, {});
        ASSERT_FALSE(grown);
        EXPECT_NE(describe(grown.error()).find("1e100"), std::string::npos);
    }
    EXPECT_NE(says(frame, {{{}, ids}}, {.execution = {.budget = {8}}}).find("budget"),
              std::string::npos);
    Progress progress;
    progress.cancel();
    EXPECT_NE(
        says(frame, {{{}, ids}}, {.execution = {.progress = &progress}}).find("stopped on request"),
        std::string::npos);
}

/// Sums of lanes are added up before they leave 32 bits.
TEST(GrowCells, CountsMoreChildrenThanALaneHolds)
{
    const std::size_t count = (std::size_t{1} << 24U) + 5;
    std::vector<std::uint32_t> masks(count + lane_padding, 0);
    masks[3] = 0xFF;
    masks[count - 1] = 0x11;
    EXPECT_EQ(count_children(masks.data(), count), 10U);
}

} // namespace
} // namespace proxima::grow_cells_test
