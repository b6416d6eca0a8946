#include "query/scene/scene_tree.h"

#include "query/scene/scenes_one_by_one.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <memory>

namespace proxima::scene_tree_test {
namespace {

using namespace testing;

/// Looks at all boxes of a scene's tree.
class TreeWalk {
public:
    explicit TreeWalk(const SceneParts& scene) : scene_(scene), tree_(scene.tree.parts()) {}

    /// The box of all rows below, in the tree's units, which every node's box must hold and not be much larger.
    Box look_at(std::uint32_t reference)
    {
        ++blocks_;
        const IndexBlock& block = tree_.blocks()[reference & ~index_leaf_bit];
        Box all;
        if ((reference & index_leaf_bit) != 0) {
            for (std::uint32_t i = 0; i < block.leaf.count; ++i) {
                const Box& box = scene_.rows[block.leaf.first_row + i].box;
                EXPECT_FALSE(box.empty());
                all.extend((box.lower - tree_.center()) * tree_.scale());
                all.extend((box.upper - tree_.center()) * tree_.scale());
                ++rows_;
            }
            return all;
        }
        std::vector<std::pair<std::size_t, Box>> children;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (!block.node.has_child(slot)) continue;
            children.emplace_back(slot, look_at(block.node.children[slot]));
            all.extend(children.back().second.lower);
            all.extend(children.back().second.upper);
        }
        for (const auto& [slot, box] : children) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                const double lower = block.node.plane(axis, slot);
                const double upper = block.node.plane(axis, 8 + slot);
                // Planes are on a grid of 253 steps.
                const double slack = 0.02 * all.extent()[k] + 1e-5;
                EXPECT_TRUE(lower <= box.lower[k] && lower > box.lower[k] - slack);
                EXPECT_TRUE(upper >= box.upper[k] && upper < box.upper[k] + slack);
            }
        }
        return all;
    }
    [[nodiscard]] std::size_t rows() const { return rows_; }
    [[nodiscard]] std::size_t blocks() const { return blocks_; }

private:
    const SceneParts& scene_;
    const IndexParts& tree_;
    std::size_t rows_ = 0;
    std::size_t blocks_ = 0;
};

void expect_tight_boxes(const Scene& scene)
{
    const SceneParts& parts = scene.parts();
    if (parts.tree_rows() == 0) return;
    TreeWalk walk(parts);
    const Box all = walk.look_at(parts.tree.parts().root());
    EXPECT_EQ(walk.rows(), parts.tree_rows());
    // Block 0 is the empty leaf: all others are in the tree, and were written.
    EXPECT_EQ(walk.blocks() + 1, parts.tree.parts().blocks().size());
    EXPECT_TRUE(all.lower.minCoeff() >= -1 && all.upper.maxCoeff() <= 1);
}

void expect_same_tree(const Scene& a, const Scene& b)
{
    const auto blocks = a.parts().tree.parts().blocks();
    const auto others = b.parts().tree.parts().blocks();
    ASSERT_EQ(blocks.size(), others.size());
    EXPECT_EQ(std::memcmp(blocks.data(), others.data(), blocks.size_bytes()), 0);
}

TEST(SceneTree, HasTightBoxesWhereverInstancesMove)
{
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        RandomScene of = random(seed % 5 == 0 ? 3000 : 1 + random.below(60));
        Scene scene = build_scene(of.shapes, of.instances).value();
        expect_tight_boxes(scene);
        for (int step = 0; step < 3; ++step) {
            std::vector<RigidTransform> poses;
            for (Instance& instance : of.instances) {
                if (step == 0 || random.below(20) == 0)
                    instance.pose.translation = of.center + of.size * random.vector();
                poses.push_back(instance.pose);
            }
            const Scene one = move_instances(scene, poses, {{.threads = {1}}}).value();
            scene = move_instances(scene, poses, {{.threads = {3}}}).value();
            expect_tight_boxes(scene);
            expect_same_tree(one, scene);
            if (HasFailure()) return;
        }
    }
}

