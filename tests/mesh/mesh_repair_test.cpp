#include "cancellation.h"
#include "mesh/mesh_drafts.h"
#include "mesh/random_soups.h"
#include "proxima/mesh_repair.h"
#include "proxima/topology.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

namespace proxima::mesh_repair_test {
namespace {

using Kind = RepairStepKind;

constexpr std::uint32_t no_truth = ~0U;

MeshRepair repaired(const TriangleMesh& mesh, const MeshRepairOptions& options = {})
{
    auto repair = repair_mesh(mesh, options);
    EXPECT_TRUE(repair) << describe(repair.error());
    return std::move(*repair);
}

std::uint64_t count(const MeshRepair& repair, Kind kind)
{
    return repair.step(kind).count;
}

/// Bit by bit, NaN too.
bool same_mesh(const TriangleMesh& a, const TriangleMesh& b)
{
    const auto same_bits = [](const Vec3& p, const Vec3& q) {
        return std::ranges::equal(p, q, {}, std::bit_cast<std::uint64_t, double>,
                                  std::bit_cast<std::uint64_t, double>);
    };
    return std::ranges::equal(a.positions(), b.positions(), same_bits) &&
           std::ranges::equal(a.triangles(), b.triangles());
}

bool same_repair(const MeshRepair& a, const MeshRepair& b)
{
    const auto counts_of = [](const MeshRepair& repair) {
        std::vector<std::uint64_t> counts = {repair.pieces, repair.closed_pieces, repair.cavities,
                                             repair.unorientable_pieces, repair.unorientable_edges};
        for (const RepairStep& step : repair.steps) counts.push_back(step.count);
        return counts;
    };
    return same_mesh(a.mesh, b.mesh) && a.original_triangles == b.original_triangles &&
           a.original_vertices == b.original_vertices && a.turned == b.turned &&
           counts_of(a) == counts_of(b);
}

/// Repairing the result with the same options does nothing.
void expect_idempotent(const MeshRepair& repair, const MeshRepairOptions& options)
{
    const MeshRepair again = repaired(repair.mesh, options);
    EXPECT_TRUE(same_mesh(again.mesh, repair.mesh));
    for (const RepairStep& step : again.steps) EXPECT_EQ(step.count, 0U) << name_of(step.kind);
    EXPECT_EQ(again.cavities, repair.cavities);
    EXPECT_EQ(again.unorientable_edges, repair.unorientable_edges);
}

/// What the maps say of every triangle and vertex of the result.
void expect_maps_right(const TriangleMesh& mesh, const MeshRepair& repair)
{
    ASSERT_EQ(repair.original_triangles.size(), repair.mesh.triangle_count());
    ASSERT_EQ(repair.turned.size(), repair.mesh.triangle_count());
    ASSERT_EQ(repair.original_vertices.size(), repair.mesh.vertex_count());
    EXPECT_TRUE(std::ranges::is_sorted(repair.original_triangles));
    EXPECT_EQ(std::ranges::adjacent_find(repair.original_triangles),
              repair.original_triangles.end());
    EXPECT_TRUE(std::ranges::is_sorted(repair.original_vertices));
    for (std::size_t i = 0; i < repair.mesh.vertex_count(); ++i) {
        const Vec3 before = mesh.position(repair.original_vertices[i]);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(std::bit_cast<std::uint64_t>(repair.mesh.positions()[i][axis]),
                      std::bit_cast<std::uint64_t>(before[axis]));
        }
    }
}

TriangleMesh inside_out(const TriangleMesh& mesh)
{
    std::vector<TriangleCorners> triangles;
    for (const auto& [a, b, c] : mesh.triangles()) triangles.push_back({a, c, b});
    return *make_triangle_mesh({mesh.positions().begin(), mesh.positions().end()}, triangles);
}

/// Solids as they should be: a shell with a cavity, a torus in the cavity, a ball in none.
Draft nested_solids()
{
    Draft draft;
    draft.add(make_icosphere(3), Vec3::Zero(), 4.0);
    draft.add(inside_out(make_icosphere(2)), Vec3(0.1, 0.2, 0.3), 2.5);
    draft.add(make_torus(24, 12), Vec3(0.2, 0.1, 0.2), 0.5);
    draft.add(make_sphere(12, 16), Vec3(20, 1, 2));
    draft.add(make_octahedron(), Vec3(-30, 1, 2), 3.0);
    return draft;
}

/// A closed mesh after much was done to it, and what its parts were.
struct Damaged {
    TriangleMesh mesh;
    std::vector<std::uint32_t> triangle_truth; ///< the triangle that it was, no_truth for rubbish
    std::vector<std::uint32_t> vertex_truth;
    std::uint64_t non_finite = 0;
    std::uint64_t degenerate = 0;
    std::uint64_t duplicates = 0;
};

class Damager {
public:
    Damager(const TriangleMesh& mesh, std::uint32_t seed, double jitter)
        : mesh_(mesh), random_(seed), jitter_(jitter)
    {}

