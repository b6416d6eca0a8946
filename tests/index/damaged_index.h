// An index with all its parts, whose arrays tests damage: the check is to name the damage.
#pragma once

#include "index/check_structure.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/block.h"
#include "index/lists/proximity_lists.h"
#include "index/signs/sign_parts.h"
#include "index/slabs/block_slab.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace proxima::testing {

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
    bool has_exact_leaves = index.parts().has_exact_leaves();

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
        arrays.has_exact_leaves = has_exact_leaves;
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

/// Gives the ranks of all blocks of the lists 4 bytes each, as those that are far apart have.
inline void widen_blocks(EditableIndex& edited)
{
    std::vector<std::byte> arena;
    std::map<std::uint32_t, std::uint32_t> new_position;
    const auto append = [&](std::size_t begin, std::size_t bytes) {
        const auto from = edited.arena.begin() + static_cast<std::ptrdiff_t>(begin);
        arena.insert(arena.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
    };
    const auto aligned = [](std::size_t at) {
        return (at + block_alignment - 1) / block_alignment * block_alignment;
    };
    for (std::size_t at = 0; at + block_padding < edited.arena.size();) {
        BlockHeader header;
        std::memcpy(&header, edited.arena.data() + at, sizeof header);
        const BlockLayout narrow = block_layout(header.vertices, header.triangles, false);
        arena.resize(aligned(arena.size()));
        new_position[static_cast<std::uint32_t>(at / block_alignment)] =
            static_cast<std::uint32_t>(arena.size() / block_alignment);
        header.wide = 1;
        const auto* const bytes = reinterpret_cast<const std::byte*>(&header);
        arena.insert(arena.end(), bytes, bytes + sizeof header);
        append(at + sizeof header, narrow.ranks - sizeof header);
        for (std::size_t i = 0; i < header.triangles; ++i) {
            append(at + narrow.ranks + 2 * i, 2);
            arena.insert(arena.end(), 2, std::byte{0}); // numbers begin with their lowest byte
        }
        at = aligned(at + narrow.end);
    }
    arena.resize(arena.size() + block_padding);
    edited.arena = std::move(arena);
    for (std::vector<std::uint64_t>* const words : {&edited.nodes, &edited.table}) {
        for (std::uint64_t& word : *words) {
            if (!proximity_word::is_leaf(word) || !proximity_word::is_block(word)) continue;
            word = proximity_word::leaf(new_position.at(proximity_word::position(word)),
                                        proximity_word::mask(word));
        }
    }
    for (RunEntry& entry : edited.runs)
        if (entry.mask != 0) entry.position = new_position.at(entry.position);
}

/// A change that damages a sound index, and the fault that the check must report.
struct Damage {
    const char* fault;
    std::function<void(EditableIndex&)> damage;
};

/// An index with lists, runs, a table, slabs and signs of a torus, whose parts the tests break.
class DamagedIndex : public ::testing::Test {
protected:
    void SetUp() override
    {
        // Coordinates that floats hold.
        const TriangleMesh mesh = moved(sample_mesh("torus:24x36").value(), [](const Vec3& p) {
            return Vec3((p * 0x1p20).array().round().matrix() * 0x1p-20);
        });
        const MeshIndex listed =
            listed_index(mesh, {.list_bytes = 225 * mesh.triangle_count() + 4096}).value();
        sound_index = with_signs(with_slabs(listed).value()).value();
        ASSERT_TRUE(sound_index.parts().signs()->is_local());
        const ProximityLists* lists = sound_index.parts().lists();
        ASSERT_FALSE(sound_index.parts().float_rows().empty());
        ASSERT_FALSE(lists->arrays().runs.empty());
        ASSERT_GT(lists->table_depth(), 0);
        const auto& nodes = lists->arrays().nodes;
        first_leaf_node = static_cast<std::size_t>(
            std::ranges::find_if(nodes,
                                 [](std::uint64_t word) {
                                     return proximity_word::is_leaf(word) &&
                                            !proximity_word::is_run(word);
                                 }) -
            nodes.begin());
        ASSERT_LT(first_leaf_node, nodes.size());
    }

    /// Breaks a fresh copy of the index in each of these ways, and expects the fault to be named.
    void expect_named(const std::vector<Damage>& damages) const
    {
        for (std::size_t i = 0; i < damages.size(); ++i) {
            EditableIndex edited(sound_index);
            damages[i].damage(edited);
            const std::string found = edited.fault();
            EXPECT_NE(found.find(damages[i].fault), std::string::npos)
                << "damage " << i << ": expected \"" << damages[i].fault << "\", found " << found;
        }
    }

    /// The word of the first node that is a leaf with a block of its own.
    [[nodiscard]] std::uint64_t& first_leaf(EditableIndex& e) const
    {
        return e.nodes[first_leaf_node];
    }

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
    MeshIndex sound_index;
    std::size_t first_leaf_node = 0;
};

} // namespace proxima::testing
