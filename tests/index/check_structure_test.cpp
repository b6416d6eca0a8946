// Every kind of damage to an index's arrays is found and named.
#include "index/check_structure.h"

#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/block.h"
#include "index/lists/proximity_lists.h"
#include "index/signs/sign_parts.h"
#include "index/slabs/block_slab.h"
#include "index/test_meshes.h"
#include "lab/query_sets.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/closest/check_answers.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

namespace proxima {
namespace {

/// The index with its arrays copied, for tests that break them.
struct EditableIndex {
    explicit EditableIndex(const MeshIndex& whole) : index(whole) {}

    MeshIndex index;
    std::vector<IndexBlock> blocks{index.parts().blocks().begin(), index.parts().blocks().end()};
    std::vector<TriangleRow<float>> rows{index.parts().float_rows().begin(),
                                         index.parts().float_rows().end()};
    std::vector<TriangleId> ids{index.ids().begin(), index.ids().end()};
    std::vector<std::uint32_t> vertex_incidences{index.parts().vertex_incidences().begin(),
                                                 index.parts().vertex_incidences().end()};
    std::vector<std::uint32_t> edge_incidences{index.parts().edge_incidences().begin(),
                                               index.parts().edge_incidences().end()};
    std::vector<BlockSlab> slabs{index.parts().slabs().begin(), index.parts().slabs().end()};
    std::uint32_t root = index.parts().root();
    Vec3 center = index.parts().center();
    double scale = index.parts().scale();

    ProximityArrays lists = index.parts().lists()->arrays();
    std::vector<std::uint64_t> table{lists.table.begin(), lists.table.end()};
    std::vector<std::uint64_t> nodes{lists.nodes.begin(), lists.nodes.end()};
    std::vector<RunEntry> runs{lists.runs.begin(), lists.runs.end()};
    std::vector<std::byte> arena{lists.arena.begin(), lists.arena.end()};
    RootFrame frame = index.parts().lists()->frame();
    ProximityStatistics statistics = index.parts().lists()->statistics();
    int table_depth = index.parts().lists()->table_depth();

    SignArrays signs = index.parts().signs()->arrays();
    std::vector<std::uint32_t> sign_rows{signs.rows.begin(), signs.rows.end()};
    std::vector<SurfaceSides> sides{signs.sides.begin(), signs.sides.end()};
    std::vector<SurfaceSides> vertex_sides{signs.vertex_sides.begin(), signs.vertex_sides.end()};
    std::vector<VertexSign> vertex_signs{signs.vertices.begin(), signs.vertices.end()};
    std::vector<std::uint32_t> edges{signs.edges.begin(), signs.edges.end()};
    std::vector<std::uint32_t> edge_lists{signs.edge_lists.begin(), signs.edge_lists.end()};
    std::vector<WindingCluster> clusters{signs.winding.clusters.begin(),
                                         signs.winding.clusters.end()};
    std::vector<std::uint32_t> order{signs.winding.order.begin(), signs.winding.order.end()};

    [[nodiscard]] std::shared_ptr<const SignParts> adopted_signs() const
    {
        SignArrays arrays = signs; // bounds and least height
        arrays.rows = sign_rows;
        arrays.sides = sides;
        arrays.vertex_sides = vertex_sides;
        arrays.vertices = vertex_signs;
        arrays.edges = edges;
        arrays.edge_lists = edge_lists;
        arrays.winding = {clusters, order, signs.winding.unit};
        return std::make_shared<const SignParts>(SignParts::adopt(arrays, nullptr));
    }

    /// The index of the edited arrays. \pre this outlives it
    [[nodiscard]] MeshIndex adopted() const
    {
        IndexArrays arrays;
        arrays.center = center;
        arrays.scale = scale;
        arrays.fingerprint = index.mesh_fingerprint();
        arrays.root = root;
        arrays.has_exact_leaves = index.parts().has_exact_leaves();
        arrays.blocks = blocks;
        arrays.float_rows = rows;
        arrays.double_rows = index.parts().double_rows();
        arrays.ids = ids;
        arrays.vertex_incidences = vertex_incidences;
        arrays.edge_incidences = edge_incidences;
        return make_mesh_index(
            IndexParts::adopt(arrays, nullptr)
                .adopt_slabs(slabs, nullptr)
                .adopt_signs(adopted_signs())
                .adopt_lists(std::make_shared<const ProximityLists>(ProximityLists::adopt(
                    frame, table_depth, {table, nodes, runs, arena}, statistics, nullptr))));
    }

