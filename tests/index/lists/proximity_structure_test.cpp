// Every kind of damage to an octree's arrays is found and named.
#include "index/lists/check_proximity_structure.h"

#include "index/lists/block.h"
#include "index/lists/build_proximity_octree.h"
#include "index/test_meshes.h"
#include "lab/query_sets.h"
#include "proxima/sample_meshes.h"
#include "query/closest/check_answers.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>

namespace proxima {
namespace {

/// The octree with its arrays copied, for tests that break them.
struct EditableOctree {
    ProximityOctree octree;
    std::vector<std::uint64_t> table{octree.arrays().table.begin(), octree.arrays().table.end()};
    std::vector<std::uint64_t> nodes{octree.arrays().nodes.begin(), octree.arrays().nodes.end()};
    std::vector<RunEntry> runs{octree.arrays().runs.begin(), octree.arrays().runs.end()};
    std::vector<std::byte> arena{octree.arrays().arena.begin(), octree.arrays().arena.end()};
    std::vector<TriangleRow<float>> rows{octree.arrays().float_rows.begin(),
                                         octree.arrays().float_rows.end()};
    std::vector<std::uint32_t> vertex_places{octree.arrays().vertex_places.begin(),
                                             octree.arrays().vertex_places.end()};
    std::vector<std::uint32_t> edge_places{octree.arrays().edge_places.begin(),
                                           octree.arrays().edge_places.end()};
    RootFrame frame = octree.frame();
    ProximityStatistics statistics = octree.statistics();
    int table_depth = octree.table_depth();

    /// The octree of the edited arrays. \pre this outlives it
    [[nodiscard]] ProximityOctree adopted() const
    {
        ProximityArrays arrays{table, nodes, runs, arena, rows, {}, vertex_places, edge_places};
        arrays.double_rows = octree.arrays().double_rows;
        return ProximityOctree::adopt(frame, table_depth, arrays, &octree.tree(), statistics,
                                      octree.mesh_fingerprint(), nullptr);
    }

