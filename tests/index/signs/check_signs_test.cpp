// Every kind of damage to an index's signs is found and named.
#include "index/damaged_index.h"

namespace proxima::check_signs_test {
namespace {

using testing::EditableIndex;
using CheckSigns = testing::DamagedIndex;

TEST_F(CheckSigns, NamesSignsOfOtherNumbers)
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

TEST_F(CheckSigns, NamesWrongRowsAndSidesOfSigns)
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

TEST_F(CheckSigns, NamesWrongTrianglesOfEdges)
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

TEST_F(CheckSigns, AcceptsAListOfAnEdge)
{
    EditableIndex edited(sound_index);
    edited.edge_lists = {1, edited.edges[3]};
    edited.edges[3] = edge_list_bit;
    EXPECT_EQ(edited.fault(), "");
}

TEST_F(CheckSigns, NamesClustersThatFormNoTree)
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

} // namespace
} // namespace proxima::check_signs_test