    /// The message of the check, "" where it finds nothing: the same for any number of threads.
    [[nodiscard]] std::string fault() const
    {
        const MeshIndex edited = adopted();
        const auto message = [&](int threads) {
            const Status status = check_structure(edited, {.execution = {.threads = {threads}}});
            return status ? std::string() : describe(status.error());
        };
        std::string found = message(1);
        EXPECT_EQ(message(3), found);
        return found;
    }
};

/// The slot of the root's child of that number.
std::size_t slot_of(const EditableIndex& e, std::size_t number)
{
    const auto& children = e.blocks[e.root].node.children;
    std::size_t slot = 0;
    for (;; ++slot) {
        if (children[slot] != index_leaf_bit && number-- == 0) return slot;
    }
}

std::uint32_t* child_of(EditableIndex& e, std::size_t number)
{
    return &e.blocks[e.root].node.children[slot_of(e, number)];
}

IndexLeaf& first_leaf_of(EditableIndex& e)
{
    std::uint32_t at = e.root;
    while ((at & index_leaf_bit) == 0) {
        const auto& children = e.blocks[at].node.children;
        at = *std::ranges::find_if(children, [](std::uint32_t c) { return c != index_leaf_bit; });
    }
    return e.blocks[at & ~index_leaf_bit].leaf;
}

/// What is done to a sound index, and what the check is to say of it.
struct Damage {
    const char* fault;
    std::function<void(EditableIndex&)> damage;
};

/// An index with lists, runs, a table, slabs and signs of a torus, whose parts the tests break.
class CheckStructure : public ::testing::Test {
protected:
    void SetUp() override
    {
        // Coordinates that floats hold.
        const TriangleMesh mesh =
            testing::moved(sample_mesh("torus:24x36").value(), [](const Vec3& p) {
                return Vec3((p * 0x1p20).array().round().matrix() * 0x1p-20);
            });
        const MeshIndex listed =
            testing::listed_index(mesh, {.list_bytes = 225 * mesh.triangle_count() + 4096}).value();
        index_ = with_signs(with_slabs(listed).value()).value();
        ASSERT_TRUE(index_.parts().signs()->is_local());
        const ProximityLists* lists = index_.parts().lists();
        ASSERT_FALSE(index_.parts().float_rows().empty());
        ASSERT_FALSE(lists->arrays().runs.empty());
        ASSERT_GT(lists->table_depth(), 0);
        const auto& nodes = lists->arrays().nodes;
        first_leaf_ = static_cast<std::size_t>(
            std::ranges::find_if(nodes,
                                 [](std::uint64_t word) {
                                     return proximity_word::is_leaf(word) &&
                                            !proximity_word::is_run(word);
                                 }) -
            nodes.begin());
        ASSERT_LT(first_leaf_, nodes.size());
    }

    /// Breaks a fresh copy of the index in each of these ways, and expects the fault to be named.
    void expect_named(const std::vector<Damage>& damages) const
    {
        for (std::size_t i = 0; i < damages.size(); ++i) {
            EditableIndex edited(index_);
            damages[i].damage(edited);
            const std::string found = edited.fault();
            EXPECT_NE(found.find(damages[i].fault), std::string::npos)
                << "damage " << i << ": expected \"" << damages[i].fault << "\", found " << found;
        }
    }

    /// The word of the first node that is a leaf with a block of its own.
    [[nodiscard]] std::uint64_t& first_leaf(EditableIndex& e) const { return e.nodes[first_leaf_]; }

