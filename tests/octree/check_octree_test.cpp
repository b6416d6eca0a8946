#include "octree/check_octree.h"

#include "octree/check_structure.h"
#include "octree/editable_octree.h"
#include "octree/slow_builder.h"
#include "octree/small_meshes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace proxima::check_octree_test {
namespace {

using namespace testing;

std::string reason(const Status& status)
{
    return status ? "ok" : describe(status.error());
}

class CheckOctree : public ::testing::Test {
protected:
    // Eight bits behind the point: the oracle's long double is exact for these.
    TriangleMesh mesh = moved(sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.0, 8, 8), [](const Vec3& p) {
        return Vec3((p * 256.0).array().round() / 256.0);
    });
    OctreeFrame root{Vec3::Constant(-2.0), Vec3::Constant(4.0)};
    SlowOctreeOptions options{.max_depth = 4, .threshold = 6, .root = root};
    Octree adaptive = slow_octree(mesh, options);
    Octree uniform =
        slow_octree(mesh, {.max_depth = 3, .subdivision = Subdivision::uniform, .root = root});

    static std::uint32_t first_leaf(const EditableOctree& octree, std::uint32_t min_count)
    {
        for (std::uint32_t i = 0; i < octree.nodes.size(); ++i) {
            if (octree.nodes[i].is_leaf() && octree.nodes[i].count() >= min_count) return i;
        }
        return 0;
    }
};

TEST_F(CheckOctree, AcceptsWhatTheOracleBuilds)
{
    EXPECT_EQ(reason(check_octree(adaptive, mesh)), "ok");
    EXPECT_EQ(reason(check_octree(uniform, mesh)), "ok");
    const SlowOctreeOptions one_leaf{.max_depth = 0, .root = root};
    EXPECT_EQ(reason(check_octree(slow_octree(mesh, one_leaf), mesh)), "ok");
}

// The most cells that can wait at a time, in the order of the records and against it.
TEST_F(CheckOctree, AcceptsACellAtTheGreatestDepthWithSevenSiblingsAtEveryDepth)
{
    for (const double corner : {0.0, 1.0}) {
        std::vector<Vec3> vertices;
        std::vector<TriangleCorners> triangles;
        for (int octant = 1; octant < 8; ++octant) { // through it at every depth
            const Vec3 along((octant & 1) != 0 ? 0.75 : 0.25, (octant & 2) != 0 ? 0.75 : 0.25,
                             (octant & 4) != 0 ? 0.75 : 0.25);
            const Vec3 end = Vec3::Constant(corner) + (corner > 0 ? -along : along);
            const auto first = static_cast<std::uint32_t>(vertices.size());
            vertices.insert(vertices.end(),
                            {Vec3::Constant(corner), end, end + Vec3(0x1p-6, -0x1p-6, 0)});
            triangles.push_back({first, first + 1, first + 2});
        }
        const TriangleMesh fan = mesh_of(vertices, triangles);
        const auto octree = build_octree(
            fan, {.max_depth = max_octree_depth, .root = OctreeFrame{Vec3::Zero(), Vec3::Ones()}});
        ASSERT_TRUE(octree) << describe(octree.error());
        ASSERT_GE(octree->nodes().size(), 8U * max_octree_depth + 1);
        EXPECT_EQ(reason(check_octree(*octree, fan)), "ok");
    }
}

TEST_F(CheckOctree, AcceptsConservativeListsOnlyWhenMarkedInexact)
{
    const auto fat = [](const Triangle& triangle, const Box& box) {
        return slow_overlap(triangle,
                            {box.lower - Vec3::Constant(0.05), box.upper + Vec3::Constant(0.05)});
    };
    EditableOctree edit(slow_octree(mesh, options, fat));
    EXPECT_NE(reason(check_octree(edit.octree(), mesh)).find("does not touch"), std::string::npos);
    edit.parameters.exact = false;
    EXPECT_EQ(reason(check_octree(edit.octree(), mesh)), "ok");
}

TEST_F(CheckOctree, FindsAMissedTriangle)
{
    const auto thin = [](const Triangle& triangle, const Box& box) {
        return slow_overlap(triangle,
                            {box.lower + Vec3::Constant(0.001), box.upper - Vec3::Constant(0.001)});
    };
    EXPECT_NE(reason(check_octree(slow_octree(mesh, options, thin), mesh)).find("is not listed"),
              std::string::npos);
}

TEST_F(CheckOctree, FindsAWrongThreshold)
{
    EditableOctree edit(adaptive);
    // The longest list of a leaf that could have been split must be what the threshold allowed.
    std::uint32_t longest = 0;
    const std::function<void(const Cell&)> visit = [&](const Cell& cell) {
        if (!adaptive.is_leaf(cell)) {
            for (int octant = 0; octant < 8; ++octant) visit(adaptive.child(cell, octant));
        } else if (depth(cell.key) < adaptive.parameters().max_depth) {
            longest =
                std::max(longest, static_cast<std::uint32_t>(adaptive.triangles(cell).size()));
        }
    };
    visit(adaptive.root());
    ASSERT_GT(longest, 0U);
    edit.parameters.threshold = longest;
    EXPECT_EQ(reason(check_octree(edit.octree(), mesh)), "ok");
    edit.parameters.threshold = longest - 1;
    EXPECT_NE(reason(check_octree(edit.octree(), mesh)).find("is not split"), std::string::npos);
    edit.parameters.threshold = 100;
    EXPECT_NE(reason(check_octree(edit.octree(), mesh)).find("is split"), std::string::npos);
}

