// What each step of a repair does.
#include "code_of.h"
#include "mesh/mesh_drafts.h"
#include "mesh/random_soups.h"
#include "mesh/repaired.h"
#include "proxima/mesh_repair.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace proxima::mesh_repair_test {
namespace {

using namespace testing;
using Kind = RepairStepKind;

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

/// Some of the tetrahedra of a lattice, each with all its faces, outward: walls between them are double.
TriangleMesh random_tetrahedra(std::mt19937& random)
{
    constexpr std::uint32_t side = 4;
    Draft draft;
    for (std::uint32_t i = 0; i < side * side * side; ++i)
        draft.positions.emplace_back(i % side, i / side % side, i / side / side);
    for (std::uint32_t cell = 0; cell < 27; ++cell) {
        std::array<std::uint32_t, 3> axes = {0, 1, 2};
        do { // one tetrahedron for each way along three edges from corner to corner of the cell
            if (random() % 3 == 0) continue;
            std::array<std::uint32_t, 4> at = {cell % 3 +
                                               side * (cell / 3 % 3 + side * (cell / 9))};
            constexpr std::array<std::uint32_t, 3> steps = {1, side, side * side};
            for (std::size_t k = 0; k < 3; ++k) at.at(k + 1) = at.at(k) + steps.at(axes.at(k));
            const auto from = [&](std::size_t k) -> Vec3 {
                return draft.positions[at.at(k)] - draft.positions[at[0]];
            };
            if (from(1).cross(from(2)).dot(from(3)) < 0) std::swap(at[2], at[3]);
            draft.triangles.insert(draft.triangles.end(), {{at[0], at[2], at[1]},
                                                           {at[0], at[1], at[3]},
                                                           {at[1], at[2], at[3]},
                                                           {at[0], at[3], at[2]}});
        } while (std::ranges::next_permutation(axes).found);
    }
    std::ranges::shuffle(draft.triangles, random);
    return draft.mesh();
}

TEST(MeshRepair, KeepsWallsBetweenSolids)
{
    std::uint64_t walls = 0;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const TriangleMesh mesh = random_tetrahedra(random);
        const MeshReport before = report(mesh);
        ASSERT_TRUE(before.closed && before.consistently_oriented);
        walls += before.find(FindingKind::duplicate_triangles)->count;
        const MeshRepair repair = repaired(mesh);
        EXPECT_TRUE(same_mesh(repair.mesh, repaired(mesh, {.drop_duplicates = false}).mesh));
        const MeshReport after = report(repair.mesh);
        EXPECT_TRUE(after.closed && after.consistently_oriented);
        EXPECT_NEAR(after.signed_volume.value_or(0), *before.signed_volume, 1e-12);
    }
    EXPECT_GT(walls, 1000U);
}

/// Two boxes of squares of two triangles, side by side, with the wall between them twice. Closed.
Draft boxes_with_a_wall()
{
    constexpr std::uint32_t side = 4;
    constexpr std::uint32_t row = side + 1;
    constexpr std::uint32_t layer = row * row;
    Draft draft;
    for (std::uint32_t i = 0; i < (2 * side + 1) * layer; ++i)
        draft.positions.emplace_back(i / layer, i / row % row, i % row);
    constexpr std::array<std::uint32_t, 3> steps = {layer, row, 1};
    for (std::uint32_t box = 0; box < 2; ++box) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::uint32_t at = 0; at < side * side; ++at) {
                const std::uint32_t u = steps.at((axis + 1) % 3);
                const std::uint32_t v = steps.at((axis + 2) % 3);
                const std::uint32_t low = box * side * layer + at / side * u + at % side * v;
                const std::uint32_t high = low + side * steps.at(axis);
                draft.triangles.insert(draft.triangles.end(),
                                       {{low, low + v, low + u}, {low + u, low + v, low + u + v}});
                draft.triangles.insert(draft.triangles.end(), {{high, high + u, high + v},
                                                               {high + u, high + u + v, high + v}});
            }
        }
    }
    return draft;
}