    /// The word of the last node that has children.
    [[nodiscard]] static std::uint64_t& last_split(EditableIndex& e)
    {
        std::size_t i = e.nodes.size();
        while (proximity_word::is_leaf(e.nodes[--i])) {
        }
        return e.nodes[i];
    }

    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    static constexpr float float_nan = std::numeric_limits<float>::quiet_NaN();
    MeshIndex index_;
    std::size_t first_leaf_ = 0;
};

TEST_F(CheckStructure, AcceptsASoundIndex)
{
    EXPECT_EQ(EditableIndex(index_).fault(), "");
}

TEST_F(CheckStructure, NamesAWrongFrame)
{
    expect_named(
        {{"frame", [](EditableIndex& e) { e.frame.center[1] = nan; }},
         {"frame", [](EditableIndex& e) { e.frame.scale *= 1.5; }},
         {"frame", [](EditableIndex& e) { e.frame.scale *= 4; }},
         {"outside of the root", [](EditableIndex& e) { e.frame.center[1] += e.frame.half; }},
         {"frame", [](EditableIndex& e) { e.center[1] = nan; }},
         {"frame", [](EditableIndex& e) { e.scale *= 1.5; }},
         {"not its row's", [](EditableIndex& e) { e.scale *= 2; }}});
}

TEST_F(CheckStructure, NamesAWrongTableOfCells)
{
    expect_named({{"table", [](EditableIndex& e) { e.table.pop_back(); }},
                  {"table", [](EditableIndex& e) { e.table_depth += 1; }},
                  {"table", [](EditableIndex& e) { e.table.back() ^= 1; }},
                  {"table", [](EditableIndex& e) { e.table[0] = e.table.back(); }}});
}

TEST_F(CheckStructure, NamesNodesOfListsThatFormNoTree)
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
              std::size_t at = first_leaf_;
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

TEST_F(CheckStructure, NamesLeavesOfListsWithoutTrianglesOrRuns)
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

TEST_F(CheckStructure, NamesADamagedRun)
{
    expect_named(
        {{"its run is damaged", [&](EditableIndex& e) { first_leaf(e) = proximity_word::run(0); }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].position = 0; }},
         {"its run is damaged",
          [](EditableIndex& e) { e.runs[0].position = static_cast<std::uint32_t>(e.runs.size()); }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].position = 0xFFFFFFFF; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[0].direction[1] += 0.5F; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].mask = 0; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].least = float_nan; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].least = 3; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].direction[2] = float_nan; }},
         {"its run is damaged", [](EditableIndex& e) { e.runs[1].position += 1; }},
         {"runs of no leaf", [](EditableIndex& e) { e.runs.emplace_back(); }}});
}

TEST_F(CheckStructure, NamesADamagedHeaderOfABlockOfLists)
{
    const auto origin = [](float value) {
        return [=](EditableIndex& e) { std::memcpy(e.arena.data(), &value, 4); };
    };
    const auto header_byte = [](std::size_t at, int value) {
        return [=](EditableIndex& e) { e.arena[at] = static_cast<std::byte>(value); };
    };
    expect_named({{"a block is damaged", origin(float_nan)},
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

TEST_F(CheckStructure, NamesBytesOfListsThatBelongToNoBlock)
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
         {"no padding", [](EditableIndex& e) { e.arena.clear(); }},
         {"padding", [](EditableIndex& e) { e.arena.back() = std::byte{1}; }},
         {"block is damaged", [](EditableIndex& e) { e.arena.resize(e.arena.size() + 1); }}});
}

TEST_F(CheckStructure, NamesWrongStatisticsOfLists)
{
    expect_named({{"statistics", [&](EditableIndex& e) { first_leaf(e) = proximity_word::search; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.searched_leaves += 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.worst_case_steps -= 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.worst_case_blocks -= 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.references += 1; }},
                  {"statistics", [](EditableIndex& e) { e.statistics.expected_list = nan; }}});
}