    /// The message of the check, "" where it finds nothing: the same for any number of threads.
    [[nodiscard]] std::string fault() const
    {
        const ProximityOctree edited = adopted();
        const auto message = [&](int threads) {
            const Status status = check_structure(edited, {.execution = {.threads = {threads}}});
            return status ? std::string() : describe(status.error());
        };
        std::string found = message(1);
        EXPECT_EQ(message(3), found);
        return found;
    }
};

TEST(ProximityStructure, NamesWhatIsBroken)
{
    // Coordinates that floats hold.
    const TriangleMesh mesh = testing::moved(sample_mesh("torus:24x36").value(), [](const Vec3& p) {
        return Vec3((p * 0x1p20).array().round().matrix() * 0x1p-20);
    });
    const ProximityOctree octree =
        build_proximity_octree(mesh, {.budget_bytes = 300 * mesh.triangle_count() + 4096}).value();
    ASSERT_FALSE(octree.arrays().float_rows.empty());
    ASSERT_FALSE(octree.arrays().runs.empty());
    ASSERT_GT(octree.table_depth(), 0);
    const auto first_leaf =
        static_cast<std::size_t>(std::ranges::find_if(octree.arrays().nodes,
                                                      [](std::uint64_t word) {
                                                          return proximity_word::is_leaf(word) &&
                                                                 !proximity_word::is_run(word);
                                                      }) -
                                 octree.arrays().nodes.begin());
    const auto last_split = [](const EditableOctree& e) {
        std::size_t i = e.nodes.size();
        while (proximity_word::is_leaf(e.nodes[--i])) {
        }
        return i;
    };
    struct Case {
        const char* fault;
        std::function<void(EditableOctree&)> damage;
    };
    const auto header_byte = [](std::size_t at, int value) {
        return [=](EditableOctree& e) { e.arena[at] = static_cast<std::byte>(value); };
    };
    const auto origin = [](float value) {
        return [=](EditableOctree& e) { std::memcpy(e.arena.data(), &value, 4); };
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr float float_nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<Case> cases = {
        {"", [](EditableOctree&) {}},
        {"frame", [](EditableOctree& e) { e.frame.center[1] = nan; }},
        {"frame", [](EditableOctree& e) { e.frame.scale *= 1.5; }},
        {"frame", [](EditableOctree& e) { e.frame.scale *= 4; }},
        {"table", [](EditableOctree& e) { e.table.pop_back(); }},
        {"table", [](EditableOctree& e) { e.table_depth += 1; }},
        {"table", [](EditableOctree& e) { e.table.back() ^= 1; }},
        {"table", [](EditableOctree& e) { e.table[0] = e.table.back(); }},
        {"nodes come by eight", [](EditableOctree& e) { e.nodes.pop_back(); }},
        {"beyond the nodes", [&](EditableOctree& e) { e.nodes[last_split(e)] = e.nodes.size(); }},
        {"beyond the nodes",
         [&](EditableOctree& e) { e.nodes[last_split(e)] = (std::uint64_t{1} << 63U) - 8; }},
        {"beyond the nodes", [&](EditableOctree& e) { e.nodes[last_split(e)] += 1; }},
        {"children of two cells",
         [&](EditableOctree& e) { e.nodes[first_leaf] = e.nodes[last_split(e)]; }},
        {"without a parent",
         [&](EditableOctree& e) { e.nodes[last_split(e)] = e.nodes[first_leaf]; }},
        {"out of reach",
         [](EditableOctree& e) {
             // Eight more nodes, one of which has them as its children.
             const std::uint64_t base = e.nodes.size();
             e.nodes.insert(e.nodes.end(), 8, proximity_word::leaf(0, 1));
             e.nodes[base] = base;
         }},
        {"split at the deepest level",
         [&](EditableOctree& e) {
             // A chain of splits below a leaf, in front of the root's last child.
             const std::uint64_t leaf = e.nodes[first_leaf];
             std::size_t at = first_leaf;
             for (int level = 0; level < 15; ++level) {
                 const std::uint64_t base = e.nodes.size();
                 e.nodes[at] = base;
                 e.nodes.insert(e.nodes.end(), 8, leaf);
                 at = base;
             }
             // Their cells are those of the table as well.
             for (std::uint64_t& word : e.table)
                 if (word == leaf) word = e.nodes[first_leaf];
         }},
        {"no such triangles",
         [&](EditableOctree& e) { e.nodes[first_leaf] &= ~std::uint64_t{0xFFFFFFFF}; }},
        {"no such triangles",
         [&](EditableOctree& e) { e.nodes[first_leaf] |= std::uint64_t{0xFFFFFFFF}; }},
        {"no such triangles",
         [&](EditableOctree& e) { e.nodes[first_leaf] ^= std::uint64_t{1} << 32U; }},
        {"no such triangles",
         [&](EditableOctree& e) {
             e.nodes[first_leaf] |= std::uint64_t{proximity_word::max_place} << 32U;
         }},
        {"no such run",
         [&](EditableOctree& e) {
             e.nodes[first_leaf] = proximity_word::run(static_cast<std::uint32_t>(e.runs.size()));
         }},
        {"its run is damaged",
         [&](EditableOctree& e) { e.nodes[first_leaf] = proximity_word::run(0); }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[0].place = 0; }},
        {"its run is damaged",
         [](EditableOctree& e) { e.runs[0].place = static_cast<std::uint32_t>(e.runs.size()); }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[0].place = 0xFFFFFFFF; }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[0].direction[1] += 0.5F; }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[1].mask = 0; }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[1].least = float_nan; }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[1].least = 3; }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[1].direction[2] = float_nan; }},
        {"its run is damaged", [](EditableOctree& e) { e.runs[1].place += 1; }},
        {"runs of no leaf", [](EditableOctree& e) { e.runs.emplace_back(); }},
        {"a block is damaged", origin(float_nan)},
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
        {"a block is damaged", header_byte(27, 1)},
        {"a block is damaged", [](EditableOctree& e) { e.arena.resize(block_padding + 20); }},
        {"blocks of no leaf",
         [](EditableOctree& e) {
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
        {"no padding", [](EditableOctree& e) { e.arena.clear(); }},
        {"padding", [](EditableOctree& e) { e.arena.back() = std::byte{1}; }},
        {"block is damaged", [](EditableOctree& e) { e.arena.resize(e.arena.size() + 1); }},
        {"outside of the root", [](EditableOctree& e) { e.rows[7].coordinates[1][2] = 1e9F; }},
        {"outside of the root", [](EditableOctree& e) { e.rows[7].coordinates[1][2] = float_nan; }},
        {"no such vertex",
         [](EditableOctree& e) { e.rows[7].vertices[1] = static_cast<std::uint32_t>(~0U); }},
        {"direction", [](EditableOctree& e) { e.rows[7].triangle ^= e.rows[7].side_bit; }},
        {"no such edge",
         [](EditableOctree& e) {
             e.rows[7].edges[2] = static_cast<std::uint32_t>(e.edge_places.size());
         }},
        {"an edge of one vertex", [](EditableOctree& e) { e.rows[7].edges[2] = index(no_edge); }},
        {"a triangle twice", // the last one: all its vertices and edges have lower triangles
         [](EditableOctree& e) {
             const auto last = static_cast<std::uint32_t>(e.rows.size()) - 1;
             for (TriangleRow<float>& row : e.rows)
                 if (row.triangle_id() == last) --row.triangle;
         }},
        {"no such triangle",
         [](EditableOctree& e) { e.rows[7].triangle |= TriangleRow<float>::side_bit - 1; }},
        {"impossible number of triangles", [](EditableOctree& e) { e.rows.clear(); }},
        {"triangle tree", [](EditableOctree& e) { e.rows.pop_back(); }},
        {"a vertex's place is wrong",
         [](EditableOctree& e) { e.vertex_places[3] = static_cast<std::uint32_t>(e.rows.size()); }},
        {"an edge's place is wrong",
         [](EditableOctree& e) { e.edge_places[3] = static_cast<std::uint32_t>(e.rows.size()); }},
        {"a vertex's place is wrong",
         [](EditableOctree& e) { e.vertex_places[3] = place_word::none; }},
        {"places of no row", [](EditableOctree& e) { e.vertex_places[3] ^= 3U << 28U; }},
        {"places of no row", [](EditableOctree& e) { e.edge_places[3] ^= 3U << 28U; }},
        {"places of no row", [](EditableOctree& e) { e.edge_places[3] ^= 1U << 30U; }},
        {"places of no row", [](EditableOctree& e) { e.edge_places[3] = 0; }},
        {"statistics", [&](EditableOctree& e) { e.nodes[first_leaf] = proximity_word::search; }},
        {"no such run",
         [&](EditableOctree& e) { e.nodes[first_leaf] = proximity_word::run(0) | 1 << 1; }},
        {"statistics", [](EditableOctree& e) { e.statistics.searched_leaves += 1; }},
        {"statistics", [](EditableOctree& e) { e.statistics.worst_case_steps -= 1; }},
        {"statistics", [](EditableOctree& e) { e.statistics.worst_case_blocks -= 1; }},
        {"statistics", [](EditableOctree& e) { e.statistics.references += 1; }},
        {"statistics", [](EditableOctree& e) { e.statistics.expected_list = nan; }}};
    for (std::size_t i = 0; i < cases.size(); ++i) {
        EditableOctree edited{octree};
        cases[i].damage(edited);
        const std::string found = edited.fault();
        if (*cases[i].fault == '\0') {
            EXPECT_EQ(found, "") << "case " << i;
        } else {
            EXPECT_NE(found.find(cases[i].fault), std::string::npos)
                << "case " << i << ": expected \"" << cases[i].fault << "\", found " << found;
        }
    }
}

