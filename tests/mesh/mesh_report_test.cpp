#include "proxima/mesh_report.h"

#include "code_of.h"
#include "mesh/mesh_drafts.h"
#include "proxima/mesh_repair.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace proxima::mesh_report_test {
namespace {

TEST(MeshReport, FindsNothingWrongWithTheSamples)
{
    for (const char* name :
         {"cube", "octahedron", "sphere:20x30", "icosphere:3", "torus:12x9", "spaceship:33000"}) {
        SCOPED_TRACE(name);
        const auto mesh = sample_mesh(name);
        const MeshReport found = report(*mesh);
        EXPECT_EQ(kinds(found), Kinds{});
        EXPECT_TRUE(found.closed);
        EXPECT_TRUE(found.consistently_oriented);
        EXPECT_EQ(found.orientation, Orientation::outward);
        EXPECT_EQ(found.vertices, mesh->vertex_count());
        EXPECT_EQ(found.triangles, mesh->triangle_count());
        EXPECT_EQ(found.edges, mesh->triangle_count() * 3 / 2);
        EXPECT_EQ(found.boundary_loops, 0U);
        EXPECT_FALSE(found.closed_if_welded);
        ASSERT_EQ(found.outlook.size(), 6U);
        for (std::size_t query = 0; query < 6; ++query) {
            EXPECT_EQ(found.outlook[query].query, static_cast<QueryKind>(query));
            EXPECT_EQ(found.outlook[query].outlook, Outlook::works);
            EXPECT_FALSE(found.outlook[query].reason.empty());
        }
    }
}

TEST(MeshReport, MeasuresTheSamples)
{
    const MeshReport cube = report(make_cube());
    EXPECT_EQ(cube.components, 1U);
    EXPECT_EQ(cube.bounds.lower, Vec3(-1, -1, -1));
    EXPECT_EQ(cube.bounds.upper, Vec3(1, 1, 1));
    EXPECT_DOUBLE_EQ(cube.area, 24.0);
    EXPECT_DOUBLE_EQ(cube.signed_volume.value(), 8.0);
    EXPECT_DOUBLE_EQ(cube.min_edge_length, 2.0);
    EXPECT_DOUBLE_EQ(cube.max_edge_length, std::sqrt(8.0));
    EXPECT_EQ(cube.euler_characteristic, 2);
    EXPECT_EQ(cube.genus, 0);

    const MeshReport torus = report(make_torus(12, 9));
    EXPECT_EQ(torus.euler_characteristic, 0);
    EXPECT_EQ(torus.genus, 1);

    const MeshReport both = report(Draft().add(make_cube()).add(make_torus(5, 5), Vec3(9, 0, 0)));
    EXPECT_EQ(both.components, 2U);
    EXPECT_EQ(both.euler_characteristic, 2);
    EXPECT_EQ(both.genus, 1);

    const MeshReport ship = report(*make_spaceship(2000));
    EXPECT_EQ(ship.components, 17U);
    EXPECT_EQ(ship.genus, 0);
}

TEST(MeshReport, KnowsTheSidesAndVolumesOfTinyParts)
{
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(20, 30);
        const auto anywhere = [&] {
            const double x = place(random), y = place(random), z = place(random);
            return Vec3(x, y, z);
        };
        Draft draft;
        if (seed % 4 != 0) draft.add(make_cube(), Vec3::Zero(), 5);
        const double side = seed % 2 == 0 ? 3e-5 : 1e-6;
        for (int i = 0; i < 20; ++i) draft.add(make_cube(), anywhere(), side / 2);
        const double volume = (seed % 4 != 0 ? 1000.0 : 0) + 20 * side * side * side;

        const MeshReport found = report(draft);
        EXPECT_EQ(kinds(found), Kinds{});
        EXPECT_EQ(found.orientation, Orientation::outward);
        EXPECT_NEAR(found.signed_volume.value(), volume, 1e-6 * volume);
        const auto repair = repair_mesh(draft.mesh());
        ASSERT_TRUE(repair);
        EXPECT_EQ(repair->step(RepairStepKind::turn_outward).count, 0U);

        for (TriangleCorners& corners : draft.triangles) std::swap(corners[1], corners[2]);
        EXPECT_EQ(report(draft).orientation, Orientation::inward);
        EXPECT_NEAR(report(draft).signed_volume.value(), -volume, 1e-6 * volume);
    }
}