TEST_F(CheckStructure, NamesADamagedRow)
{
    expect_named(
        {{"not its row's", [](EditableIndex& e) { e.rows[7].coordinates[1][2] = 1e9F; }},
         {"not its row's", [](EditableIndex& e) { e.rows[7].coordinates[1][2] = float_nan; }},
         {"no such vertex",
          [](EditableIndex& e) { e.rows[7].vertices[1] = static_cast<std::uint32_t>(~0U); }},
         {"direction", [](EditableIndex& e) { e.rows[7].triangle ^= e.rows[7].side_bit; }},
         {"no such edge",
          [](EditableIndex& e) {
              e.rows[7].edges[2] = static_cast<std::uint32_t>(e.edge_incidences.size());
          }},
         {"an edge of one vertex",
          [](EditableIndex& e) { e.rows[7].edges[2] = to_index(no_edge); }},
         {"a triangle twice", // the last one: all its vertices and edges have lower triangles
          [](EditableIndex& e) {
              const auto last = static_cast<std::uint32_t>(e.rows.size()) - 1;
              for (TriangleRow<float>& row : e.rows)
                  if (row.triangle_id() == last) --row.triangle;
              for (TriangleId& id : e.ids)
                  if (id == TriangleId{last}) id = TriangleId{last - 1};
          }},
         {"another triangle's id", [](EditableIndex& e) { std::swap(e.ids[3], e.ids[4]); }},
         {"no such triangle",
          [](EditableIndex& e) { e.rows[7].triangle |= TriangleRow<float>::side_bit - 1; }},
         {"impossible number of triangles", [](EditableIndex& e) { e.rows.clear(); }},
         {"impossible number of triangles", [](EditableIndex& e) { e.rows.pop_back(); }},
         {"impossible number of triangles", [](EditableIndex& e) { e.ids.pop_back(); }}});
}

TEST_F(CheckStructure, NamesAWrongPlaceOfAVertexOrAnEdge)
{
    expect_named(
        {{"a vertex's incidence is wrong",
          [](EditableIndex& e) {
              e.vertex_incidences[3] = static_cast<std::uint32_t>(e.rows.size());
          }},
         {"an edge's incidence is wrong",
          [](EditableIndex& e) {
              e.edge_incidences[3] = static_cast<std::uint32_t>(e.rows.size());
          }},
         {"a vertex's incidence is wrong",
          [](EditableIndex& e) { e.vertex_incidences[3] = incidence::none; }},
         {"incidences of no row", [](EditableIndex& e) { e.vertex_incidences[3] ^= 3U << 28U; }},
         {"incidences of no row", [](EditableIndex& e) { e.edge_incidences[3] ^= 3U << 28U; }},
         {"incidences of no row", [](EditableIndex& e) { e.edge_incidences[3] ^= 1U << 30U; }},
         {"incidences of no row", [](EditableIndex& e) { e.edge_incidences[3] = 0; }}});
}

TEST_F(CheckStructure, NamesBlocksThatFormNoTree)
{
    expect_named(
        {{"slabs", [](EditableIndex& e) { e.slabs.pop_back(); }},
         {"no such root", [](EditableIndex& e) { e.root = 0; }},
         {"no such root",
          [](EditableIndex& e) { e.root = static_cast<std::uint32_t>(e.blocks.size()); }},
         {"a child that is none, or twice",
          [](EditableIndex& e) { *child_of(e, 0) = static_cast<std::uint32_t>(e.blocks.size()); }},
         {"a child that is none, or twice", [](EditableIndex& e) { *child_of(e, 0) = e.root; }},
         {"a child that is none, or twice",
          [](EditableIndex& e) { *child_of(e, 0) = *child_of(e, 1); }},
         {"a child that is none, or twice", [](EditableIndex& e) { *child_of(e, 0) = 0; }},
         {"blocks of no node", [](EditableIndex& e) { *child_of(e, 0) = index_leaf_bit; }},
         {"blocks of no node",
          [](EditableIndex& e) {
              e.blocks.emplace_back(e.blocks[0]);
              e.slabs.emplace_back();
          }},
         {"it is not empty", [](EditableIndex& e) { e.blocks[0].leaf.count = 1; }}});
}