    Damaged damage()
    {
        struct Plan {
            std::uint32_t truth;
            enum { triangle, twice, nan } what;
        };
        std::vector<Plan> plans;
        const auto count = static_cast<std::uint32_t>(mesh_.triangle_count());
        for (std::uint32_t id = 0; id < count; ++id) plans.push_back({id, Plan::triangle});
        for (std::uint32_t i = 0; i < 1 + count / 20; ++i) {
            plans.push_back({below(random_, count), Plan::triangle});
            plans.push_back({below(random_, count), Plan::twice});
            plans.push_back({below(random_, count), Plan::nan});
            ++damaged_.duplicates;
            ++damaged_.degenerate;
            ++damaged_.non_finite;
        }
        std::ranges::shuffle(plans, random_);
        for (const Plan& plan : plans) {
            if (plan.what == Plan::triangle) add_triangle(plan.truth);
            if (plan.what == Plan::twice) add_degenerate(plan.truth);
            if (plan.what == Plan::nan) add_non_finite(plan.truth);
        }
        damaged_.mesh = *make_triangle_mesh(positions_, triangles_);
        return std::move(damaged_);
    }

private:
    double hair() { return jitter_ * (std::uniform_real_distribution<double>(-1, 1)(random_)); }

    /// A vertex at one of the mesh, one that is there already or a new one.
    std::uint32_t vertex(std::uint32_t truth)
    {
        auto& there = copies_[truth];
        if (!there.empty() && below(random_, 4) == 0)
            return there[below(random_, static_cast<std::uint32_t>(there.size()))];
        if (below(random_, 10) == 0) add_vertex(Vec3(hair(), 50, 50), no_truth); // unused
        const std::uint32_t id =
            add_vertex(mesh_.positions()[truth] + Vec3(hair(), hair(), hair()), truth);
        there.push_back(id);
        return id;
    }

    std::uint32_t add_vertex(const Vec3& position, std::uint32_t truth)
    {
        positions_.push_back(position);
        damaged_.vertex_truth.push_back(truth);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }

    void add(TriangleCorners corners, std::uint32_t truth)
    {
        std::rotate(corners.begin(), corners.begin() + below(random_, 3), corners.end());
        if (below(random_, 2) == 0) std::swap(corners[0], corners[1]);
        triangles_.push_back(corners);
        damaged_.triangle_truth.push_back(truth);
    }

    void add_triangle(std::uint32_t truth)
    {
        const auto [a, b, c] = mesh_.triangles()[truth];
        add({vertex(a), vertex(b), vertex(c)}, truth);
    }

    void add_degenerate(std::uint32_t like)
    {
        const auto [a, b, c] = mesh_.triangles()[like];
        const std::uint32_t first = vertex(a);
        add({first, below(random_, 2) == 0 ? first : vertex(a), vertex(b)}, no_truth);
    }

    void add_non_finite(std::uint32_t like)
    {
        Vec3 broken = mesh_.triangle(TriangleId{like})[0];
        broken[static_cast<int>(below(random_, 3))] =
            below(random_, 2) == 0 ? nan_value : -std::numeric_limits<double>::infinity();
        const auto [a, b, c] = mesh_.triangles()[like];
        add({add_vertex(broken, no_truth), vertex(b), vertex(c)}, no_truth);
    }