// Rounding alone gives such a part a volume.
TEST(MeshReport, KnowsNoSideOfFlatParts)
{
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> any(-1, 1);
        const double x = any(random), y = any(random), z = any(random), w = any(random);
        const Eigen::Matrix3d turn = Eigen::Quaterniond(w, x, y, z).normalized().matrix();
        Draft draft = Draft().add(make_icosphere(2));
        for (Vec3& position : draft.positions)
            position = turn * Vec3(position.x(), position.y(), 0);
        const MeshReport found = report(draft);
        EXPECT_EQ(found.find(FindingKind::inward_components), nullptr);
        EXPECT_EQ(found.orientation, Orientation::undefined);
        EXPECT_NEAR(found.signed_volume.value(), 0, 1e-14);
        const auto repair = repair_mesh(draft.mesh(), {.weld = false});
        ASSERT_TRUE(repair);
        EXPECT_EQ(repair->step(RepairStepKind::turn_outward).count, 0U);
    }
}

TEST(MeshReport, KnowsSidesOfPartsBesideMuchLargerOnes)
{
    for (const double size : {1e-30, 1e-90, 1e-200, 1e-300}) {
        const auto beside_a_cube = [&](Draft small) {
            for (Vec3& p : small.positions) p *= size;
            return report(small.add(make_cube(), Vec3(5, 0, 0)));
        };
        Draft inward = cube_draft();
        for (TriangleCorners& corners : inward.triangles) std::swap(corners[0], corners[1]);
        EXPECT_EQ(beside_a_cube(cube_draft()).orientation, Orientation::outward) << size;
        EXPECT_EQ(beside_a_cube(inward).orientation, Orientation::mixed) << size;
        EXPECT_DOUBLE_EQ(beside_a_cube(inward).signed_volume.value(), 8) << size;
        // Flat ones, whose volume is mere rounding.
        for (unsigned seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(seed);
            std::mt19937 random(seed);
            std::uniform_real_distribution<double> coordinate(-1, 1);
            const auto vector = [&] {
                return Vec3(coordinate(random), coordinate(random), coordinate(random));
            };
            const Vec3 at = vector();
            const Vec3 u = vector();
            const Vec3 v = vector();
            Draft flat;
            flat.positions = {at, at + u, at + v, at + u + v};
            flat.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 2, 1}, {1, 2, 3}};
            EXPECT_EQ(beside_a_cube(flat).orientation, Orientation::undefined) << size;
        }
    }
}

TEST(MeshReport, DescribesAnEmptyMesh)
{
    const MeshReport found = report(TriangleMesh());
    EXPECT_EQ(kinds(found), Kinds{FindingKind::no_triangles});
    EXPECT_EQ(found.findings[0].severity, Severity::error);
    EXPECT_TRUE(found.bounds.empty());
    EXPECT_FALSE(found.closed);
    EXPECT_EQ(found.orientation, Orientation::undefined);
    EXPECT_EQ(found.min_edge_length, 0.0);
    for (const QueryOutlook& query : found.outlook) EXPECT_EQ(query.outlook, Outlook::refused);

    Draft points;
    points.positions = {Vec3(1, 2, 3)};
    EXPECT_EQ(kinds(report(points)),
              (Kinds{FindingKind::no_triangles, FindingKind::unreferenced_vertices}));
}