TEST(SceneTree, IsThatOfANewSceneWhereNothingMoved)
{
    const RandomScene of = SceneGenerator(11)(500);
    const Scene scene = build_scene(of.shapes, of.instances).value();
    std::vector<RigidTransform> poses;
    for (const Instance& instance : of.instances) poses.push_back(instance.pose);
    expect_same_tree(scene, move_instances(scene, poses).value());
    EXPECT_EQ(scene.bytes(), move_instances(scene, poses).value().bytes());
}

/// Whether the blocks are those of a tree that is drawn anew in the same frame.
void expect_redrawn(const Scene& scene)
{
    if (scene.parts().tree_rows() == 0) return;
    SceneParts again = copy_of(scene.parts());
    ASSERT_TRUE(draw_tree(again, scene.parts().tree.parts(), {}));
    ASSERT_EQ(again.tree.parts().scale(), scene.parts().tree.parts().scale());
    EXPECT_EQ(again.tree.parts().root_box().lower, scene.parts().tree.parts().root_box().lower);
    EXPECT_EQ(again.tree.parts().root_box().upper, scene.parts().tree.parts().root_box().upper);
    expect_same_tree(Scene(std::make_shared<SceneParts>(again)), scene);
}

TEST(SceneTree, IsRedrawnAboveInstancesThatMoveAlone)
{
    std::size_t in_place = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        SceneGenerator random(seed);
        RandomScene of = random(seed % 5 == 0 ? 3000 : 1 + random.below(300));
        Scene scene = build_scene(of.shapes, of.instances).value();
        for (int step = 0; step < 6; ++step) {
            std::vector<InstanceId> ids;
            std::vector<RigidTransform> poses;
            const std::uint64_t count = random.below(of.instances.size() / 6 + 2);
            for (std::uint64_t i = 0; i < count; ++i) {
                const std::uint64_t id = random.below(of.instances.size());
                Instance& instance = of.instances[id];
                if (random.below(2) == 0) instance.pose.rotation = random.rotation();
                instance.pose.translation = of.center + 0.9 * of.size * random.vector();
                ids.push_back(id_of(id)); // some twice
                poses.push_back(instance.pose);
            }
            const SceneParts* const before = &scene.parts();
            ASSERT_TRUE(move_in_place(scene, ids, poses));
            in_place += before == &scene.parts() ? 1 : 0;
            for (std::size_t i = 0; i < of.instances.size(); ++i) {
                const RigidTransform& pose = scene.instance(id_of(i)).pose;
                EXPECT_EQ(pose.rotation, of.instances[i].pose.rotation);
                EXPECT_EQ(pose.translation, of.instances[i].pose.translation);
            }
            expect_tight_boxes(scene);
            expect_redrawn(scene);
            if (HasFailure()) return;
        }
    }
    EXPECT_GT(in_place, 150U);
}

TEST(SceneTree, HasAFrameOfItsInstancesAgainAfterOneWasFarAway)
{
    SceneGenerator random(5);
    const RandomScene of = random(300);
    Scene scene = build_scene(of.shapes, of.instances).value();
    const double scale = scene.parts().tree.parts().scale();
    const std::vector<InstanceId> one = {id_of(7)};
    const std::vector<InstanceId> other = {id_of(8)};
    RigidTransform away = of.instances[7].pose;
    away.translation.x() += 1e6 * of.size;
    ASSERT_TRUE(move_in_place(scene, one, std::span(&away, 1)));
    EXPECT_LT(scene.parts().tree.parts().scale(), 1e-3 * scale);
    ASSERT_TRUE(move_in_place(scene, one, std::span(&of.instances[7].pose, 1)));
    ASSERT_TRUE(move_in_place(scene, other, std::span(&of.instances[8].pose, 1)));
    EXPECT_GE(scene.parts().tree.parts().scale(), 0.5 * scale);
    expect_tight_boxes(scene);
}

} // namespace
} // namespace proxima::scene_tree_test
