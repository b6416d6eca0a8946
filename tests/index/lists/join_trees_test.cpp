// Lists that are too large for their words are told apart, not built: by numbers alone.
#include "index/lists/join_trees.h"

#include "index/lists/emit_lists.h"
#include "index/lists/shared_blocks.h"

#include <array>
#include <gtest/gtest.h>
#include <vector>

namespace proxima::join_trees_test {
namespace {

constexpr std::size_t positions = std::size_t{1} << 30U;

/// A tree that is a leaf of one triangle.
EmittedTree leaf()
{
    const std::vector<Vec3> corners{Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)};
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}};
    BlockSharer sharer(BlockSource{corners, triangles});
    sharer.begin();
    const BlockSharer::Location location = sharer.put(std::array{0U});
    sharer.end();
    EmittedTree tree;
    tree.positions = sharer.positions();
    tree.arena = sharer.arena();
    tree.root = proximity_word::leaf(location.number, location.mask);
    return tree;
}

TEST(JoinTrees, TellWhereBlocksAreBeyondTheReachOfWords)
{
    const EmittedTree tree = leaf();
    const std::size_t last = (positions - 1) * block_alignment;
    EXPECT_LT(part_of_words(last, 0), 1);
    EXPECT_EQ(moved_word(tree.root, tree, {.first_byte = last}),
              proximity_word::leaf(positions - 1, 1));
    EXPECT_GT(part_of_words(last + tree.arena.size(), 0), 1);
    const std::size_t beyond = positions * block_alignment;
    EXPECT_TRUE(proximity_word::is_block(moved_word(tree.root, tree, {.first_byte = beyond})));
    EXPECT_GT(part_of_words(beyond + tree.arena.size(), 0), 1);
}

TEST(JoinTrees, TellWhereRunsAreBeyondTheReachOfWords)
{
    const EmittedTree tree = leaf();
    const std::uint64_t run = proximity_word::run(0);
    EXPECT_EQ(moved_word(run, tree, {.first_run = positions - 1}),
              proximity_word::run(positions - 1));
    EXPECT_EQ(part_of_words(0, positions), 1);
    EXPECT_TRUE(proximity_word::is_run(moved_word(run, tree, {.first_run = positions})));
    EXPECT_EQ(moved_word(run, tree, {.first_run = positions}), proximity_word::run(0));
    EXPECT_GT(part_of_words(0, positions + 1), 1);
}

TEST(JoinTrees, AreAPartOfTheBytesTheyMayTake)
{
    EmittedLists lists;
    lists.arena.resize(1000);
    EXPECT_EQ(lists.part_of(2000), 0.5);
    EXPECT_EQ(lists.part_of(500), 2);
    lists.arena.resize(block_alignment);
    EXPECT_EQ(lists.part_of(1e300), part_of_words(block_alignment, 0));
}

} // namespace
} // namespace proxima::join_trees_test