TEST(MeshReport, FindsNonFinitePositions)
{
    for (const double bad : {nan_value, std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()}) {
        Draft draft = cube_draft();
        draft.positions[3].y() = bad;
        draft.positions[5].z() = bad;
        const MeshReport found = report(draft);
        EXPECT_EQ(kinds(found), Kinds{FindingKind::non_finite_positions});
        EXPECT_EQ(found.findings[0].count, 2U);
        EXPECT_EQ(found.findings[0].first_ids, (Ids{3, 5}));
        EXPECT_EQ(found.findings[0].severity, Severity::error);
        EXPECT_EQ(found.findings[0].element, ElementKind::vertex);
        EXPECT_TRUE(found.closed);
        EXPECT_FALSE(found.signed_volume);
        EXPECT_EQ(found.orientation, Orientation::undefined);
        EXPECT_TRUE(std::isfinite(found.area));
        EXPECT_TRUE(std::isfinite(found.max_edge_length));
        EXPECT_TRUE(found.bounds.lower.allFinite() && found.bounds.upper.allFinite());
        EXPECT_EQ(outlook(found, QueryKind::octree), Outlook::refused);
    }
    Draft unused = cube_draft();
    unused.positions.emplace_back(nan_value, 0, 0);
    const MeshReport found = report(unused);
    EXPECT_EQ(kinds(found),
              (Kinds{FindingKind::non_finite_positions, FindingKind::unreferenced_vertices}));
    EXPECT_EQ(found.findings[0].severity, Severity::note);
    EXPECT_EQ(outlook(found, QueryKind::octree), Outlook::works);
    unused.positions[3].y() = nan_value; // in use, before the one that is not
    const MeshReport both = report(unused);
    EXPECT_EQ(both.findings[0].severity, Severity::error);
    EXPECT_EQ(outlook(both, QueryKind::octree), Outlook::refused);
}

TEST(MeshReport, FindsExtremeScale)
{
    for (const double scale : {1e-120, 1e120, 1e-308, 1e307}) {
        const MeshReport found = report(Draft().add(make_cube(), Vec3::Zero(), scale));
        EXPECT_EQ(kinds(found), Kinds{FindingKind::extreme_scale}) << scale;
        // Octrees are refused beyond 1e100 (BuildOctree.RefusesWhatTheReportSays).
        const Outlook of_octree = scale > 1 ? Outlook::refused : Outlook::with_care;
        EXPECT_EQ(outlook(found, QueryKind::octree), of_octree);
        EXPECT_EQ(outlook(found, QueryKind::cell_classes), of_octree);
        for (const QueryKind query : {QueryKind::closest_feature, QueryKind::sign, QueryKind::rays,
                                      QueryKind::intersection})
            EXPECT_EQ(outlook(found, query), Outlook::with_care);
        EXPECT_TRUE(found.closed);
        EXPECT_EQ(found.orientation, Orientation::outward);
    }
    for (const double scale : {1e-30, 1e30, 1e-99, 1e99}) {
        EXPECT_EQ(kinds(report(Draft().add(make_cube(), Vec3::Zero(), scale))), Kinds{}) << scale;
    }
}

TEST(MeshReport, MeasuresMeshesOfAnySize)
{
    for (const double size : {1e-150, 1e-90, 1e-85, 1e80, 1e99, 1e150}) {
        const MeshReport found = report(Draft().add(make_cube(), Vec3::Zero(), size));
        EXPECT_NEAR(found.area / size / size, 24, 1e-9) << size;
    }
    for (const double size : {1e-300, 1e-170, 1e200, 1e300}) {
        const MeshReport found = report(Draft().add(make_cube(), Vec3::Zero(), size));
        EXPECT_NEAR(found.min_edge_length / size, 2, 1e-9) << size;
        EXPECT_NEAR(found.max_edge_length / size, std::sqrt(8.0), 1e-9) << size;
    }
}

TEST(MeshReport, CountsDigitsOfWhatIsAsThinAsCanBe)
{
    for (const auto& [reach, extent] : {std::pair(1.0, 5e-324), std::pair(1e300, 1e-10)}) {
        const MeshReport found = report(*make_triangle_mesh(
            {{reach, 0, 0}, {reach, extent, 0}, {reach, 0, extent}}, {{0, 1, 2}}));
        const MeshFinding* const far = found.find(FindingKind::far_from_origin);
        ASSERT_NE(far, nullptr);
        EXPECT_NE(far->meaning.find("about 0 of double's"), std::string::npos) << far->meaning;
    }
}

