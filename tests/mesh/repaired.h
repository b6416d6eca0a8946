// Repairs of meshes, and what every one of them must keep.
#pragma once

#include "mesh/mesh_drafts.h"
#include "proxima/mesh_repair.h"

#include <algorithm>
#include <bit>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

namespace proxima::testing {

inline MeshRepair repaired(const TriangleMesh& mesh, const MeshRepairOptions& options = {})
{
    auto repair = repair_mesh(mesh, options);
    EXPECT_TRUE(repair) << describe(repair.error());
    return std::move(*repair);
}

inline std::uint64_t count(const MeshRepair& repair, RepairStepKind kind)
{
    return repair.step(kind).count;
}

/// Bit by bit, NaN too.
inline bool same_mesh(const TriangleMesh& a, const TriangleMesh& b)
{
    const auto same_bits = [](const Vec3& p, const Vec3& q) {
        return std::ranges::equal(p, q, {}, std::bit_cast<std::uint64_t, double>,
                                  std::bit_cast<std::uint64_t, double>);
    };
    return std::ranges::equal(a.positions(), b.positions(), same_bits) &&
           std::ranges::equal(a.triangles(), b.triangles());
}

inline bool same_repair(const MeshRepair& a, const MeshRepair& b)
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
inline void expect_idempotent(const MeshRepair& repair, const MeshRepairOptions& options)
{
    const MeshRepair again = repaired(repair.mesh, options);
    EXPECT_TRUE(same_mesh(again.mesh, repair.mesh));
    for (const RepairStep& step : again.steps) EXPECT_EQ(step.count, 0U) << name_of(step.kind);
    EXPECT_EQ(again.cavities, repair.cavities);
    EXPECT_EQ(again.unorientable_edges, repair.unorientable_edges);
}

/// What the maps say of every triangle and vertex of the result.
inline void expect_maps_right(const TriangleMesh& mesh, const MeshRepair& repair)
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

inline TriangleMesh inside_out(const TriangleMesh& mesh)
{
    std::vector<TriangleCorners> triangles;
    for (const auto& [a, b, c] : mesh.triangles()) triangles.push_back({a, c, b});
    return *make_triangle_mesh({mesh.positions().begin(), mesh.positions().end()}, triangles);
}

/// Solids as they should be: a shell with a cavity, a torus in the cavity, a ball in none.
inline Draft nested_solids()
{
    Draft draft;
    draft.add(make_icosphere(3), Vec3::Zero(), 4.0);
    draft.add(inside_out(make_icosphere(2)), Vec3(0.1, 0.2, 0.3), 2.5);
    draft.add(make_torus(24, 12), Vec3(0.2, 0.1, 0.2), 0.5);
    draft.add(make_sphere(12, 16), Vec3(20, 1, 2));
    draft.add(make_octahedron(), Vec3(-30, 1, 2), 3.0);
    return draft;
}

} // namespace proxima::testing
