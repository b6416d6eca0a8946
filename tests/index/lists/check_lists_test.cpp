// Every kind of damage to an index's lists is found and named.
#include "index/damaged_index.h"
#include "index/lists/block.h"
#include "index/lists/cost_model.h"
#include "proxima/closest_feature.h"

#include <cstring>

namespace proxima::check_lists_test {
namespace {

using testing::EditableIndex;
using CheckLists = testing::DamagedIndex;

TEST_F(CheckLists, NamesAWrongTableOfCells)
{
    expect_named({{"table", [](EditableIndex& e) { e.table.pop_back(); }},
                  {"table", [](EditableIndex& e) { e.table_depth += 1; }},
                  {"table", [](EditableIndex& e) { e.table.back() ^= 1; }},
                  {"table", [](EditableIndex& e) { e.table[0] = e.table.back(); }}});
}

TEST_F(CheckLists, NamesNodesOfListsThatFormNoTree)
{
    expect_named(
        {{"nodes come by eight", [](EditableIndex& e) { e.nodes.pop_back(); }},
         {"beyond the nodes", [](EditableIndex& e) { last_split(e) = e.nodes.size(); }},
         {"beyond the nodes",
          [](EditableIndex& e) { last_split(e) = (std::uint64_t{1} << 63U) - 8; }},
         {"beyond the nodes", [](EditableIndex& e) { last_split(e) += 1; }},
         {"children of two cells", [&](EditableIndex& e) { first_leaf(e) = last_split(e); }},
         {"without a parent", [&](EditableIndex& e) { last_split(e) = first_leaf(e); }},
         {"out of reach",
          [](EditableIndex& e) {
              // Eight more nodes, one of which has them as its children.
              const std::uint64_t base = e.nodes.size();
              e.nodes.insert(e.nodes.end(), 8, proximity_word::leaf(0, 1));
              e.nodes[base] = base;
          }},
         {"split at the deepest level", [&](EditableIndex& e) {
              // A chain of splits below a leaf, in front of the root's last child.
              const std::uint64_t leaf = first_leaf(e);
              std::size_t at = first_leaf_node;
              for (int level = 0; level < 15; ++level) {
                  const std::uint64_t base = e.nodes.size();
                  e.nodes[at] = base;
                  e.nodes.insert(e.nodes.end(), 8, leaf);
                  at = base;
              }
              // Their cells are those of the table as well.
              for (std::uint64_t& word : e.table)
                  if (word == leaf) word = first_leaf(e);
          }}});
}

TEST_F(CheckLists, NamesLeavesOfListsWithoutTrianglesOrRuns)
{
    expect_named(
        {{"no such triangles",
          [&](EditableIndex& e) { first_leaf(e) &= ~std::uint64_t{0xFFFFFFFF}; }},
         {"no such triangles",
          [&](EditableIndex& e) { first_leaf(e) |= std::uint64_t{0xFFFFFFFF}; }},
         {"no such triangles", [&](EditableIndex& e) { first_leaf(e) ^= std::uint64_t{1} << 32U; }},
         {"no such triangles",
          [&](EditableIndex& e) {
              first_leaf(e) |= std::uint64_t{proximity_word::max_position} << 32U;
          }},
         {"no such run",
          [&](EditableIndex& e) {
              first_leaf(e) = proximity_word::run(static_cast<std::uint32_t>(e.runs.size()));
          }},
         {"no such run",
          [&](EditableIndex& e) { first_leaf(e) = proximity_word::run(0) | 1 << 1; }}});
}

TEST_F(CheckLists, NamesADamagedRun)
{
    expect_named(
        {{"its run is damaged", [&](EditableIndex& e) { first_leaf(e) = proximity_word::run(0); }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].position = 0; }},
         {"its run is damaged",
          [](EditableIndex& e) { e.runs[0].position = static_cast<std::uint32_t>(e.runs.size()); }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].position = 0xFFFFFFFF; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].direction[1] += 0.5F; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].mask = 1; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].least = 1; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].mask = 0; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].least = float_nan; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].least = 3; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].least = -HUGE_VALF; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].direction[2] = float_nan; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].direction[0] = 1.01F; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].position += 1; }},
         // The last run ends beyond the others, in memory that still holds what was there.
         {"its run is damaged", [](EditableIndex& e) { e.runs.pop_back(); }},
         {"runs of no leaf", [](EditableIndex& e) { e.runs.emplace_back(); }}});
}