TEST(MeshReport, FindsMeshesFarFromTheOrigin)
{
    const MeshReport found = report(Draft().add(make_cube(), Vec3(0, 1e9, 0)));
    EXPECT_EQ(kinds(found), Kinds{FindingKind::far_from_origin});
    EXPECT_NE(found.findings[0].meaning.find("about 7 of double's 16 digits"), std::string::npos)
        << found.findings[0].meaning;
    EXPECT_EQ(found.orientation, Orientation::outward);
    EXPECT_DOUBLE_EQ(found.signed_volume.value(), 8.0);
    EXPECT_EQ(kinds(report(Draft().add(make_cube(), Vec3(0, 1.9e6, 0)))), Kinds{});
    EXPECT_EQ(kinds(report(Draft().add(make_cube(), Vec3(0, -2e6, 0)))),
              Kinds{FindingKind::far_from_origin});
}

TEST(MeshReport, FindsUnreferencedVertices)
{
    Draft draft = cube_draft();
    draft.positions.emplace_back(50, 0, 0);
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found), Kinds{FindingKind::unreferenced_vertices});
    EXPECT_EQ(found.findings[0].first_ids, Ids{8});
    EXPECT_EQ(found.findings[0].first_positions.at(0), Vec3(50, 0, 0));
    EXPECT_EQ(found.findings[0].severity, Severity::note);
    EXPECT_EQ(found.bounds.upper, Vec3(1, 1, 1));
    EXPECT_EQ(found.euler_characteristic, 2);
}

TEST(MeshReport, FindsDuplicateVerticesAndTheirSeams)
{
    Draft draft = cube_draft();
    // The last triangle (1, 7, 5) with copies of its corners, one of them with a negative zero.
    draft.positions.insert(draft.positions.end(),
                           {draft.positions[1], draft.positions[7], draft.positions[5]});
    draft.triangles.back() = {8, 9, 10};
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found), (Kinds{FindingKind::duplicate_vertices, FindingKind::boundary_edges}));
    EXPECT_EQ(found.findings[0].first_ids, (Ids{8, 9, 10}));
    EXPECT_EQ(found.find(FindingKind::boundary_edges)->count, 6U);
    EXPECT_EQ(found.boundary_loops, 2U);
    EXPECT_EQ(found.components, 2U);
    EXPECT_FALSE(found.closed);
    EXPECT_EQ(found.closed_if_welded, true);
    EXPECT_EQ(outlook(found, QueryKind::closest_feature), Outlook::with_care);

    draft.triangles.pop_back();
    EXPECT_EQ(report(draft).closed_if_welded, false);
}

TEST(MeshReport, TreatsNegativeZeroAsZero)
{
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.0, 0, -0.0)};
    draft.triangles = {{0, 1, 2}, {3, 2, 1}};
    const MeshReport found = report(draft);
    ASSERT_NE(found.find(FindingKind::duplicate_vertices), nullptr);
    ASSERT_NE(found.find(FindingKind::coincident_triangles), nullptr);
    EXPECT_EQ(found.closed_if_welded, true);
}

TEST(MeshReport, FindsDegenerateTriangles)
{
    Draft draft = cube_draft();
    draft.triangles.push_back({0, 3, 0}); // on an edge of the cube
    draft.triangles.push_back({2, 2, 2});
    draft.triangles.push_back({0, 7, 7}); // an edge of its own, through the middle
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found), Kinds{FindingKind::degenerate_triangles});
    EXPECT_EQ(found.findings[0].first_ids, (Ids{12, 13, 14}));
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& [a, b, c] = draft.triangles[12 + i];
        const Vec3 middle = (draft.positions[a] + draft.positions[b] + draft.positions[c]) / 3;
        EXPECT_LT((found.findings[0].first_positions.at(i) - middle).norm(), 1e-15) << i;
    }
    EXPECT_EQ(found.edges, 19U);
    EXPECT_TRUE(found.closed);
    EXPECT_EQ(found.components, 1U);
    EXPECT_EQ(found.genus, 0);
    EXPECT_EQ(outlook(found, QueryKind::rays), Outlook::with_care);

    Draft nothing_else;
    nothing_else.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
    nothing_else.triangles = {{0, 1, 1}};
    const MeshReport flat = report(nothing_else);
    EXPECT_FALSE(flat.closed);
    EXPECT_EQ(flat.components, 0U);
}