TEST_F(CheckStructure, NamesANodeWithWrongBoxesOrOrderOfItsChildren)
{
    expect_named(
        {{"does not hold",
          [](EditableIndex& e) {
              e.blocks[e.root].node.origin[2] += e.blocks[e.root].node.step[2] * 3;
          }},
         {"does not hold", [](EditableIndex& e) { e.blocks[e.root].node.step[1] = float_nan; }},
         {"a box of no child",
          [](EditableIndex& e) {
              auto& planes = e.blocks[e.root].node.planes[1];
              planes[slot_of(e, 0)] = 255;
              planes[8 + slot_of(e, 0)] = 0;
          }},
         {"order of its children", [](EditableIndex& e) { e.blocks[e.root].node.order ^= 1; }},
         {"order of its children", [](EditableIndex& e) { e.blocks[e.root].node.first_row = 5; }},
         {"order of its children",
          [](EditableIndex& e) { e.blocks[e.root].node.starts[slot_of(e, 0)] ^= 64; }}});
}

TEST_F(CheckStructure, NamesADamagedLeaf)
{
    expect_named(
        {{"impossible number", [](EditableIndex& e) { first_leaf_of(e).count = 9; }},
         {"impossible number", [](EditableIndex& e) { first_leaf_of(e).count = 0; }},
         {"no such rows", [](EditableIndex& e) { first_leaf_of(e).first_row = 0xFFFFFFFF; }},
         {"no such corner", [](EditableIndex& e) { first_leaf_of(e).corners[1][7] = 8; }},
         {"outside of the frame", [](EditableIndex& e) { first_leaf_of(e).coordinates[1][7] = 2; }},
         {"outside of the frame",
          [](EditableIndex& e) { first_leaf_of(e).coordinates[1][7] = float_nan; }},
         {"extent", [](EditableIndex& e) { first_leaf_of(e).extent_bits = 0; }},
         {"extent", [](EditableIndex& e) { first_leaf_of(e).extent_bits = 0x7FFF; }}});
}

TEST_F(CheckStructure, NamesSignsOfOtherNumbers)
{
    expect_named(
        {{"signs of another number of triangles", [](EditableIndex& e) { e.sign_rows.pop_back(); }},
         {"signs of another number of triangles", [](EditableIndex& e) { e.order.pop_back(); }},
         {"signs of another number of vertices", [](EditableIndex& e) { e.sides.clear(); }},
         {"signs of another number of vertices",
          [](EditableIndex& e) { e.vertex_sides.pop_back(); }},
         {"signs of another number of vertices",
          [](EditableIndex& e) { e.vertex_signs.pop_back(); }},
         {"signs of another number of vertices", [](EditableIndex& e) { e.edges.emplace_back(); }},
         {"no power of two", [](EditableIndex& e) { e.signs.winding.unit = nan; }},
         {"no power of two", [](EditableIndex& e) { e.signs.winding.unit = -1; }}});
}

TEST_F(CheckStructure, NamesWrongRowsAndSidesOfSigns)
{
    constexpr auto no_sides = static_cast<SurfaceSides>(4);
    expect_named(
        {{"another triangle's row",
          [](EditableIndex& e) { e.sign_rows[3] = static_cast<std::uint32_t>(e.rows.size()); }},
         {"another triangle's row",
          [](EditableIndex& e) { std::swap(e.sign_rows[3], e.sign_rows[4]); }},
         {"signs of row 5: no such sides", [](EditableIndex& e) { e.sides[5] = no_sides; }},
         {"signs of vertex 5: no such sides",
          [](EditableIndex& e) { e.vertex_sides[5] = no_sides; }}});
}

TEST_F(CheckStructure, NamesWrongTrianglesOfEdges)
{
    expect_named(
        {{"a triangle without the edge",
          [](EditableIndex& e) { e.edges[3] = static_cast<std::uint32_t>(e.rows.size()); }},
         {"a triangle without the edge",
          [](EditableIndex& e) { std::swap(e.edges[3], e.edges[90]); }},
         {"no such list", [](EditableIndex& e) { e.edges[3] = edge_list_bit; }},
         {"no such list", [](EditableIndex& e) { e.edges[3] = 0xFFFFFFFF; }},
         {"no such list",
          [](EditableIndex& e) {
              e.edges[3] = edge_list_bit;
              e.edge_lists = {2, e.edges[3]};
          }},
         {"no such list",
          [](EditableIndex& e) {
              // Two edges with one list.
              e.edge_lists = {0};
              e.edges[3] = e.edges[4] = edge_list_bit;
          }},
         {"a triangle without the edge",
          [](EditableIndex& e) {
              e.edge_lists = {1, e.edges[90]};
              e.edges[3] = edge_list_bit;
          }},
         {"lists of no edge", [](EditableIndex& e) { e.edge_lists = {0}; }}});
}