TEST(MeshRepair, BringsBackSolidsWithAWallOfWhichTrianglesWereAddedAgain)
{
    const Draft truth = boxes_with_a_wall();
    const MeshReport sound = report(truth);
    ASSERT_TRUE(sound.closed && sound.consistently_oriented);
    ASSERT_EQ(sound.find(FindingKind::duplicate_triangles)->count, 32U);
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Draft draft = truth;
        std::set<std::set<std::uint32_t>> chosen;
        while (chosen.size() < 1 + seed % 12) { // each once more, either way round
            TriangleCorners again = truth.triangles[random() % truth.triangles.size()];
            if (!chosen.insert({again.begin(), again.end()}).second) continue;
            if (random() % 2 == 0) std::swap(again[0], again[1]);
            draft.triangles.push_back(again);
        }
        std::ranges::shuffle(draft.triangles, random);
        const MeshRepair repair = repaired(draft.mesh());
        EXPECT_EQ(count(repair, Kind::drop_duplicates), chosen.size());
        const MeshReport after = report(repair.mesh);
        EXPECT_TRUE(after.closed && after.consistently_oriented);
        EXPECT_NEAR(after.signed_volume.value_or(0), *sound.signed_volume, 1e-9);
        EXPECT_EQ(after.find(FindingKind::duplicate_triangles)->count, 32U);
        expect_idempotent(repair, {});
    }
}

TEST(MeshRepair, DropsSidesThatAreOpenAllRoundBeforeOthers)
{
    // Two tetrahedra with a wall between them, two faces of one of which are there again, turned
    // over: two of the wall's three edges are open, too, and closed once these are single.
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)};
    draft.triangles = {{0, 2, 1}, {0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2},
                       {0, 4, 1}, {1, 4, 2}, {0, 2, 4}, {0, 3, 1}, {1, 3, 2}};
    for (const bool walls_last : {false, true}) {
        if (walls_last) std::ranges::reverse(draft.triangles);
        const MeshRepair repair = repaired(draft.mesh());
        EXPECT_EQ(count(repair, Kind::drop_duplicates), 2U);
        const MeshReport after = report(repair.mesh);
        EXPECT_TRUE(after.closed);
        if (!walls_last) { // else the faces that were turned over come first, and stay
            EXPECT_TRUE(after.consistently_oriented);
            EXPECT_NEAR(after.signed_volume.value_or(0), 1.0 / 3, 1e-12);
        }
    }
}

TEST(MeshRepair, KnowsCavitiesOfSolidsWithWalls)
{
    // In each box a cavity, in one of them a solid in the cavity, and one beside both boxes.
    Draft draft = boxes_with_a_wall();
    const auto add = [&](const Vec3& center, double size, bool inward) {
        draft.add(inward ? inside_out(make_octahedron()) : make_octahedron(), center, size);
    };
    add({2.1, 2.2, 1.9}, 1.5, true);
    add({6.1, 2.2, 1.9}, 1.5, true);
    add({6.2, 2.1, 1.9}, 0.5, false);
    add({2, 2, 9}, 2, false);
    const TriangleMesh truth = draft.mesh();
    const MeshRepair kept = repaired(truth);
    EXPECT_TRUE(same_mesh(kept.mesh, repaired(truth, {.turn_outward = false}).mesh));
    EXPECT_EQ(kept.cavities, 2U);
    // And turned back where all of them face the other way.
    for (std::size_t i = 384; i < draft.triangles.size(); ++i)
        std::swap(draft.triangles[i][1], draft.triangles[i][2]);
    const MeshRepair turned = repaired(draft.mesh());
    EXPECT_EQ(count(turned, Kind::turn_outward), 4U);
    EXPECT_EQ(turned.cavities, 2U);
    EXPECT_EQ(*report(turned.mesh).signed_volume, *report(truth).signed_volume);
    // All of them are solids where that is asked for.
    EXPECT_EQ(count(repaired(truth, {.keep_cavities = false}), Kind::turn_outward), 2U);
    // Boxes without a corner, or with a hole, enclose nothing: only the solid in one of the others is left.
    Draft broken = draft;
    broken.positions[0].x() = nan_value;
    EXPECT_EQ(repaired(broken.mesh(), {.drop_non_finite = false}).cavities, 1U);
    draft.triangles.erase(draft.triangles.begin());
    EXPECT_EQ(repaired(draft.mesh()).cavities, 1U);
}