    const TriangleMesh& mesh_;
    std::mt19937 random_;
    double jitter_;
    std::vector<Vec3> positions_;
    std::vector<TriangleCorners> triangles_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> copies_;
    Damaged damaged_;
};

TriangleCorners lowest_first(TriangleCorners corners)
{
    std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
    return corners;
}

/// The repair has each triangle of the truth once, as it faced, from its lowest copy.
void expect_truth(const TriangleMesh& truth, const Damaged& damaged, const MeshRepair& repair)
{
    const auto truth_of = [&](TriangleCorners corners, std::span<const VertexId> original) {
        for (std::uint32_t& corner : corners)
            corner = damaged.vertex_truth[to_index(original[corner])];
        return corners;
    };
    ASSERT_EQ(repair.mesh.triangle_count(), truth.triangle_count());
    std::vector<bool> seen(truth.triangle_count(), false);
    for (std::size_t i = 0; i < repair.mesh.triangle_count(); ++i) {
        const std::uint32_t before = to_index(repair.original_triangles[i]);
        const std::uint32_t one = damaged.triangle_truth[before];
        ASSERT_NE(one, no_truth);
        EXPECT_FALSE(seen[one]);
        seen[one] = true;
        const auto first = std::ranges::find(damaged.triangle_truth, one);
        EXPECT_EQ(first - damaged.triangle_truth.begin(), before);
        const TriangleCorners now = truth_of(repair.mesh.triangles()[i], repair.original_vertices);
        EXPECT_EQ(lowest_first(now), lowest_first(truth.triangles()[one])) << "triangle " << before;
        TriangleCorners corners = damaged.mesh.triangles()[before];
        for (std::uint32_t& corner : corners) corner = damaged.vertex_truth[corner];
        if (repair.turned[i] != 0) std::swap(corners[1], corners[2]);
        EXPECT_EQ(corners, now);
    }
}

/// The vertices in use are the lowest of each position that finite triangles use.
void expect_lowest_vertices(const Damaged& damaged, const MeshRepair& repair)
{
    std::map<std::uint32_t, std::uint32_t> lowest; // by truth
    for (std::size_t i = 0; i < damaged.mesh.triangle_count(); ++i) {
        const TriangleCorners& corners = damaged.mesh.triangles()[i];
        const bool finite = std::ranges::all_of(corners, [&](std::uint32_t corner) {
            return damaged.mesh.positions()[corner].allFinite();
        });
        if (!finite) continue;
        for (const std::uint32_t corner : corners) {
            const auto place = lowest.try_emplace(damaged.vertex_truth[corner], corner).first;
            place->second = std::min(place->second, corner);
        }
    }
    std::vector<VertexId> expected;
    for (const auto& [truth, vertex] : lowest) expected.push_back(VertexId{vertex});
    std::ranges::sort(expected);
    EXPECT_EQ(repair.original_vertices, expected);
}

TEST(MeshRepair, BringsBackWhatWasDamaged)
{
    const TriangleMesh truth = nested_solids().mesh();
    const double volume = *report_mesh(truth)->signed_volume;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        for (const double jitter : {0.0, 1e-5}) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << ", jitter " << jitter);
            const Damaged damaged = Damager(truth, seed, jitter).damage();
            const MeshRepairOptions options{.weld_distance = 4 * jitter};
            const MeshRepair repair = repaired(damaged.mesh, options);
            expect_maps_right(damaged.mesh, repair);
            expect_truth(truth, damaged, repair);
            expect_lowest_vertices(damaged, repair);
            EXPECT_EQ(count(repair, Kind::drop_non_finite), damaged.non_finite);
            EXPECT_EQ(count(repair, Kind::drop_degenerate), damaged.degenerate);
            EXPECT_EQ(count(repair, Kind::drop_duplicates), damaged.duplicates);
            EXPECT_EQ(repair.pieces, 5U);
            EXPECT_EQ(repair.closed_pieces, 5U);
            EXPECT_EQ(repair.cavities, 1U);
            EXPECT_EQ(repair.unorientable_edges, 0U);

            const MeshReport after = report(repair.mesh);
            EXPECT_TRUE(after.closed && after.consistently_oriented);
            EXPECT_NEAR(after.signed_volume.value_or(0), volume, (1e-12 + 100 * jitter) * volume);
            expect_idempotent(repair, options);

            MeshRepairOptions on_three = options;
            on_three.execution.threads.count = 3;
            MeshRepairOptions on_one = options;
            on_one.execution.threads.count = 1;
            EXPECT_TRUE(same_repair(repaired(damaged.mesh, on_three), repair));
            EXPECT_TRUE(same_repair(repaired(damaged.mesh, on_one), repair));
        }
    }
}

TEST(MeshRepair, LeavesSoundMeshesAsTheyAre)
{
    for (const char* const name :
         {"cube", "octahedron", "sphere:20x20", "torus:20x10", "icosphere:2"}) {
        SCOPED_TRACE(name);
        const TriangleMesh mesh = *sample_mesh(name);
        const MeshRepair repair = repaired(mesh, {.drop_zero_area = true});
        EXPECT_TRUE(same_mesh(repair.mesh, mesh));
        for (const RepairStep& step : repair.steps) EXPECT_EQ(step.count, 0U) << name_of(step.kind);
    }
}

TEST(MeshRepair, TakesSolidsThatPassThroughEachOtherForNoCavities)
{
    const TriangleMesh ship = *make_spaceship(1300); // 17 solids
    const MeshRepair repair = repaired(ship);
    EXPECT_EQ(repair.closed_pieces, 17U);
    EXPECT_EQ(repair.cavities, 0U);
    EXPECT_TRUE(
        std::ranges::all_of(repair.turned, [](std::uint8_t turned) { return turned == 0; }));
    const MeshRepair turned = repaired(inside_out(ship));
    EXPECT_EQ(count(turned, Kind::turn_outward), 17U);
    EXPECT_TRUE(same_mesh(turned.mesh, ship));
}

/// The first steps done by comparing everything with everything.
struct SlowRepair {
    std::vector<TriangleId> triangles;
    std::vector<TriangleCorners> corners;
    std::set<std::pair<std::uint32_t, std::uint32_t>> welded;
};

bool on_one_line(const TriangleMesh& mesh, const TriangleCorners& corners)
{
    // Exact: coordinates are small whole numbers.
    const Vec3& a = mesh.positions()[corners[0]];
    const Vec3 u = mesh.positions()[corners[1]] - a;
    const Vec3 v = mesh.positions()[corners[2]] - a;
    return u.cross(v).isZero(0);
}