TEST_F(CheckLists, NamesADamagedHeaderOfABlockOfLists)
{
    const auto origin = [](std::size_t axis, float value) {
        return [=](EditableIndex& e) { std::memcpy(e.arena.data() + 4 * axis, &value, 4); };
    };
    const auto header_byte = [](std::size_t at, int value) {
        return [=](EditableIndex& e) { e.arena[at] = static_cast<std::byte>(value); };
    };
    expect_named({{"a block is damaged", origin(0, float_nan)},
                  {"a block is damaged", origin(1, float_nan)},
                  {"a block is damaged", origin(2, -HUGE_VALF)},
                  {"a block is damaged", header_byte(15, 0x7F)}, // the unit is no longer a number
                  {"a block is damaged", header_byte(15, 0x80)},
                  {"a block is damaged", header_byte(17, 0x80)},
                  {"a block is damaged", header_byte(19, 0xFF)},
                  {"a block is damaged", header_byte(22, 0x40)}, // ranks beyond the rows
                  {"a block is damaged", header_byte(24, 0)},
                  {"a block is damaged", header_byte(24, 33)},
                  {"a block is damaged", header_byte(25, 0)},
                  {"a block is damaged", header_byte(25, 33)},
                  {"a block is damaged", header_byte(26, 2)},
                  {"a block is damaged", header_byte(27, 1)}});
}

TEST_F(CheckLists, NamesTrianglesOfBlocksThatThereAreNot)
{
    const auto header_of = [](const EditableIndex& e, std::size_t at) {
        BlockHeader header;
        std::memcpy(&header, e.arena.data() + at, sizeof header);
        return header;
    };
    const auto set = [](EditableIndex& e, std::size_t at, std::uint16_t value) {
        std::memcpy(e.arena.data() + at, &value, sizeof value);
    };
    expect_named(
        {{"a block is damaged",
          [&](EditableIndex& e) { // a corner one beyond the last vertex
              const BlockHeader header = header_of(e, 0);
              ASSERT_LT(header.vertices, 32);
              set(e, block_layout(header.vertices, header.triangles, false).corners,
                  header.vertices);
          }},
         {"a block is damaged",
          [&](EditableIndex& e) { // a rank one beyond the last row
              const BlockHeader header = header_of(e, 0);
              ASSERT_EQ(header.wide, 0);
              set(e, block_layout(header.vertices, header.triangles, false).ranks,
                  static_cast<std::uint16_t>(e.rows.size() - header.base));
          }},
         {"no such triangles",
          [&](EditableIndex& e) { // one more than a list may have of a block
              std::size_t at = 0;
              while (header_of(e, at).triangles <= list_triangles) {
                  const BlockHeader header = header_of(e, at);
                  at += block_layout(header.vertices, header.triangles, header.wide != 0).end;
                  at = (at + block_alignment - 1) / block_alignment * block_alignment;
                  ASSERT_LT(at + block_padding, e.arena.size());
              }
              first_leaf(e) = proximity_word::leaf(static_cast<std::uint32_t>(at / block_alignment),
                                                   (2U << list_triangles) - 1);
          }}});
}

TEST_F(CheckLists, TakesAndDamagesWideBlocks)
{
    EditableIndex wide(sound_index);
    testing::widen_blocks(wide);
    EXPECT_EQ(wide.fault(), "");
    const auto set = [](EditableIndex& e, std::uint32_t value) {
        testing::widen_blocks(e);
        BlockHeader header;
        std::memcpy(&header, e.arena.data(), sizeof header);
        const BlockLayout layout = block_layout(header.vertices, header.triangles, true);
        value -= header.base;
        std::memcpy(e.arena.data() + layout.ranks, &value, sizeof value);
    };
    EditableIndex last(sound_index);
    set(last, static_cast<std::uint32_t>(last.rows.size() - 1));
    EXPECT_EQ(last.fault(), "");
    expect_named({{"a block is damaged",
                   [&](EditableIndex& e) { set(e, static_cast<std::uint32_t>(e.rows.size())); }},
                  {"a block is damaged", [&](EditableIndex& e) { set(e, 0x10000); }}});
}