TEST(MeshReport, DecidesZeroAreaExactly)
{
    // A third corner exactly on the line, and one unit in the last place beside it.
    const double step = std::nextafter(0.3, 1.0);
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(0.3, 0.3, 0.3), Vec3(0.3, 0.3, step)};
    draft.triangles = {{0, 1, 2}, {0, 1, 3}};
    const MeshReport found = report(draft);
    const MeshFinding* finding = found.find(FindingKind::zero_area_triangles);
    ASSERT_NE(finding, nullptr);
    EXPECT_EQ(finding->first_ids, Ids{0});
    EXPECT_EQ(outlook(found, QueryKind::rays), Outlook::with_care);
    EXPECT_EQ(found.find(FindingKind::degenerate_triangles), nullptr);
}

TEST(MeshReport, FindsDuplicateAndCoincidentTriangles)
{
    Draft duplicate = cube_draft();
    duplicate.triangles.push_back({3, 0, 2}); // (0, 2, 3) again, turned on
    duplicate.triangles.push_back({2, 0, 3}); // and the other way round
    const MeshReport found = report(duplicate);
    EXPECT_EQ(found.find(FindingKind::duplicate_triangles)->first_ids, (Ids{12, 13}));
    EXPECT_EQ(outlook(found, QueryKind::cell_classes), Outlook::works); // they cancel out
    EXPECT_EQ(found.find(FindingKind::coincident_triangles), nullptr);
    EXPECT_EQ(found.find(FindingKind::non_manifold_edges)->count, 3U);

    const MeshReport twice = report(Draft().add(make_cube()).add(make_cube()));
    EXPECT_EQ(kinds(twice),
              (Kinds{FindingKind::duplicate_vertices, FindingKind::coincident_triangles}));
    EXPECT_EQ(twice.find(FindingKind::coincident_triangles)->count, 12U);
    EXPECT_EQ(twice.find(FindingKind::coincident_triangles)->first_ids, (Ids{12, 13, 14, 15, 16}));
    EXPECT_EQ(outlook(twice, QueryKind::sign), Outlook::with_care);
    EXPECT_EQ(outlook(twice, QueryKind::cell_classes), Outlook::with_care);

    Draft same_ids = cube_draft();
    for (std::size_t i = 0; i < 12; ++i) same_ids.triangles.push_back(same_ids.triangles[i]);
    EXPECT_EQ(outlook(report(same_ids), QueryKind::cell_classes), Outlook::with_care);
    // Two tetrahedra with a wall between them, of vertices of their own and in common.
    Draft beside;
    beside.positions = {Vec3(0, 0, 1),  Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
                        Vec3(0, 0, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    beside.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2},
                        {4, 6, 5}, {4, 7, 6}, {4, 5, 7}, {5, 6, 7}};
    for (const TriangleMesh& mesh : {*weld_vertices(beside.mesh()), beside.mesh()}) {
        const MeshReport wall = report(mesh);
        EXPECT_TRUE(wall.closed && wall.consistently_oriented);
        EXPECT_EQ(outlook(wall, QueryKind::cell_classes), Outlook::works);
    }

    // Within a solid a part that faces outward once and inward three times.
    Draft within = cube_draft();
    for (int i = 0; i < 4; ++i) within.add(make_cube(), Vec3::Zero(), 0.1);
    for (std::size_t i = 24; i < 60; ++i) std::swap(within.triangles[i][1], within.triangles[i][2]);
    const MeshReport inward = report(*weld_vertices(within.mesh()));
    EXPECT_TRUE(inward.closed && inward.consistently_oriented);
    EXPECT_EQ(outlook(inward, QueryKind::cell_classes), Outlook::with_care);

    Draft no_area = cube_draft();
    no_area.positions.push_back(no_area.positions[0]);
    no_area.triangles.push_back({0, 8, 1});
    no_area.triangles.push_back({1, 8, 0});
    EXPECT_EQ(outlook(report(no_area), QueryKind::cell_classes), Outlook::works);
}