SlowRepair slowly_repaired(const TriangleMesh& mesh, const MeshRepairOptions& options)
{
    SlowRepair slow;
    std::set<std::uint32_t> used;
    for (const TriangleCorners& corners : mesh.triangles())
        used.insert(corners.begin(), corners.end());
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        TriangleCorners corners = mesh.triangles()[id];
        for (std::uint32_t& corner : corners) {
            const auto first = std::ranges::find_if(used, [&](std::uint32_t other) {
                return mesh.positions()[other] == mesh.positions()[corner];
            });
            if (options.weld && *first != corner) slow.welded.insert({corner, *first});
            if (options.weld) corner = *first;
        }
        const std::set<std::uint32_t> own(corners.begin(), corners.end());
        if (own.size() < 3) {
            if (options.drop_degenerate) continue;
        } else {
            if (options.drop_zero_area && on_one_line(mesh, corners)) continue;
            const bool repeats =
                std::ranges::any_of(slow.corners, [&](const TriangleCorners& other) {
                    return std::set<std::uint32_t>(other.begin(), other.end()) == own;
                });
            if (options.drop_duplicates && repeats) continue;
        }
        slow.triangles.push_back(TriangleId{id});
        slow.corners.push_back(corners);
    }
    return slow;
}

/// How many pieces the triangles come apart into, and how many of these have one side.
struct SlowPieces {
    std::uint64_t pieces = 0;
    std::uint64_t unorientable = 0;
};

/// Two triangles at an edge of exactly two, and whether they run along it the same way.
struct Seam {
    std::size_t a = 0;
    std::size_t b = 0;
    bool same_way = false;
};

std::vector<Seam> seams_of(std::span<const TriangleCorners> triangles)
{
    using Ends = std::pair<std::uint32_t, std::uint32_t>;
    std::map<Ends, std::vector<std::pair<std::size_t, bool>>> edges;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const TriangleCorners& corners = triangles[i];
        if (std::set<std::uint32_t>(corners.begin(), corners.end()).size() < 3) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = corners[k];
            const std::uint32_t to = corners[(k + 1) % 3];
            edges[std::minmax(from, to)].emplace_back(i, from < to);
        }
    }
    std::vector<Seam> seams;
    for (const auto& [ends, users] : edges) {
        if (users.size() != 2) continue;
        seams.push_back({users[0].first, users[1].first, users[0].second == users[1].second});
    }
    return seams;
}

/// By spreading numbers and sides until nothing changes.
SlowPieces slow_pieces(std::span<const TriangleCorners> triangles)
{
    const std::vector<Seam> seams = seams_of(triangles);
    std::vector<std::size_t> number(triangles.size());
    std::iota(number.begin(), number.end(), 0U);
    std::vector<int> side(triangles.size(), 1);
    for (bool changed = true; changed;) {
        changed = false;
        for (const Seam& seam : seams) {
            if (number[seam.a] == number[seam.b]) continue;
            const auto [to, from] = number[seam.a] < number[seam.b] ? std::pair(seam.b, seam.a)
                                                                    : std::pair(seam.a, seam.b);
            number[to] = number[from];
            side[to] = seam.same_way ? -side[from] : side[from];
            changed = true;
        }
    }
    std::set<std::size_t> pieces;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const TriangleCorners& corners = triangles[i];
        if (std::set<std::uint32_t>(corners.begin(), corners.end()).size() == 3)
            pieces.insert(number[i]);
    }
    std::set<std::size_t> unorientable;
    for (const Seam& seam : seams) {
        const bool matches = (side[seam.a] == side[seam.b]) != seam.same_way;
        if (!matches) unorientable.insert(number[seam.a]);
    }
    return {pieces.size(), unorientable.size()};
}

std::uint64_t unmatched_seams(std::span<const TriangleCorners> triangles)
{
    const std::vector<Seam> seams = seams_of(triangles);
    return static_cast<std::uint64_t>(
        std::ranges::count_if(seams, [](const Seam& seam) { return seam.same_way; }));
}

/// The Möbius strip of five triangles, corners and triangles in any order, with a few more or less.
TriangleMesh nearly_a_strip(std::uint32_t seed)
{
    std::mt19937 random(seed);
    Draft draft = Draft().add(make_octahedron());
    std::array<std::uint32_t, 6> names = {0, 1, 2, 3, 4, 5};
    std::ranges::shuffle(names, random);
    draft.triangles.clear();
    for (std::uint32_t i = 0; i < 5; ++i) {
        TriangleCorners corners = {names[i], names[(i + 1) % 5], names[(i + 2) % 5]};
        std::ranges::shuffle(corners, random);
        if (below(random, 10) != 0) draft.triangles.push_back(corners);
    }
    for (std::uint32_t more = below(random, 3); more > 0; --more)
        draft.triangles.push_back({below(random, 6), below(random, 6), below(random, 6)});
    std::ranges::shuffle(draft.triangles, random);
    return draft.mesh();
}