TEST_F(CheckStructure, AcceptsAListOfAnEdge)
{
    EditableIndex edited(index_);
    edited.edge_lists = {1, edited.edges[3]};
    edited.edges[3] = edge_list_bit;
    EXPECT_EQ(edited.fault(), "");
}

TEST_F(CheckStructure, NamesClustersThatFormNoTree)
{
    expect_named(
        {{"no clusters", [](EditableIndex& e) { e.clusters.clear(); }},
         {"not all triangles", [](EditableIndex& e) { e.clusters[0].count -= 1; }},
         {"not all triangles", [](EditableIndex& e) { e.clusters[0].first = 1; }},
         {"not all triangles", [](EditableIndex& e) { e.clusters[0].next -= 1; }},
         {"not all triangles", [](EditableIndex& e) { e.clusters.emplace_back(); }},
         {"form no tree", [](EditableIndex& e) { e.clusters[1].next = 1; }},
         {"form no tree", [](EditableIndex& e) { e.clusters[1].next = 0; }},
         {"form no tree", [](EditableIndex& e) { e.clusters[1].next = 0xFFFFFFFF; }},
         {"form no tree", [](EditableIndex& e) { e.clusters[1].next += 1; }},
         {"form no tree", [](EditableIndex& e) { e.clusters[e.clusters[1].next].next -= 1; }},
         {"form no tree", [](EditableIndex& e) { e.clusters[1].first += 1; }},
         {"form no tree", [](EditableIndex& e) { e.clusters[1].count += 1; }},
         {"form no tree", [](EditableIndex& e) { e.clusters.back().count = 0; }},
         {"form no tree", [](EditableIndex& e) { e.clusters.back().first = 0xFFFFFFFF; }},
         {"no such row",
          [](EditableIndex& e) { e.order[9] = static_cast<std::uint32_t>(e.rows.size()); }},
         {"a row twice", [](EditableIndex& e) { e.order[9] = e.order[200]; }}});
}

TEST(CheckAnswers, FindsALeafThatOmitsATriangle)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = testing::listed_index(mesh).value();
    std::vector<Vec3> points;
    for (const QuerySet& set : query_sets(mesh, 500, 3))
        points.insert(points.end(), set.points.begin(), set.points.end());
    const auto message = [&](const MeshIndex& of, int threads) {
        const Status status =
            check_answers(of, mesh, topology, points, {.execution = {.threads = {threads}}});
        return status ? std::string() : describe(status.error());
    };
    EXPECT_EQ(message(index, 1), "");
    // In every leaf of one block the last of its triangles is forgotten: the structure is sound.
    EditableIndex edited(with_signs(index).value());
    for (std::vector<std::uint64_t>* const words : {&edited.table, &edited.nodes}) {
        for (std::uint64_t& word : *words) {
            const std::uint32_t mask = proximity_word::mask(word);
            if (proximity_word::is_leaf(word) && proximity_word::is_block(word) &&
                std::popcount(mask) > 1)
                word = proximity_word::leaf(proximity_word::position(word), mask & (mask - 1));
        }
    }
    const MeshIndex broken = edited.adopted();
    const std::string found = message(broken, 1);
    EXPECT_NE(found.find("the index answers"), std::string::npos) << found;
    EXPECT_NE(found.find("the closest is"), std::string::npos) << found;
    EXPECT_EQ(message(broken, 3), found);
}

TEST(CheckAnswers, CanBeCancelled)
{
    const TriangleMesh mesh = sample_mesh("cube").value();
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = testing::listed_index(mesh).value();
    Progress progress;
    progress.cancel();
    const std::vector<Vec3> points(10, Vec3::Ones());
    const Status status =
        check_answers(index, mesh, topology, points, {.execution = {.progress = &progress}});
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::cancelled);
}

} // namespace
} // namespace proxima
