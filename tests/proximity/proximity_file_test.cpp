// Proximity octrees come back from files as they were; damaged files are refused or harmless.
#include "proxima/proximity/proximity_file.h"

#include "cancellation.h"
#include "damaged_files.h"
#include "exact_copy.h"
#include "folder_test.h"
#include "proxima/base/text.h"
#include "proxima/mesh/sample_meshes.h"
#include "proxima/proximity/block.h"
#include "proxima/proximity/build_proximity_octree.h"
#include "proxima/proximity/check_proximity_structure.h"
#include "proxima/proximity/closest_feature.h"
#include "proximity/test_meshes.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <new>
#include <random>

namespace proxima {
namespace {

using testing::NamedMesh;
using testing::proximity_meshes;
using testing::proximity_points;

std::string slurp(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Loads from an exact copy of the bytes, so that a sanitizer sees the first one out of bounds.
Result<ProximityOctree> load_bytes(const std::string& bytes,
                                   Verification verify = Verification::full)
{
    const auto copy = testing::exact_copy(bytes.data(), bytes.size());
    return load_proximity_octree(std::span(copy.get(), bytes.size()), copy, "memory",
                                 {.verify = verify});
}

ProximityOctree built(const TriangleMesh& mesh, std::uint64_t bytes_per_triangle = 600)
{
    auto octree = build_proximity_octree(
        mesh, {.budget_bytes = bytes_per_triangle * mesh.triangle_count() + 4096});
    EXPECT_TRUE(octree) << describe(octree.error());
    return std::move(*octree);
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b)
{
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

void expect_equal(const ProximityOctree& a, const ProximityOctree& b)
{
    EXPECT_EQ(a.frame().center, b.frame().center);
    EXPECT_EQ(a.frame().half, b.frame().half);
    EXPECT_EQ(a.frame().scale, b.frame().scale);
    EXPECT_EQ(a.table_depth(), b.table_depth());
    EXPECT_EQ(a.statistics(), b.statistics());
    EXPECT_EQ(a.mesh_fingerprint(), b.mesh_fingerprint());
    EXPECT_EQ(a.tree().origin(), b.tree().origin());
    EXPECT_EQ(a.tree().scale(), b.tree().scale());
    EXPECT_EQ(a.tree().reach(), b.tree().reach());
    EXPECT_TRUE(same_bytes(a.tree().blocks(), b.tree().blocks()));
    EXPECT_TRUE(same_bytes(a.arrays().table, b.arrays().table));
    EXPECT_TRUE(same_bytes(a.arrays().nodes, b.arrays().nodes));
    EXPECT_TRUE(same_bytes(a.arrays().runs, b.arrays().runs));
    EXPECT_TRUE(same_bytes(a.arrays().arena, b.arrays().arena));
    EXPECT_TRUE(same_bytes(a.arrays().float_rows, b.arrays().float_rows));
    EXPECT_TRUE(same_bytes(a.arrays().double_rows, b.arrays().double_rows));
    EXPECT_TRUE(same_bytes(a.arrays().vertex_places, b.arrays().vertex_places));
    EXPECT_TRUE(same_bytes(a.arrays().edge_places, b.arrays().edge_places));
}

/// Whether two octrees answer with the same bits.
void expect_same_answers(const ProximityOctree& a, const ProximityOctree& b,
                         std::span<const Vec3> points)
{
    for (const Vec3& p : points) {
        const ClosestFeature one = closest_feature(a, p);
        const ClosestFeature two = closest_feature(b, p);
        ASSERT_EQ(one.feature, two.feature) << p.transpose();
        ASSERT_EQ(one.triangle, two.triangle);
        ASSERT_EQ(one.point, two.point);
        ASSERT_EQ(one.barycentric, two.barycentric);
        ASSERT_EQ(one.squared_distance, two.squared_distance);
    }
}

/// Asks in and around the root; all that is named exists, and no query takes longer than promised.
void expect_harmless(const ProximityOctree& octree, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Vec3> points;
    for (int i = 0; i < 48; ++i) {
        const double reach = octree.frame().half * (i % 8 == 0 ? 10.0 : 1.0);
        points.emplace_back(octree.frame().center +
                            reach * Vec3(unit(random), unit(random), unit(random)));
    }
    const auto expect_exists = [&](const ClosestFeature& found) {
        const std::array<std::size_t, 3> counts = {octree.arrays().vertex_places.size(),
                                                   octree.arrays().edge_places.size(),
                                                   octree.triangle_count()};
        ASSERT_LT(found.feature.id, counts[static_cast<std::size_t>(found.feature.kind)]);
        ASSERT_LT(index(found.triangle), octree.triangle_count());
    };
    for (const Vec3& p : points) {
        QuerySteps steps;
        expect_exists(closest_feature(octree, p, steps));
        ASSERT_LE(steps.steps, octree.statistics().worst_case_steps);
        ASSERT_LE(steps.blocks, octree.statistics().worst_case_blocks);
    }
    std::vector<ClosestFeature> answers(points.size());
    ASSERT_TRUE(closest_features(octree, points, answers));
    for (const ClosestFeature& found : answers) expect_exists(found);
}

class ProximityFile : public FolderTest {
protected:
    std::string saved(const ProximityOctree& octree)
    {
        const Status status = save_proximity_octree(octree, path("octree.pxp"));
        EXPECT_TRUE(status) << describe(status.error());
        return slurp(path("octree.pxp"));
    }
};

TEST_F(ProximityFile, ComesBackAsItWas)
{
    bool has_floats = false;
    bool has_doubles = false;
    bool has_runs = false;
    bool has_table = false;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        for (const std::uint64_t bytes_per_triangle : {200ULL, 2000ULL}) {
            const ProximityOctree octree = built(named.mesh, bytes_per_triangle);
            has_floats = has_floats || !octree.arrays().float_rows.empty();
            has_doubles = has_doubles || !octree.arrays().double_rows.empty();
            has_runs = has_runs || !octree.arrays().runs.empty();
            has_table = has_table || octree.table_depth() > 1;
            const Status sound = check_structure(octree);
            ASSERT_TRUE(sound) << describe(sound.error());
            const std::string bytes = saved(octree);
            for (const Verification verify : {Verification::full, Verification::structure}) {
                const auto loaded = load_proximity_octree(path("octree.pxp"), {.verify = verify});
                ASSERT_TRUE(loaded) << describe(loaded.error());
                expect_equal(octree, *loaded);
                expect_same_answers(octree, *loaded, proximity_points(named.mesh, 100, 1));
                ASSERT_TRUE(check_same_mesh(*loaded, named.mesh));
                // Same octree, same bytes: also written over the file that it is mapped from.
                EXPECT_EQ(saved(*loaded), bytes);
                expect_equal(octree, *loaded);
            }
        }
    }
    EXPECT_TRUE(has_floats && has_doubles && has_runs && has_table);
}

TEST_F(ProximityFile, SameMeshSameBytes)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    // Doubles that no floats hold: their rows have bytes to fill up.
    const TriangleMesh thirds = testing::moved(mesh, [](const Vec3& p) { return Vec3(p / 3); });
    for (const TriangleMesh* one : {&mesh, &thirds}) {
        const std::string bytes = saved(build_proximity_octree(*one, {.threads = {1}}).value());
        EXPECT_EQ(saved(build_proximity_octree(*one, {.threads = {3}}).value()), bytes);
    }
}

TEST_F(ProximityFile, OutlivesItsFile)
{
    const TriangleMesh mesh = sample_mesh("sphere:12x12").value();
    const ProximityOctree octree = built(mesh);
    (void)saved(octree);
    auto loaded = load_proximity_octree(path("octree.pxp"));
    ASSERT_TRUE(loaded);
    const ProximityOctree copy = *loaded;
    loaded = tl::unexpected(Error{});
    std::filesystem::remove(path("octree.pxp"));
    expect_same_answers(octree, copy, proximity_points(mesh, 100, 2));
}

TEST_F(ProximityFile, RefusesEveryTruncationAndExtension)
{
    testing::refuses_every_truncation_and_extension(saved(built(sample_mesh("cube").value())),
                                                    load_bytes);
}

TEST_F(ProximityFile, RefusesEveryFlippedBit)
{
    testing::refuses_every_flipped_bit(saved(built(sample_mesh("cube").value())), load_bytes);
}

TEST_F(ProximityFile, DamageWithRightChecksumsIsHarmless)
{
    // A crafted file has right checksums, so what is accepted must be safe to query.
    constexpr unsigned seed = 5;
    std::mt19937 random(seed);
    const TriangleMesh torus = testing::torus_mesh(1.0, 0.3, 12, 8);
    const std::vector<std::string> files = {
        saved(built(torus, 200)), saved(built(torus, 4000)),
        saved(built(testing::moved(torus, [](const Vec3& p) { return Vec3(p / 3); }), 600)),
        saved(built(testing::grid_mesh(3)))};
    int accepted = 0;
    int refused = 0;
    for (int round = 0; round < 8000; ++round) {
        std::string damaged = files[static_cast<std::size_t>(round) % files.size()];
        for (int change = 0; change < 1 + round % 3; ++change) {
            damaged[random() % damaged.size()] = static_cast<char>(random());
        }
        reseal_binary_file(std::as_writable_bytes(std::span(damaged)));
        const auto loaded = load_bytes(damaged);
        ++(loaded ? accepted : refused);
        if (!loaded) continue;
        SCOPED_TRACE(round);
        expect_harmless(*loaded, static_cast<unsigned>(round));
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(accepted, 100) << "seed " << seed;
    EXPECT_GT(refused, 100) << "seed " << seed;
}

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

    /// The message of the check, "" where it finds nothing: the same for any number of threads.
    [[nodiscard]] std::string fault() const
    {
        const ProximityArrays arrays{table, nodes, runs,          arena,
                                     rows,  {},    vertex_places, edge_places};
        const ProximityOctree edited =
            ProximityOctree::adopt(frame, table_depth, arrays, &octree.tree(), statistics,
                                   octree.mesh_fingerprint(), nullptr);
        const auto message = [&](int threads) {
            const Status status = check_structure(edited, {.threads = {threads}});
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
    const ProximityOctree octree = built(mesh, 300);
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

TEST_F(ProximityFile, NamesTheReason)
{
    const ProximityOctree octree = built(sample_mesh("cube").value());
    const std::string bytes = saved(octree);
    const auto expect_refused = [](const std::string& file, ErrorCode code, const char* why) {
        const auto loaded = load_bytes(file);
        ASSERT_FALSE(loaded);
        EXPECT_EQ(loaded.error().code, code);
        EXPECT_NE(loaded.error().message.find(why), std::string::npos) << loaded.error().message;
    };
    expect_refused("ply\nformat ascii 1.0\n", ErrorCode::unsupported_format,
                   "no proximity octree file");
    expect_refused("", ErrorCode::unsupported_format, "no proximity octree file");
    std::string other = bytes;
    other[7] = 'O'; // a surface octree
    expect_refused(other, ErrorCode::unsupported_format, "no proximity octree file");
    other = bytes;
    std::swap(other[8], other[11]);
    std::swap(other[9], other[10]);
    expect_refused(other, ErrorCode::unsupported_format, "other byte order");
    other = bytes;
    other[12] = 2;
    expect_refused(other, ErrorCode::unsupported_format, "version 2");
    expect_refused(bytes.substr(0, 1000), ErrorCode::malformed_file, "cut off");
    other = bytes;
    other.back() = static_cast<char>(other.back() ^ 1);
    expect_refused(other, ErrorCode::malformed_file, "section 10 is wrong");

    EXPECT_EQ(load_proximity_octree(path("missing.pxp")).error().code, ErrorCode::file_not_found);
    EXPECT_EQ(load_proximity_octree(folder()).error().code, ErrorCode::file_not_found);
    EXPECT_EQ(save_proximity_octree(octree, path("missing") / "x.pxp").error().code,
              ErrorCode::file_not_writable);
    EXPECT_EQ(save_proximity_octree(octree, "/dev/full").error().code,
              ErrorCode::file_not_writable);
}

TEST_F(ProximityFile, TellsAnotherMesh)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const ProximityOctree octree = built(cube);
    ASSERT_TRUE(check_same_mesh(octree, cube));
    const TriangleMesh larger =
        testing::moved(cube, [](const Vec3& p) { return Vec3(p * (1 + 0x1p-50)); });
    const TriangleMesh sphere = sample_mesh("sphere:8x8").value();
    for (const TriangleMesh* other : {&larger, &sphere}) {
        const Status status = check_same_mesh(octree, *other);
        ASSERT_FALSE(status);
        EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
        EXPECT_NE(status.error().message.find(" 12 triangles"), std::string::npos)
            << status.error().message;
        EXPECT_NE(status.error().message.find(
                      concat(other->triangle_count(), " triangles, ", other->vertex_count())),
                  std::string::npos)
            << status.error().message;
    }
}

TEST_F(ProximityFile, StopsWhenAskedTo)
{
    const ProximityOctree octree = built(sample_mesh("torus:30x40").value());
    (void)saved(octree);
    const auto nothing_kept = [&] { return entries() == 1; };
    ASSERT_TRUE(load_proximity_octree(path("octree.pxp")));
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return load_proximity_octree(path("octree.pxp"), {.progress = &progress});
        },
        nothing_kept);
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return save_proximity_octree(octree, path("other.pxp"), {.progress = &progress});
        },
        nothing_kept);
}

} // namespace
} // namespace proxima