TEST(ProximityAnswers, AreThoseOfAllTrianglesUntilOneIsLeftOut)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    const Topology topology = build_topology(mesh).value();
    const ProximityOctree octree = build_proximity_octree(mesh, topology).value();
    std::vector<Vec3> points;
    for (const QuerySet& set : query_sets(mesh, 500, 3))
        points.insert(points.end(), set.points.begin(), set.points.end());
    const auto message = [&](const ProximityOctree& of, int threads) {
        const Status status =
            check_answers(of, mesh, topology, points, {.execution = {.threads = {threads}}});
        return status ? std::string() : describe(status.error());
    };
    EXPECT_EQ(message(octree, 1), "");
    // In every leaf of one block the last of its triangles is forgotten: the structure is sound.
    EditableOctree edited{octree};
    for (std::vector<std::uint64_t>* const words : {&edited.table, &edited.nodes}) {
        for (std::uint64_t& word : *words) {
            const std::uint32_t mask = proximity_word::mask(word);
            if (proximity_word::is_leaf(word) && proximity_word::is_block(word) &&
                std::popcount(mask) > 1)
                word = proximity_word::leaf(proximity_word::place(word), mask & (mask - 1));
        }
    }
    const ProximityOctree broken = edited.adopted();
    const std::string found = message(broken, 1);
    EXPECT_NE(found.find("the octree answers"), std::string::npos) << found;
    EXPECT_NE(found.find("the closest is"), std::string::npos) << found;
    EXPECT_EQ(message(broken, 3), found);
}

TEST(ProximityAnswers, CanBeCancelled)
{
    const TriangleMesh mesh = sample_mesh("cube").value();
    const Topology topology = build_topology(mesh).value();
    const ProximityOctree octree = build_proximity_octree(mesh, topology).value();
    Progress progress;
    progress.cancel();
    const std::vector<Vec3> points(10, Vec3::Ones());
    const Status status =
        check_answers(octree, mesh, topology, points, {.execution = {.progress = &progress}});
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::cancelled);
}

} // namespace
} // namespace proxima