TEST_F(CheckLists, WideBlocksAnswerLikeOthers)
{
    EditableIndex wide(sound_index);
    testing::widen_blocks(wide);
    const MeshIndex index = wide.adopted();
    const TriangleMesh mesh = mesh_of(sound_index).value();
    for (const Vec3& p : testing::proximity_points(mesh, 500, 5)) {
        const ClosestFeature found = closest_feature(index, p).value();
        const ClosestFeature expected = closest_feature(sound_index, p).value();
        ASSERT_EQ(found.feature, expected.feature);
        ASSERT_EQ(found.triangle, expected.triangle);
        ASSERT_EQ(found.point, expected.point);
    }
}

TEST(Blocks, AreWideWhereSixteenBitsDoNotHoldTheirRanks)
{
    for (const std::uint32_t first : {0U, 5U}) {
        for (const std::uint32_t difference : {1U, 0xFFFFU, 0x10000U, 0xFFFFFFF0U}) {
            std::vector<std::byte> arena;
            const std::vector<Vec3> points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
            // The highest rank first: order does not matter.
            append_block(
                std::vector<BlockTriangle>{{first + difference, {0, 1, 2}}, {first, {0, 2, 1}}},
                points, arena);
            BlockHeader header;
            std::memcpy(&header, arena.data(), sizeof header);
            EXPECT_EQ(header.base, first);
            EXPECT_EQ(header.wide, difference > 0xFFFFU ? 1 : 0);
            const BlockLayout layout = block_layout(header.vertices, 2, header.wide != 0);
            for (const std::uint32_t k : {0U, 1U}) {
                std::uint32_t rank = 0;
                const std::size_t bytes = header.wide != 0 ? 4 : 2;
                std::memcpy(&rank, arena.data() + layout.ranks + bytes * k, bytes);
                EXPECT_EQ(rank, k == 0 ? difference : 0U);
            }
        }
    }
}

TEST_F(CheckLists, NamesBytesOfListsThatBelongToNoBlock)
{
    expect_named(
        {{"a block is damaged", [](EditableIndex& e) { e.arena.resize(block_padding + 20); }},
         {"blocks of no leaf",
          [](EditableIndex& e) {
              // The first block again behind the last.
              BlockHeader header;
              std::memcpy(&header, e.arena.data(), sizeof header);
              const std::size_t bytes =
                  block_layout(header.vertices, header.triangles, header.wide != 0).end;
              const std::vector<std::byte> block(e.arena.data(), e.arena.data() + bytes);
              e.arena.resize(e.arena.size() - block_padding);
              e.arena.resize((e.arena.size() + block_alignment - 1) / block_alignment *
                             block_alignment);
              e.arena.insert(e.arena.end(), block.begin(), block.end());
              e.arena.resize(e.arena.size() + block_padding);
          }},
         {"bytes between blocks",
          [](EditableIndex& e) {
              // Behind the first block that ends within what blocks are aligned to.
              for (std::size_t at = 0;;) {
                  BlockHeader header;
                  std::memcpy(&header, e.arena.data() + at, sizeof header);
                  at += block_layout(header.vertices, header.triangles, header.wide != 0).end;
                  if (at % block_alignment != 0) {
                      e.arena[at] = std::byte{1};
                      return;
                  }
              }
          }},
         {"no padding", [](EditableIndex& e) { e.arena.clear(); }},
         {"padding", [](EditableIndex& e) { e.arena.back() = std::byte{1}; }},
         {"block is damaged", [](EditableIndex& e) { e.arena.resize(e.arena.size() + 1); }}});
}

TEST_F(CheckLists, TakesAnArenaOfItsPaddingAlone)
{
    EditableIndex edited(sound_index);
    edited.table.assign(1, proximity_word::search);
    edited.table_depth = 0;
    edited.nodes.clear();
    edited.runs.clear();
    edited.arena.assign(block_padding, std::byte{0});
    edited.statistics = {};
    edited.statistics.nodes = 1;
    edited.statistics.leaves = 1;
    edited.statistics.searched_leaves = 1;
    edited.statistics.worst_case_steps = 1;
    EXPECT_EQ(edited.fault(), "");
    edited.arena.back() = std::byte{1};
    EXPECT_NE(edited.fault().find("the padding is damaged"), std::string::npos);
}

TEST_F(CheckLists, NamesWrongStatisticsOfLists)
{
    expect_named({{"statistics", [&](EditableIndex& e) { first_leaf(e) = proximity_word::search; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.searched_leaves += 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.worst_case_steps -= 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.worst_case_blocks -= 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.references += 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.expected_list = nan; }}});
}

} // namespace
} // namespace proxima::check_lists_test