TEST(MeshRepair, AgreesWithComparingEverythingOnSoups)
{
    std::uint64_t unorientable = 0;
    for (std::uint32_t seed = 0; seed < 4000; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = seed % 2 == 0 ? random_soup(seed) : nearly_a_strip(seed);
        std::mt19937 random(seed);
        const auto coin = [&] { return random() % 3 != 0; };
        const MeshRepairOptions options{.weld = coin(),
                                        .drop_degenerate = coin(),
                                        .drop_zero_area = coin(),
                                        .drop_duplicates = coin(),
                                        .orient = coin(),
                                        .turn_outward = coin(),
                                        .keep_cavities = coin(),
                                        .drop_unused_vertices = coin()};
        const SlowRepair slow = slowly_repaired(mesh, options);
        const MeshRepair repair = repaired(mesh, options);
        expect_maps_right(mesh, repair);
        EXPECT_EQ(repair.original_triangles, slow.triangles);
        EXPECT_EQ(count(repair, Kind::weld_vertices), slow.welded.size());
        EXPECT_EQ(count(repair, Kind::drop_degenerate) + count(repair, Kind::drop_zero_area) +
                      count(repair, Kind::drop_duplicates),
                  mesh.triangle_count() - repair.mesh.triangle_count());
        for (std::size_t i = 0; i < slow.corners.size(); ++i) {
            TriangleCorners now = repair.mesh.triangles()[i];
            for (std::uint32_t& corner : now) corner = to_index(repair.original_vertices[corner]);
            TriangleCorners expected = slow.corners[i];
            if (repair.turned[i] != 0) std::swap(expected[1], expected[2]);
            EXPECT_EQ(now, expected);
        }
        if (options.orient || options.turn_outward) {
            EXPECT_EQ(repair.pieces, slow_pieces(slow.corners).pieces);
        }
        if (options.orient) {
            EXPECT_EQ(repair.unorientable_pieces, slow_pieces(slow.corners).unorientable);
            EXPECT_EQ(repair.unorientable_edges, unmatched_seams(repair.mesh.triangles()));
            unorientable += repair.unorientable_pieces;
        }
        expect_idempotent(repair, options);
    }
    EXPECT_GT(unorientable, 200U);
}

/// Everything wrong at once.
TriangleMesh rubbish()
{
    Draft draft = cube_draft().add(make_octahedron(), Vec3(10, 0, 0), 0.5);
    draft.positions.push_back(draft.positions[0]); // 14: a copy of 0
    draft.positions.emplace_back(nan_value, 0, 0); // 15
    draft.positions.emplace_back(5, 5, 5);         // 16: unused
    draft.positions.push_back(0.5 * (draft.positions[draft.triangles[0][0]] +
                                     draft.positions[draft.triangles[0][1]])); // 17
    std::swap(draft.triangles[3][1], draft.triangles[3][2]);                   // faces inward
    for (std::size_t i = 12; i < 20; ++i) std::swap(draft.triangles[i][1], draft.triangles[i][2]);
    for (std::uint32_t& corner : draft.triangles[5]) {
        if (corner == 0) corner = 14;
    }
    const auto [a, b, c] = draft.triangles[0];
    draft.triangles.push_back({b, a, c});  // 20: a duplicate
    draft.triangles.push_back({a, a, b});  // 21: degenerate
    draft.triangles.push_back({a, 17, b}); // 22: without area
    draft.triangles.push_back({a, 15, b}); // 23: not finite
    return draft.mesh();
}

