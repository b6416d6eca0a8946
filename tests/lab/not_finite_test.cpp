// NaN and infinity: every reader takes them as values, every operation refuses them and names the
// vertex, and repair drops the triangles that have them.
#include "base/text.h"
#include "mesh/mesh_files.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_repair.h"
#include "proxima/mesh_report.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "proxima/thesis.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

namespace proxima::not_finite_test {
namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The bytes of numbers, as this machine has them or turned round.
template <class... T>
std::string bytes_of(std::endian order, T... numbers)
{
    std::string all;
    for (std::string bytes :
         {std::string(reinterpret_cast<const char*>(&numbers), sizeof numbers)...}) {
        if (order != std::endian::native) std::ranges::reverse(bytes);
        all += bytes;
    }
    return all;
}

struct NamedFile {
    std::string name;
    MeshFormat format{};
    std::string content;
};

std::string binary_ply(std::endian order, double bad)
{
    const bool little = order == std::endian::little;
    return concat("ply\nformat binary_", little ? "little" : "big",
                  "_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
                  "property double z\nelement face 1\n"
                  "property list uchar int vertex_indices\nend_header\n") +
           bytes_of(order, 0.0, 0.0, 0.0, 1.0, bad, 0.0, 0.0, 1.0, 0.0) + '\3' +
           bytes_of(order, std::int32_t{0}, std::int32_t{1}, std::int32_t{2});
}

/// Files with a triangle, or several, that has this number as a coordinate.
std::vector<NamedFile> files_with(double bad)
{
    const std::string text = concat(bad);
    const std::string points = concat("0 0 0\n1 ", text, " 0\n0 1 0\n");
    const auto number = static_cast<float>(bad);
    std::vector<NamedFile> files = {
        {"OBJ", MeshFormat::obj, concat("v 0 0 0\nv 1 ", text, " 0\nv 0 1 0\nf 1 2 3\n")},
        {"PLY, text", MeshFormat::ply,
         concat("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 1\n"
                "property list uchar int vertex_indices\nend_header\n",
                points, "3 0 1 2\n")},
        {"PLY, little-endian", MeshFormat::ply, binary_ply(std::endian::little, bad)},
        {"PLY, big-endian", MeshFormat::ply, binary_ply(std::endian::big, bad)},
        {"STL, text", MeshFormat::stl,
         concat("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 ", text,
                " 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n")},
        {"STL, binary", MeshFormat::stl,
         std::string(80, ' ') + bytes_of(std::endian::little, std::uint32_t{1}, 0.0F, 0.0F, 1.0F,
                                         0.0F, 0.0F, 0.0F, 1.0F, number, 0.0F, 0.0F, 1.0F, 0.0F,
                                         std::uint16_t{0})},
        {"OFF", MeshFormat::off, concat("OFF\n3 1 0\n", points, "3 0 1 2\n")}};
    if (!reads_scenes) return files;
    // Where the first vertex of these files lies.
    for (const auto& [name, from_end] :
         {std::pair("3ds/tetrahedron.3ds", 88), {"glb/two_tetrahedra.glb", 48}}) {
        const std::vector<SeedFile> seeds = seed_files();
        const SeedFile& seed = *std::ranges::find(seeds, name, &SeedFile::name);
        std::string content = seed.content;
        content.replace(content.size() - static_cast<std::size_t>(from_end), sizeof number,
                        bytes_of(std::endian::little, number));
        files.push_back({seed.name, seed.format, content});
    }
    return files;
}

bool is_used_and_not_finite(const TriangleMesh& mesh)
{
    return std::ranges::any_of(mesh.triangles(), [&](const TriangleCorners& triangle) {
        return std::ranges::any_of(
            triangle, [&](std::uint32_t corner) { return !mesh.positions()[corner].allFinite(); });
    });
}

TEST(NotFinite, IsAValueToEveryReader)
{
    for (const double bad : {nan_value, infinity, -infinity}) {
        for (const NamedFile& file : files_with(bad)) {
            SCOPED_TRACE(file.name);
            const auto mesh = read_text(file.content, file.format);
            ASSERT_TRUE(mesh) << describe(mesh.error());
            EXPECT_TRUE(is_used_and_not_finite(*mesh));
            const auto has_bad = [&](const Vec3& p) {
                return std::isnan(bad) ? p.hasNaN() : (p.array().abs() == infinity).any();
            };
            // Placing the meshes of a scene may make infinity NaN.
            if (file.format < MeshFormat::three_ds) {
                EXPECT_TRUE(std::ranges::any_of(mesh->positions(), has_bad));
            }
        }
    }
}

/// An octahedron of which vertex 3, in use, has `bad` as its z.
TriangleMesh broken_octahedron(double bad)
{
    const TriangleMesh sound = *sample_mesh("octahedron");
    std::vector<Vec3> positions(sound.positions().begin(), sound.positions().end());
    positions.at(3).z() = bad;
    return *make_triangle_mesh(std::move(positions),
                               {sound.triangles().begin(), sound.triangles().end()});
}

struct Operation {
    const char* name;
    std::function<Status(const TriangleMesh&)> run;
};

/// Whether it worked.
template <class T>
Status status_of(const Result<T>& result)
{
    return result ? Status() : tl::unexpected(result.error());
}

TEST(NotFinite, IsRefusedByEveryOperationWithTheVertex)
{
    const TriangleMesh sound = *sample_mesh("octahedron");
    const Topology topology = *build_topology(sound);
    const MeshIndex index = *build_mesh_index(sound);
    const TouchBody body = *build_touch_body(sound);
    const Operation operations[] = {
        {"bounding box", [](const auto& mesh) { return status_of(checked_bounding_box(mesh)); }},
        {"octree", [](const auto& mesh) { return status_of(build_octree(mesh)); }},
        {"octree of two passes",
         [](const auto& mesh) { return status_of(build_octree_two_pass(mesh)); }},
        {"octree by pairs",
         [](const auto& mesh) {
             return status_of(build_octree_by(mesh, {.method = OverlapMethod::pairwise}));
         }},
        {"thesis lists", [](const auto& mesh) { return status_of(build_thesis_proximity(mesh)); }},
        {"index", [](const auto& mesh) { return status_of(build_mesh_index(mesh)); }},
        {"refitted index",
         [&](const auto& mesh) { return status_of(refit_index(index, mesh, topology)); }},
        {"polyhedron", [](const auto& mesh) { return status_of(polyhedron_of_mesh(mesh)); }},
        {"hull", [](const auto& mesh) { return status_of(convex_hull(mesh.positions())); }},
        {"body", [](const auto& mesh) { return status_of(build_touch_body(mesh)); }},
        {"refitted body",
         [&](const auto& mesh) { return status_of(refit_touch_body(body, mesh.positions())); }}};
    for (const Operation& operation : operations) {
        SCOPED_TRACE(operation.name);
        EXPECT_TRUE(operation.run(sound));
        for (const double bad : {nan_value, infinity, -infinity}) {
            const Status status = operation.run(broken_octahedron(bad));
            ASSERT_FALSE(status) << bad;
            const std::string words = describe(status.error());
            EXPECT_NE(words.find("NaN or infinite"), std::string::npos) << words;
            EXPECT_TRUE(words.find("vertex 3") != std::string::npos ||
                        words.find("point 3") != std::string::npos)
                << words;
        }
    }
}

TEST(NotFinite, IsNamedByTheReportAndDroppedByRepair)
{
    const TriangleMesh sound = *sample_mesh("octahedron");
    for (const double bad : {nan_value, infinity, -infinity}) {
        const TriangleMesh broken = broken_octahedron(bad);
        const MeshReport report = *report_mesh(broken);
        const MeshFinding* found = report.find(FindingKind::non_finite_positions);
        ASSERT_NE(found, nullptr);
        EXPECT_EQ(found->severity, Severity::error);
        ASSERT_EQ(found->first_ids.size(), 1U);
        EXPECT_EQ(found->first_ids[0], 3U);

        const MeshRepair repaired = *repair_mesh(broken);
        EXPECT_EQ(repaired.mesh.triangle_count(), 4U); // half of an octahedron's share a vertex
        EXPECT_EQ(repaired.step(RepairStepKind::drop_non_finite).count, 4U);
        EXPECT_TRUE(build_mesh_index(repaired.mesh));
    }
    // A vertex that no triangle uses is no matter.
    std::vector<Vec3> positions(sound.positions().begin(), sound.positions().end());
    positions.emplace_back(nan_value, 0, 0);
    const TriangleMesh unused = *make_triangle_mesh(
        std::move(positions), {sound.triangles().begin(), sound.triangles().end()});
    EXPECT_TRUE(build_octree(unused));
    EXPECT_TRUE(build_mesh_index(unused));
    EXPECT_TRUE(build_touch_body(unused));
    EXPECT_TRUE(polyhedron_of_mesh(unused));
}

} // namespace
} // namespace proxima::not_finite_test
