// Repairs bring back a mesh that was damaged in known ways.
#include "cancellation.h"
#include "mesh/mesh_drafts.h"
#include "mesh/random_soups.h"
#include "mesh/repaired.h"
#include "proxima/mesh_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

namespace proxima::repair_of_damage_test {
namespace {

using namespace testing;
using Kind = RepairStepKind;

constexpr std::uint32_t no_truth = ~0U;

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

std::uint32_t copy_that_stays(const TriangleMesh& truth, const Damaged& damaged, std::uint32_t one)
{
    std::vector<std::uint32_t> as_it_was;
    std::vector<std::uint32_t> turned;
    for (std::uint32_t id = 0; id < damaged.triangle_truth.size(); ++id) {
        if (damaged.triangle_truth[id] != one) continue;
        TriangleCorners corners = damaged.mesh.triangles()[id];
        for (std::uint32_t& corner : corners) corner = damaged.vertex_truth[corner];
        const bool same = lowest_first(corners) == lowest_first(truth.triangles()[one]);
        (same ? as_it_was : turned).push_back(id);
    }
    if (as_it_was.size() == turned.size()) return std::min(as_it_was[0], turned[0]);
    return (as_it_was.size() > turned.size() ? as_it_was : turned)[0];
}

/// The repair has each triangle of the truth once, as it faced, from the lowest of the copies that
/// face the way of most.
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
        EXPECT_EQ(copy_that_stays(truth, damaged, one), before);
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
    for (const char* const stage :
         {"dropping triangles", "choosing sides of walls", "turning pieces outward", "making mesh"})
        EXPECT_EQ(farthest[stage], 1) << stage;
}

} // namespace
} // namespace proxima::repair_of_damage_test