TEST(MeshRepair, CountsWhatEachStepDid)
{
    const MeshRepairOptions options{.drop_zero_area = true, .min_component_triangles = 9};
    const MeshRepair repair = repaired(rubbish(), options);
    const std::vector<std::pair<Kind, std::uint64_t>> expected = {
        {Kind::drop_non_finite, 1},         {Kind::weld_vertices, 1},
        {Kind::drop_degenerate, 1},         {Kind::drop_zero_area, 1},
        {Kind::drop_duplicates, 1},         {Kind::drop_small_components, 1},
        {Kind::orient_pieces, 1},           {Kind::turn_outward, 0},
        {Kind::drop_unused_vertices, 3 + 6}};
    for (const auto& [kind, number] : expected) {
        EXPECT_EQ(count(repair, kind), number) << name_of(kind);
        EXPECT_TRUE(repair.step(kind).enabled);
        EXPECT_EQ(repair.step(kind).kind, kind);
    }
    EXPECT_TRUE(same_mesh(repair.mesh, make_cube()));
    EXPECT_EQ(repair.turned, (std::vector<std::uint8_t>{0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(MeshRepair, DoesNothingOfAStepThatIsOff)
{
    const TriangleMesh mesh = rubbish();
    const MeshRepairOptions all{.drop_zero_area = true, .min_component_triangles = 9};
    const MeshRepairOptions none{.drop_non_finite = false,
                                 .weld = false,
                                 .drop_degenerate = false,
                                 .drop_duplicates = false,
                                 .orient = false,
                                 .turn_outward = false,
                                 .drop_unused_vertices = false};
    const MeshRepair untouched = repaired(mesh, none);
    EXPECT_TRUE(same_mesh(untouched.mesh, mesh));
    for (const RepairStep& step : untouched.steps) {
        EXPECT_EQ(step.count, 0U);
        EXPECT_FALSE(step.enabled);
    }
    const auto expect_off = [&](Kind kind, const auto& switch_off) {
        MeshRepairOptions options = all;
        switch_off(options);
        const MeshRepair repair = repaired(mesh, options);
        EXPECT_EQ(count(repair, kind), 0U) << name_of(kind);
        EXPECT_FALSE(repair.step(kind).enabled);
        for (const RepairStep& step : repair.steps)
            EXPECT_EQ(step.enabled, step.kind != kind) << name_of(step.kind);
    };
    expect_off(Kind::drop_non_finite, [](auto& options) { options.drop_non_finite = false; });
    expect_off(Kind::weld_vertices, [](auto& options) { options.weld = false; });
    expect_off(Kind::drop_degenerate, [](auto& options) { options.drop_degenerate = false; });
    expect_off(Kind::drop_zero_area, [](auto& options) { options.drop_zero_area = false; });
    expect_off(Kind::drop_duplicates, [](auto& options) { options.drop_duplicates = false; });
    expect_off(Kind::drop_small_components,
               [](auto& options) { options.min_component_triangles = 0; });
    expect_off(Kind::orient_pieces, [](auto& options) { options.orient = false; });
    expect_off(Kind::turn_outward, [](auto& options) { options.turn_outward = false; });
    expect_off(Kind::drop_unused_vertices,
               [](auto& options) { options.drop_unused_vertices = false; });
}

TEST(MeshRepair, KeepsUnusedVerticesThatWereNotWelded)
{
    const TriangleMesh mesh = rubbish();
    const MeshRepair repair = repaired(mesh, {.drop_unused_vertices = false});
    EXPECT_EQ(repair.mesh.vertex_count(), mesh.vertex_count() - 1); // 14 became 0
    EXPECT_EQ(std::ranges::find(repair.original_vertices, VertexId{14}),
              repair.original_vertices.end());
    EXPECT_NE(std::ranges::find(repair.original_vertices, VertexId{15}),
              repair.original_vertices.end());
}

TEST(MeshRepair, KeepsTheWayOfMostTrianglesOfAnOpenPiece)
{
    for (std::uint32_t seed = 0; seed < 50; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Draft sheet;
        constexpr std::uint32_t side = 9;
        for (std::uint32_t i = 0; i < side * side; ++i)
            sheet.positions.emplace_back(i / side, i % side, 0);
        for (std::uint32_t i = 0; i + side < side * side; ++i) {
            if (i % side + 1 == side) continue;
            sheet.triangles.push_back({i, i + side, i + 1});
            sheet.triangles.push_back({i + side, i + side + 1, i + 1});
        }
        const TriangleMesh truth = sheet.mesh();
        std::uint64_t turned = 0;
        for (TriangleCorners& corners : sheet.triangles) {
            if (2 * (turned + 1) >= truth.triangle_count() || random() % 3 != 0) continue;
            std::swap(corners[1], corners[2]);
            ++turned;
        }
        const MeshRepair repair = repaired(sheet.mesh());
        EXPECT_TRUE(same_mesh(repair.mesh, truth));
        EXPECT_EQ(count(repair, Kind::orient_pieces), turned);
        EXPECT_EQ(repair.pieces, 1U);
        EXPECT_EQ(repair.closed_pieces, 0U);
        EXPECT_EQ(count(repair, Kind::turn_outward), 0U);
    }
}

TEST(MeshRepair, ReportsAMoebiusStrip)
{
    constexpr std::uint32_t quads = 15;
    Draft strip;
    for (std::uint32_t i = 0; i < quads; ++i) {
        const double angle = 2 * std::numbers::pi * i / quads;
        const Vec3 out(std::cos(angle), std::sin(angle), 0);
        const Vec3 across = 0.3 * (std::cos(angle / 2) * out + std::sin(angle / 2) * Vec3::UnitZ());
        strip.positions.push_back(out + across);
        strip.positions.push_back(out - across);
    }
    for (std::uint32_t i = 0; i < quads; ++i) {
        const std::uint32_t a = 2 * i;
        const bool last = i + 1 == quads; // joined with its sides exchanged
        const std::uint32_t b = last ? 1 : a + 2;
        const std::uint32_t c = last ? 0 : a + 3;
        strip.triangles.push_back({a, b, a + 1});
        strip.triangles.push_back({b, c, a + 1});
    }
    strip.add(make_cube(), Vec3(5, 0, 0));
    const MeshRepair repair = repaired(strip.mesh());
    EXPECT_EQ(repair.pieces, 2U);
    EXPECT_EQ(repair.closed_pieces, 1U);
    EXPECT_EQ(repair.unorientable_pieces, 1U);
    EXPECT_EQ(repair.unorientable_edges, 1U);
    EXPECT_EQ(repair.mesh.triangle_count(), 2 * quads + 12);
    expect_idempotent(repair, {});
    EXPECT_EQ(repaired(strip.mesh(), {.orient = false}).unorientable_edges, 0U);
}

TEST(MeshRepair, TurnsClosedPiecesOutwardOrAsCavities)
{
    // Five shells, one in the other, each facing anywhere.
    for (std::uint32_t facing = 0; facing < 32; ++facing) {
        Draft draft;
        for (std::uint32_t shell = 0; shell < 5; ++shell) {
            const TriangleMesh ball = make_icosphere(1);
            draft.add((facing >> shell & 1U) != 0 ? inside_out(ball) : ball, Vec3(9, 0, 0),
                      1.0 + shell);
        }
        const auto volumes = [&](bool keep_cavities) {
            const MeshRepair repair = repaired(draft.mesh(), {.keep_cavities = keep_cavities});
            EXPECT_EQ(repair.cavities, keep_cavities ? 2U : 0U);
            return *report(repair.mesh).signed_volume;
        };
        const double ball = *report(make_icosphere(1)).signed_volume;
        EXPECT_NEAR(volumes(true), (1 - 8 + 27 - 64 + 125) * ball, 1e-9);
        EXPECT_NEAR(volumes(false), (1 + 8 + 27 + 64 + 125) * ball, 1e-9);
        EXPECT_TRUE(same_mesh(repaired(draft.mesh(), {.turn_outward = false}).mesh, draft.mesh()));
    }
}

TEST(MeshRepair, TellsPiecesThatTouchAtAnEdge)
{
    // Two cubes with one edge in common: four triangles there, a piece for each cube.
    Draft draft = cube_draft().add(inside_out(make_cube()), Vec3(2, 2, 0));
    const MeshRepair repair = repaired(draft.mesh());
    EXPECT_EQ(count(repair, Kind::weld_vertices), 2U);
    EXPECT_EQ(repair.closed_pieces, 2U);
    EXPECT_EQ(count(repair, Kind::turn_outward), 1U);
    EXPECT_EQ(report(repair.mesh).signed_volume, 16.0);
}

TEST(MeshRepair, FindsACavityThatHasACornerOfWhatIsAroundIt)
{
    for (int corner = 0; corner < 8; ++corner) {
        Draft draft = cube_draft();
        const Vec3 shared = draft.positions[static_cast<std::size_t>(corner)];
        const auto first = static_cast<std::uint32_t>(draft.positions.size());
        for (int axis = 0; axis < 3; ++axis) {
            draft.positions.push_back(0.5 * shared);
            draft.positions.back()[axis] = 0;
        }
        draft.positions.push_back(shared);
        draft.triangles.push_back({first, first + 1, first + 2});
        for (std::uint32_t k = 0; k < 3; ++k)
            draft.triangles.push_back({first + (k + 1) % 3, first + k, first + 3});
        const MeshRepair repair = repaired(draft.mesh());
        EXPECT_EQ(repair.closed_pieces, 2U);
        EXPECT_EQ(repair.cavities, 1U) << "at corner " << corner;
        EXPECT_LT(*report(repair.mesh).signed_volume, 8);
    }
}

TEST(MeshRepair, LeavesPiecesWithoutVolume)
{
    // A sheet of two sides: closed, but neither way is outward.
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)};
    draft.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 3, 1}, {0, 2, 3}};
    const MeshRepair repair = repaired(draft.mesh());
    EXPECT_EQ(repair.closed_pieces, 1U);
    EXPECT_TRUE(same_mesh(repair.mesh, draft.mesh()));
}

