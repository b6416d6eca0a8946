// Every kind of damage to an index's rows and blocks is found and named.
#include "index/damaged_index.h"

namespace proxima::check_structure_test {
namespace {

using testing::EditableIndex;
using CheckStructure = testing::DamagedIndex;

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

IndexLeaf& first_leaf_by_rows(EditableIndex& e)
{
    std::uint32_t at = e.root;
    while ((at & index_leaf_bit) == 0) {
        const IndexNode& node = e.blocks[at].node;
        at = node.children[node.order & 15U];
    }
    return e.blocks[at & ~index_leaf_bit].leaf;
}

IndexLeaf& last_leaf_of(EditableIndex& e)
{
    std::uint32_t at = e.root;
    while ((at & index_leaf_bit) == 0) {
        const IndexNode& node = e.blocks[at].node;
        for (std::uint32_t shift = 0; shift < 32; shift += 4) {
            const std::uint32_t slot = node.order >> shift & 15U;
            if (slot != IndexNode::no_child) at = node.children[slot];
        }
    }
    return e.blocks[at & ~index_leaf_bit].leaf;
}

/// How many blocks the longest way down from a block to a leaf has, both included.
std::uint32_t levels_of(const EditableIndex& e, std::uint32_t reference)
{
    if ((reference & index_leaf_bit) != 0) return 1;
    std::uint32_t below = 0;
    for (const std::uint32_t child : e.blocks[reference].node.children)
        if (child != index_leaf_bit) below = std::max(below, levels_of(e, child));
    return below + 1;
}

/// Puts a node with the root as its only child in its place.
void put_on_top(EditableIndex& e)
{
    IndexBlock top = e.blocks[e.root];
    IndexNode& node = top.node;
    node.children.fill(index_leaf_bit);
    node.children[0] = e.root;
    node.order = 0xFFFFFFF0;
    node.starts.fill(0);
    for (auto& planes : node.planes) {
        for (std::size_t slot = 0; slot < 8; ++slot) {
            planes[slot] = slot == 0 ? 0 : 255;
            planes[8 + slot] = slot == 0 ? 255 : 0;
        }
    }
    const BlockSlab slab = e.slabs[e.root];
    e.root = static_cast<std::uint32_t>(e.blocks.size());
    e.blocks.push_back(top);
    e.slabs.push_back(slab);
}

TEST_F(CheckStructure, AcceptsASoundIndex)
{
    EXPECT_EQ(EditableIndex(sound_index).fault(), "");
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
         {"it is not empty", [](EditableIndex& e) { e.blocks[0].leaf.count = 1; }},
         {"rows of no leaf", [](EditableIndex& e) { --last_leaf_of(e).count; }},
         {"rows that are not one run", [](EditableIndex& e) { --first_leaf_by_rows(e).count; }},
         {"too many levels", [](EditableIndex& e) {
              for (std::uint32_t level = 0; level <= IndexParts::max_levels; ++level) put_on_top(e);
          }}});
}

TEST_F(CheckStructure, NamesALeafOfMoreTrianglesThanThereAre)
{
    const TriangleMesh mesh = make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                 {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
                                  .value();
    const MeshIndex small =
        with_signs(with_slabs(testing::listed_index(mesh).value()).value()).value();
    EXPECT_EQ(EditableIndex(small).fault(), "");
    for (const std::uint32_t first : {0U, 1U, 0xFFFFFFFBU, 0xFFFFFFFFU}) {
        for (const std::uint16_t count : {std::uint16_t{4}, std::uint16_t{5}, std::uint16_t{8}}) {
            if (first == 0 && count == 4) continue; // as it is
            EditableIndex edited(small);
            first_leaf_of(edited).first_row = first;
            first_leaf_of(edited).count = count;
            EXPECT_NE(edited.fault().find("no such rows"), std::string::npos)
                << first << ", " << count << ": " << edited.fault();
        }
    }
}

/// A chain of nodes with one child each is a tree as long as walks have room for its levels.
TEST_F(CheckStructure, AcceptsAsManyLevelsAsWalksHaveRoomFor)
{
    EditableIndex deep(sound_index);
    const std::uint32_t below = levels_of(deep, deep.root);
    for (std::uint32_t level = below; level < IndexParts::max_levels; ++level) put_on_top(deep);
    EXPECT_EQ(deep.fault(), "");
    put_on_top(deep);
    EXPECT_NE(deep.fault().find("too many levels"), std::string::npos) << deep.fault();
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

TEST_F(CheckStructure, NamesLeavesThatAreNotAsExactAsSaid)
{
    EXPECT_TRUE(sound_index.parts().has_exact_leaves());
    // Of coordinates that no float holds.
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    EditableIndex rounded(
        with_signs(with_slabs(testing::listed_index(mesh).value()).value()).value());
    EXPECT_FALSE(rounded.has_exact_leaves);
    EXPECT_EQ(rounded.fault(), "");
    rounded.has_exact_leaves = true;
    EXPECT_NE(rounded.fault().find("not its row"), std::string::npos) << rounded.fault();
}

} // namespace
} // namespace proxima::check_structure_test
