// What the report says of edges: holes, fins, and triangles that face the wrong way.
#include "mesh/mesh_drafts.h"
#include "proxima/mesh_report.h"
#include "proxima/topology.h"

#include <cmath>
#include <gtest/gtest.h>

namespace proxima::mesh_report_edges_test {
namespace {

TEST(MeshReport, FindsBoundaryEdgesAndLoops)
{
    Draft draft = cube_draft();
    draft.triangles.erase(draft.triangles.begin() + 2, draft.triangles.begin() + 4); // z = 1
    draft.triangles.erase(draft.triangles.begin()); // half of z = -1
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found), Kinds{FindingKind::boundary_edges});
    EXPECT_EQ(found.findings[0].count, 7U);
    EXPECT_EQ(found.findings[0].element, ElementKind::edge);
    EXPECT_EQ(found.boundary_loops, 2U);
    EXPECT_FALSE(found.closed);
    EXPECT_TRUE(found.consistently_oriented);
    EXPECT_FALSE(found.genus);
    EXPECT_FALSE(found.signed_volume);
    EXPECT_EQ(outlook(found, QueryKind::sign), Outlook::with_care);
    EXPECT_EQ(outlook(found, QueryKind::cell_classes), Outlook::with_care);
    EXPECT_EQ(outlook(found, QueryKind::intersection), Outlook::with_care);
    EXPECT_EQ(outlook(found, QueryKind::octree), Outlook::works);

    const auto topology = build_topology(draft.mesh());
    const EdgeId edge{found.findings[0].first_ids.at(0)};
    EXPECT_EQ(topology->triangles(edge).size(), 1U);
    const auto [low, high] = topology->vertices(edge);
    EXPECT_EQ(found.findings[0].first_positions.at(0),
              0.5 * (draft.positions[to_index(low)] + draft.positions[to_index(high)]));
}

TEST(MeshReport, FindsNonManifoldEdges)
{
    // Two cubes that share the edge from (1, 1, -1) to (1, 1, 1): vertices 3 and 7 of the first.
    Draft draft = cube_draft();
    draft.add(make_cube(), Vec3(2, 2, 0));
    for (TriangleCorners& corners : draft.triangles) {
        for (std::uint32_t& corner : corners) {
            if (corner == 8) corner = 3;
            if (corner == 12) corner = 7;
        }
    }
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found),
              (Kinds{FindingKind::unreferenced_vertices, FindingKind::duplicate_vertices,
                     FindingKind::non_manifold_edges}));
    EXPECT_EQ(found.find(FindingKind::non_manifold_edges)->count, 1U);
    EXPECT_EQ(found.components, 1U);
    EXPECT_TRUE(found.closed);
    EXPECT_TRUE(found.consistently_oriented);
    EXPECT_EQ(found.orientation, Orientation::outward);
    EXPECT_FALSE(found.genus);
    EXPECT_EQ(outlook(found, QueryKind::sign), Outlook::with_care);
    EXPECT_EQ(outlook(found, QueryKind::cell_classes), Outlook::works);
    EXPECT_EQ(outlook(found, QueryKind::intersection), Outlook::with_care);

    Draft flap = cube_draft(); // a third triangle on an edge: neither closed nor without border
    flap.positions.emplace_back(5, 0, 0);
    flap.triangles.push_back({1, 3, 8});
    EXPECT_EQ(kinds(report(flap)),
              (Kinds{FindingKind::boundary_edges, FindingKind::non_manifold_edges}));
}

TEST(MeshReport, FindsNonManifoldVertices)
{
    Draft draft = cube_draft();
    draft.add(make_cube(), Vec3(2, 2, 2));
    draft.positions[8] = Vec3(-9, 0, 0); // no longer used: its triangles take vertex 7 instead
    for (TriangleCorners& corners : draft.triangles) {
        for (std::uint32_t& corner : corners) corner = corner == 8 ? 7 : corner;
    }
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found),
              (Kinds{FindingKind::unreferenced_vertices, FindingKind::non_manifold_vertices}));
    EXPECT_EQ(found.find(FindingKind::non_manifold_vertices)->first_ids, Ids{7});
    EXPECT_EQ(found.components, 2U);
    EXPECT_TRUE(found.closed);
    EXPECT_FALSE(found.genus);
    EXPECT_EQ(outlook(found, QueryKind::sign), Outlook::with_care);
}

TEST(MeshReport, FindsInconsistentEdges)
{
    Draft draft = cube_draft();
    std::swap(draft.triangles[4][0], draft.triangles[4][1]);
    const MeshReport found = report(draft);
    EXPECT_EQ(kinds(found), Kinds{FindingKind::inconsistent_edges});
    EXPECT_EQ(found.findings[0].count, 3U);
    EXPECT_TRUE(found.closed);
    EXPECT_FALSE(found.consistently_oriented);
    EXPECT_EQ(found.orientation, Orientation::undefined);
    EXPECT_FALSE(found.signed_volume);
    EXPECT_EQ(outlook(found, QueryKind::sign), Outlook::with_care);
}

TEST(MeshReport, FindsInwardComponents)
{
    Draft draft = cube_draft();
    for (TriangleCorners& corners : draft.triangles) std::swap(corners[1], corners[2]);
    const MeshReport turned = report(draft);
    EXPECT_EQ(kinds(turned), Kinds{FindingKind::inward_components});
    EXPECT_EQ(turned.findings[0].severity, Severity::warning);
    EXPECT_EQ(turned.findings[0].element, ElementKind::component);
    EXPECT_EQ(turned.orientation, Orientation::inward);
    EXPECT_DOUBLE_EQ(turned.signed_volume.value(), -8.0);
    EXPECT_EQ(outlook(turned, QueryKind::sign), Outlook::with_care);

    // An open surface has no inside to face.
    Draft open = draft;
    open.triangles.erase(open.triangles.begin());
    EXPECT_EQ(kinds(report(open)), Kinds{FindingKind::boundary_edges});

    // The same as the cavity of a larger cube: fine.
    Draft hollow = Draft().add(make_cube(), Vec3::Zero(), 3.0).add(draft.mesh());
    const MeshReport cavity = report(hollow);
    EXPECT_EQ(kinds(cavity), Kinds{FindingKind::inward_components});
    EXPECT_EQ(cavity.findings[0].severity, Severity::note);
    EXPECT_EQ(cavity.findings[0].first_ids, Ids{12});
    EXPECT_EQ(cavity.orientation, Orientation::mixed);
    EXPECT_DOUBLE_EQ(cavity.signed_volume.value(), 208.0);
    EXPECT_EQ(outlook(cavity, QueryKind::sign), Outlook::works);

    // Found beside an open component as well.
    Draft beside = Draft().add(make_cube(), Vec3(9, 0, 0), 3.0).add(draft.mesh());
    beside.triangles.erase(beside.triangles.begin());
    EXPECT_EQ(kinds(report(beside)),
              (Kinds{FindingKind::boundary_edges, FindingKind::inward_components}));
}

TEST(MeshReport, ReportsNoOrientationForATriangleAndItsReverse)
{
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    draft.triangles = {{0, 1, 2}, {0, 2, 1}};
    const MeshReport found = report(draft);
    EXPECT_TRUE(found.closed);
    EXPECT_EQ(found.orientation, Orientation::undefined);
    EXPECT_EQ(kinds(found), Kinds{FindingKind::duplicate_triangles});
}

} // namespace
} // namespace proxima::mesh_report_edges_test