TEST(MeshRepair, DropsComponentsByAreaOrByTriangles)
{
    Draft draft;
    draft.add(make_cube()); // 12 triangles, area 24
    draft.add(make_icosphere(2), Vec3(5, 0, 0), 0.1);
    draft.add(make_cube(), Vec3(9, 0, 0), 0.5); // area 6
    const auto triangles_left = [&](const MeshRepairOptions& options) {
        const MeshRepair repair = repaired(draft.mesh(), options);
        expect_idempotent(repair, options);
        return repair.mesh.triangle_count();
    };
    EXPECT_EQ(triangles_left({.min_component_area = 0.25}), 24U);
    EXPECT_EQ(triangles_left({.min_component_area = 0.26}), 12U);
    EXPECT_EQ(triangles_left({.min_component_area = 1.0}), 12U);
    EXPECT_EQ(triangles_left({.min_component_area = 1e-9}), 24U + 320U);
    EXPECT_EQ(triangles_left({.min_component_triangles = 12}), 24U + 320U);
    EXPECT_EQ(triangles_left({.min_component_triangles = 13}), 320U);
    EXPECT_EQ(triangles_left({.min_component_triangles = 321}), 0U);
}

TEST(MeshRepair, TrianglesOfTwoCornersBelongToNoComponent)
{
    // Along edges of a cube of 12 triangles: before the others and after them.
    Draft draft;
    draft.triangles = {{0, 1, 0}, {1, 1, 3}};
    draft.add(make_cube());
    draft.triangles.push_back({2, 3, 3});
    const auto left = [&](std::uint64_t least) {
        const MeshRepair repair =
            repaired(draft.mesh(), {.drop_degenerate = false, .min_component_triangles = least});
        EXPECT_EQ(count(repair, Kind::drop_small_components), least > 12 ? 1U : 0U);
        return repair.mesh.triangle_count();
    };
    EXPECT_EQ(left(12), 15U);
    EXPECT_EQ(left(13), 3U); // those, for they are in no component that could be dropped
}