TEST(MeshReport, ListsAsManyElementsAsRequested)
{
    Draft draft = cube_draft();
    for (int k = 0; k < 9; ++k) draft.positions.emplace_back(k, 5, 5);
    const auto two = report_mesh(draft.mesh(), {.max_ids = 2});
    EXPECT_EQ(two->findings[0].count, 9U);
    EXPECT_EQ(two->findings[0].first_ids, (Ids{8, 9}));
    EXPECT_EQ(two->findings[0].first_positions.size(), 2U);
    const auto none = report_mesh(draft.mesh(), {.max_ids = 0});
    EXPECT_EQ(none->findings[0].count, 9U);
    EXPECT_TRUE(none->findings[0].first_ids.empty());
}

TEST(MeshReport, EveryFindingHasAMeaningAndEveryNameIsItsOwn)
{
    std::vector<std::string_view> names;
    for (int kind = 0; kind <= static_cast<int>(FindingKind::inward_components); ++kind) {
        names.push_back(name_of(static_cast<FindingKind>(kind)));
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
    EXPECT_EQ(name_of(FindingKind::boundary_edges), "boundary_edges");
    EXPECT_EQ(name_of(FindingKind::inward_components), "inward_components");
    EXPECT_EQ(name_of(Severity::error), "error");
    EXPECT_EQ(name_of(ElementKind::component), "component");
    EXPECT_EQ(name_of(QueryKind::intersection), "intersection");
    EXPECT_EQ(name_of(Outlook::with_care), "with_care");
    EXPECT_EQ(name_of(Orientation::mixed), "mixed");

    Draft draft = cube_draft(); // one of nearly every kind
    draft.positions.emplace_back(nan_value, 0, 0);
    draft.positions.emplace_back(-1, -1, -1);
    draft.positions.emplace_back(0, -1, -1);
    draft.triangles.insert(draft.triangles.end(),
                           {{0, 0, 1}, {0, 1, 10}, {0, 2, 3}, {9, 2, 3}, {3, 5, 8}});
    const MeshReport found = report(draft);
    EXPECT_GE(found.findings.size(), 7U);
    for (const MeshFinding& finding : found.findings) {
        EXPECT_FALSE(finding.meaning.empty()) << name_of(finding.kind);
        EXPECT_GT(finding.count, 0U);
    }
}

TEST(MeshReport, HasNoOrientationWithAFlatPart)
{
    Draft draft = cube_draft();
    const Vec3 at(9, 0, 0);
    draft.positions.insert(draft.positions.end(),
                           {at, at + Vec3(1, 0, 0), at + Vec3(0, 1, 0), at + Vec3(1, 1, 0)});
    draft.triangles.insert(draft.triangles.end(),
                           {{8, 9, 10}, {9, 11, 10}, {8, 11, 9}, {8, 10, 11}});
    const MeshReport found = report(draft);
    EXPECT_TRUE(found.closed);
    EXPECT_EQ(found.orientation, Orientation::undefined);
    EXPECT_EQ(outlook(found, QueryKind::sign), Outlook::with_care);
}

TEST(MeshReport, AsksAboutWeldingOnlyWhereThereAreDuplicates)
{
    Draft open = cube_draft();
    open.triangles.pop_back();
    EXPECT_FALSE(report(open).closed_if_welded.has_value());
}

TEST(MeshReport, StopsOnRequestAndRespectsItsBudget)
{
    Progress whole;
    ASSERT_TRUE(report_mesh(make_cube(), {.execution = {.progress = &whole}}));
    EXPECT_EQ(whole.fraction(), 1);
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(report_mesh(make_cube(), {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
    const TriangleMesh cube = make_cube();
    const auto topology = build_topology(cube);
    EXPECT_EQ(code_of(report_mesh(cube, *topology, {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
    EXPECT_EQ(code_of(report_mesh(cube, *topology, {.execution = {.budget = {topology->bytes()}}})),
              ErrorCode::budget_exceeded);
    EXPECT_EQ(code_of(report_mesh(cube, {.execution = {.budget = {10}}})),
              ErrorCode::budget_exceeded);
}

} // namespace
} // namespace proxima::mesh_report_test