TEST_F(CheckOctree, DetectsAnotherMesh)
{
    EXPECT_FALSE(check_octree(adaptive, sphere_mesh(Vec3::Zero(), 1.0, 8, 9)));
    EXPECT_FALSE(check_octree(adaptive, sphere_mesh(Vec3(0.1, 0.2, 5.0), 1.0, 8, 8)));
}

TEST_F(CheckOctree, FindsEachBrokenRecord)
{
    const auto expect_bad = [&](const EditableOctree& edit, const std::string& why) {
        const std::string found = reason(check_structure(edit.octree()));
        EXPECT_NE(found.find(why), std::string::npos) << found;
    };
    EditableOctree edit(adaptive);
    const std::uint32_t leaf = first_leaf(edit, 2);

    edit.nodes[leaf].first = static_cast<std::uint32_t>(edit.references.size());
    expect_bad(edit, "a list ends at");
    edit = EditableOctree(adaptive);
    edit.nodes[leaf].first ^= 1U;
    EXPECT_FALSE(check_structure(edit.octree()));
    edit = EditableOctree(adaptive);
    edit.nodes[leaf].packed -= 1;
    expect_bad(edit, "belong to no leaf");
    edit = EditableOctree(adaptive);
    edit.nodes[leaf].packed = OctreeNode::leaf_bit;
    expect_bad(edit, "empty leaf");
    edit = EditableOctree(adaptive);
    std::swap(edit.references[edit.nodes[leaf].first], edit.references[edit.nodes[leaf].first + 1]);
    expect_bad(edit, "does not ascend");
    edit = EditableOctree(adaptive); // a triangle twice
    edit.references[edit.nodes[leaf].first + 1] = edit.references[edit.nodes[leaf].first];
    expect_bad(edit, "does not ascend");
    edit = EditableOctree(adaptive);
    edit.references[edit.nodes[leaf].first + edit.nodes[leaf].count() - 1] = TriangleId{1'000'000};
    expect_bad(edit, "triangle 1000000 of");
    edit = EditableOctree(adaptive);
    edit.nodes[0].first = 0;
    expect_bad(edit, "two parents");
    edit = EditableOctree(adaptive); // two split cells that are beside each other
    const auto is_split = [&](OctreeNode node) { return !node.is_leaf(); };
    const auto one =
        std::ranges::find_if(edit.nodes.begin() + edit.nodes[0].first, edit.nodes.end(), is_split);
    const auto other = std::find_if(one + 1, edit.nodes.end(), is_split);
    ASSERT_LT(other - edit.nodes.begin(), edit.nodes[0].first + 8);
    one->first = other->first;
    expect_bad(edit, "two parents");
    edit = EditableOctree(adaptive);
    edit.nodes[0].first = static_cast<std::uint32_t>(edit.nodes.size()) - 7;
    expect_bad(edit, "children end at");
    edit = EditableOctree(adaptive);
    edit.nodes.push_back(OctreeNode::leaf(0, 1));
    expect_bad(edit, "1 records belong to no cell");
    edit = EditableOctree(adaptive);
    edit.parameters.max_depth = 2;
    expect_bad(edit, "is split, the maximum is 2");
    edit = EditableOctree(adaptive);
    edit.nodes[0].packed |= 1U << 20U;
    expect_bad(edit, "unknown bits");
    edit = EditableOctree(adaptive);
    edit.nodes[0].packed |= 1U << 8U;
    expect_bad(edit, "unclassified");
    edit.parameters.classified = true;
    expect_bad(edit, "marked inner");
    edit = EditableOctree(adaptive);
    edit.frame.edge[1] = std::numeric_limits<double>::quiet_NaN();
    expect_bad(edit, "finite box");
    edit = EditableOctree(adaptive);
    edit.nodes.clear();
    expect_bad(edit, "1 to 2^32");

    edit = EditableOctree(uniform);
    edit.parameters.max_depth = 4;
    expect_bad(edit, "a leaf at depth 3");
    edit = EditableOctree(uniform);
    edit.nodes[0].packed |= OctreeNode::empty_split_bit;
    expect_bad(edit, "contradicts its children");
    // An empty cell below one that says outer: with one inner child, and with eight.
    for (const std::uint32_t inner : {0x01U, 0xFFU}) {
        edit = EditableOctree(uniform);
        edit.parameters.classified = true;
        ASSERT_EQ(reason(check_structure(edit.octree())), "ok");
        const auto empty = std::ranges::find_if(
            edit.nodes, [](OctreeNode node) { return !node.is_leaf() && node.is_empty(); });
        ASSERT_NE(empty, edit.nodes.end());
        empty->packed |= inner << 8U;
        expect_bad(edit, "partly inner");
    }
}

TEST_F(CheckOctree, SurvivesRandomRecords)
{
    const unsigned seed = 7;
    std::mt19937 random(seed);
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    for (int round = 0; round < 2000; ++round) {
        EditableOctree edit(round % 2 == 0 ? adaptive : uniform);
        for (int change = 0; change < 3; ++change) {
            OctreeNode& node = edit.nodes[random() % edit.nodes.size()];
            const std::uint32_t bit = 1U << (random() % 32);
            // Where a list begins that has no elements is of no importance.
            const bool idle = node.is_leaf() && node.is_empty();
            (random() % 2 == 0 && !idle ? node.first : node.packed) ^= bit;
        }
        EXPECT_FALSE(check_structure(edit.octree())) << "round " << round;
    }
}

} // namespace
} // namespace proxima::check_octree_test