TEST(MeshRepair, DoesNotTakeForACavityWhatADroppedPieceSurrounded)
{
    Draft draft = cube_draft().add(make_icosphere(1), Vec3::Zero(), 0.5);
    EXPECT_EQ(repaired(draft.mesh()).cavities, 1U);
    const MeshRepair repair = repaired(draft.mesh(), {.min_component_triangles = 20});
    EXPECT_EQ(repair.cavities, 0U);
    EXPECT_GT(*report(repair.mesh).signed_volume, 0);
}

TEST(MeshRepair, TakesAnyScale)
{
    const TriangleMesh truth = nested_solids().mesh();
    for (const double scale : {1e-300, 1e-150, 1e-9, 1e9, 1e150, 1e305}) {
        SCOPED_TRACE(scale);
        Draft draft;
        draft.add(inside_out(truth), Vec3::Zero(), scale);
        const MeshRepair repair =
            repaired(draft.mesh(), {.weld_distance = std::min(scale / 1e3, 1e300)});
        EXPECT_EQ(count(repair, Kind::turn_outward), 5U);
        EXPECT_TRUE(std::ranges::equal(repair.mesh.triangles(), truth.triangles()));
    }
}

TEST(MeshRepair, TakesEmptyMeshes)
{
    const MeshRepair nothing = repaired(TriangleMesh());
    EXPECT_EQ(nothing.mesh.triangle_count(), 0U);
    const TriangleMesh points = *make_triangle_mesh({Vec3(1, 2, 3), Vec3(nan_value, 0, 0)}, {});
    EXPECT_EQ(count(repaired(points), Kind::drop_unused_vertices), 2U);
    EXPECT_TRUE(same_mesh(repaired(points, {.drop_unused_vertices = false}).mesh, points));
}

TEST(MeshRepair, RefusesWrongOptions)
{
    const TriangleMesh cube = make_cube();
    const auto code = [&](const MeshRepairOptions& options) {
        const auto repair = repair_mesh(cube, options);
        return repair ? std::string() : repair.error().where;
    };
    for (const double distance : {-1.0, nan_value, 2e300})
        EXPECT_EQ(code({.weld_distance = distance}), "weld_distance");
    for (const double area : {-0.1, nan_value, 1.1})
        EXPECT_EQ(code({.min_component_area = area}), "min_component_area");
    const auto small = repair_mesh(cube, {.execution = {.budget = {1000}}});
    ASSERT_FALSE(small);
    EXPECT_EQ(small.error().code, ErrorCode::budget_exceeded);
}

TEST(MeshRepair, StopsAtEveryStage)
{
    const TriangleMesh truth =
        Draft().add(make_sphere(60, 60)).add(make_cube(), Vec3(3, 0, 0)).mesh();
    const Damaged damaged = Damager(truth, 1, 1e-6).damage();
    testing::cancel_at_every_stage(
        [&](Progress& progress) {
            return repair_mesh(damaged.mesh, {.weld_distance = 4e-6,
                                              .drop_zero_area = true,
                                              .execution = {.progress = &progress}});
        },
        [] { return true; }, 5);
}

TEST(MeshRepair, ReportsEachStageToItsEnd)
{
    // Two solids, one in the other, damaged: every step has something to do.
    const Damaged damaged = Damager(nested_solids().mesh(), 1, 1e-6).damage();
    std::map<std::string, double> farthest; // by stage
    for (std::uint64_t reports = 1;; ++reports) {
        ASSERT_LT(reports, 10000U);
        Progress progress;
        progress.cancel_after(reports);
        const auto repair = repair_mesh(
            damaged.mesh,
            {.weld_distance = 4e-6, .drop_zero_area = true, .execution = {.progress = &progress}});
        double& most = farthest[progress.stage()];
        most = std::max(most, progress.fraction());
        if (repair) break;
    }
    for (const char* const stage : {"welding vertices", "finding duplicate triangles"})
        EXPECT_TRUE(farthest.contains(stage)) << stage; // told in blocks of more steps than these
    for (const char* const stage : {"dropping triangles", "turning pieces outward", "making mesh"})
        EXPECT_EQ(farthest[stage], 1) << stage;
}

} // namespace
} // namespace proxima::mesh_repair_test
