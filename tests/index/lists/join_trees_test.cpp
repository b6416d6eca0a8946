// Lists that are too large for their words are told apart, not built.
#include "index/lists/join_trees.h"

#include "index/lists/emit_lists.h"
#include "index/lists/rank_blocks.h"
#include "index/lists/shared_blocks.h"

#include <array>
#include <gtest/gtest.h>
#include <new>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <vector>

namespace proxima::join_trees_test {

/// Whether pages that are never touched may be more than the machine has.
static bool has_no_reserve = false;

} // namespace proxima::join_trees_test

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PROXIMA_MMAP_IS_TAKEN // by the sanitizer
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PROXIMA_MMAP_IS_TAKEN
#endif

#ifndef PROXIMA_MMAP_IS_TAKEN
/// In place of the C library's, for all of this program.
extern "C" void* mmap(void* address, std::size_t bytes, int protection, int flags, int file,
                      off_t offset) noexcept
{
    if (proxima::join_trees_test::has_no_reserve) flags |= MAP_NORESERVE;
    // NOLINTNEXTLINE(performance-no-int-to-ptr): as the system call returns it
    return reinterpret_cast<void*>(
        ::syscall(SYS_mmap, address, bytes, protection, flags, file, offset));
}
#endif

namespace proxima::join_trees_test {
namespace {

constexpr std::size_t positions = std::size_t{1} << 30U;

class JoinTrees : public ::testing::Test {
protected:
    void SetUp() override { has_no_reserve = true; }
    void TearDown() override { has_no_reserve = false; }

    /// A tree that is a leaf of one triangle.
    [[nodiscard]] EmittedTree leaf() const
    {
        BlockSharer sharer(source);
        sharer.begin();
        const BlockSharer::Location location = sharer.put(std::array{0U});
        sharer.end();
        EmittedTree tree;
        tree.positions = sharer.positions();
        tree.arena = sharer.arena();
        tree.root = proximity_word::leaf(location.number, location.mask);
        return tree;
    }

    const std::vector<Vec3> corners{Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)};
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}};
    const BlockSource source{corners, triangles};
    const RankBlocks by_rank{source};
    EmittedLists lists;
};

TEST_F(JoinTrees, TellWhereBlocksAreBeyondTheReachOfWords)
{
    try {
        // Pages that are never touched.
        lists.arena.reserve(positions * block_alignment + 4096);
    } catch (const std::bad_alloc&) {
        GTEST_SKIP() << "no room for 8 GiB of addresses";
    }
    lists.arena.resize((positions - 1) * block_alignment);
    OctreeJoiner joiner(lists, {}, by_rank);
    EXPECT_LT(lists.part_of(1e11), 1);
    EXPECT_EQ(joiner.join(leaf()), proximity_word::leaf(positions - 1, 1));
    EXPECT_GT(lists.part_of(1e11), 1);
    EXPECT_TRUE(proximity_word::is_block(joiner.join(leaf())));
    EXPECT_GT(lists.part_of(1e11), 1);
}

TEST_F(JoinTrees, TellWhereRunsAreBeyondTheReachOfWords)
{
    try {
        lists.runs.reserve(positions + 16);
    } catch (const std::bad_alloc&) {
        GTEST_SKIP() << "no room for 24 GiB of addresses";
    }
    lists.runs.resize(positions);
    EmittedTree tree = leaf();
    tree.runs.resize(3);
    tree.runs[0].position = 2;
    tree.root = proximity_word::run(0);
    OctreeJoiner joiner(lists, {}, by_rank);
    EXPECT_EQ(lists.part_of(1e11), 1);
    EXPECT_TRUE(proximity_word::is_run(joiner.join(tree)));
    EXPECT_GT(lists.part_of(1e11), 1);
}

TEST_F(JoinTrees, AreAPartOfTheBytesTheyMayTake)
{
    lists.arena.resize(1000);
    EXPECT_EQ(lists.part_of(2000), 0.5);
    EXPECT_EQ(lists.part_of(500), 2);
}

} // namespace
} // namespace proxima::join_trees_test