TEST(MeshRepair, KeepsSidesOfSolidsThatFillACavity)
{
    // One solid becomes a void, as its surface is two-sided throughout; two with a wall between
    // them do not, which would leave edges of three.
    const TriangleMesh boxes = boxes_with_a_wall().mesh();
    Draft filled;
    filled.positions.assign(boxes.positions().begin(), boxes.positions().end());
    for (const TriangleCorners& corners : boxes.triangles()) filled.triangles.push_back(corners);
    const std::size_t inner = filled.triangles.size();
    for (std::size_t i = 0; i < inner; ++i) {
        const auto [a, b, c] = filled.triangles[i];
        const bool is_wall = filled.positions[a].x() == 4 && filled.positions[b].x() == 4 &&
                             filled.positions[c].x() == 4;
        if (!is_wall) filled.triangles.push_back({a, c, b});
    }
    filled.add(make_cube(), Vec3(4, 2, 2), 20);
    const MeshReport before = report(filled);
    ASSERT_TRUE(before.closed && before.consistently_oriented);
    const MeshRepair repair = repaired(filled.mesh());
    EXPECT_EQ(count(repair, Kind::drop_duplicates), 0U);
    EXPECT_NEAR(*report(repair.mesh).signed_volume, *before.signed_volume, 1e-9);

    const Draft one = cube_draft().add(inside_out(make_cube())).add(make_cube(), Vec3::Zero(), 20);
    const MeshRepair emptied = repaired(one.mesh());
    EXPECT_EQ(count(emptied, Kind::drop_duplicates), 12U);
    EXPECT_EQ(emptied.cavities, 1U);
    EXPECT_NEAR(*report(emptied.mesh).signed_volume, 8 * (8000 - 1), 1e-6);
}

TEST(MeshRepair, KeepsOneOfTwoSidesThatAreAllThereIs)
{
    // A closed shell and a sheet with both sides, and a shell of which one triangle is there a
    // second time, facing inward: each becomes simple.
    const TriangleMesh cube = make_cube();
    const Draft shell = cube_draft().add(inside_out(cube));
    Draft sheet;
    sheet.positions = shell.positions;
    for (std::size_t i = 0; i < 4; ++i) sheet.triangles.push_back(cube.triangles()[i]);
    for (std::size_t i = 0; i < 4; ++i) sheet.triangles.push_back(shell.triangles[12 + i]);
    Draft once = cube_draft();
    once.triangles.insert(once.triangles.begin(), inside_out(cube).triangles()[5]);
    for (const Draft& draft : {shell, sheet, once}) {
        const MeshRepair repair = repaired(draft.mesh());
        const std::size_t expected = draft.triangles.size() == 8 ? 4 : 12;
        EXPECT_EQ(count(repair, Kind::drop_duplicates), draft.triangles.size() - expected);
        EXPECT_EQ(repair.mesh.triangle_count(), expected);
        EXPECT_EQ(report(repair.mesh).closed, expected == 12);
        EXPECT_TRUE(report(repair.mesh).consistently_oriented);
    }
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
    EXPECT_EQ(code_of(small), ErrorCode::budget_exceeded);
}

TEST(MeshRepair, TurnsPartsBesideWhatIsFarAway)
{
    Draft draft = cube_draft();
    for (TriangleCorners& corners : draft.triangles) std::swap(corners[0], corners[1]);
    draft.positions.emplace_back(1.7e308, 0, 0); // of no triangle
    const auto turned_by = [](const Draft& of, const MeshRepairOptions& options) {
        return count(repaired(of.mesh(), options), Kind::turn_outward);
    };
    EXPECT_EQ(turned_by(draft, {.drop_unused_vertices = false}), 1U);
    draft.positions.back() = {1e110, 0, 0};
    draft.positions.emplace_back(1e110, 1e100, 0);
    draft.positions.emplace_back(1e110, 0, 1e100);
    draft.triangles.push_back({8, 9, 10});
    EXPECT_EQ(turned_by(draft, {}), 1U);
}

TEST(MeshRepair, DropsSmallComponentsOfAnySize)
{
    for (const double size : {1e-300, 1e-170, 1.0, 1e160, 1e300}) {
        Draft draft = cube_draft();
        draft.add(make_cube(), Vec3(5, 0, 0), 0.5); // a quarter of the area
        for (Vec3& p : draft.positions) p *= size;
        draft.positions.emplace_back(1.7e308, 0, 0); // of no triangle
        const auto left = [&](double area) {
            return repaired(draft.mesh(),
                            {.min_component_area = area, .drop_unused_vertices = false})
                .mesh;
        };
        EXPECT_EQ(left(0.24).triangle_count(), 24U) << size;
        EXPECT_EQ(left(0.26).triangle_count(), 12U) << size;
    }
}

TEST(MeshRepair, LeavesTheFirstOfTwoThatDisagreeAsItIs)
{
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)};
    draft.triangles = {{0, 1, 2}, {1, 2, 3}};
    EXPECT_EQ(repaired(draft.mesh()).turned, (std::vector<std::uint8_t>{0, 1}));
}

} // namespace
} // namespace proxima::mesh_repair_test
