// What the readers make of points and lines where they are asked for.
#include "code_of.h"
#include "mesh/mesh_files.h"

namespace proxima::points_and_lines_test {
namespace {

using Corners = std::vector<TriangleCorners>;

constexpr ReadOptions with_lines{.primitives = Primitives::points_and_lines};

Corners corners_of(const Result<TriangleMesh>& mesh)
{
    EXPECT_TRUE(mesh) << describe(mesh.error());
    if (!mesh) return {};
    return {mesh->triangles().begin(), mesh->triangles().end()};
}

TEST(PointsAndLines, XyzHasAPointOnEachLine)
{
    const auto mesh = read_text(
        "# a scan\n0 0 0\n\n1.5\t2 -3 0.1 0.2 255 # with a normal\n 1e3 5 6", MeshFormat::xyz);
    EXPECT_EQ(corners_of(mesh), (Corners{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}));
    EXPECT_EQ(mesh->position(VertexId{1}), Vec3(1.5, 2, -3));
    EXPECT_EQ(mesh->position(VertexId{2}), Vec3(1000, 5, 6));
    const auto welded =
        read_text("0 0 0\n1 0 0\n0 0 0\n", MeshFormat::xyz, {.weld = Weld::exact_positions});
    EXPECT_EQ(corners_of(welded), (Corners{{0, 0, 0}, {1, 1, 1}, {0, 0, 0}}));
    EXPECT_EQ(welded->vertex_count(), 2U);
}

TEST(PointsAndLines, XyzRefusesWhatIsNoPoint)
{
    for (const auto& [text, where, message] : {std::tuple("0 0 0\n1 2\n", ":2", "2 numbers"),
                                               {"0 0 0\n1\n", ":2", "1 number:"},
                                               {"3\na comment\nC 0 0 0\n", ":1", "1 number:"},
                                               {"C 0 0 0\n", ":1", "not a number"},
                                               {"0 0 0 red\n", ":1", "not a number"},
                                               {"0,0,0\n", ":1", "not a number"}}) {
        const Error error = error_of(text, MeshFormat::xyz);
        EXPECT_EQ(error.code, ErrorCode::malformed_file) << text;
        EXPECT_NE(error.where.find(where), std::string::npos) << text << error.where;
        EXPECT_NE(error.message.find(message), std::string::npos) << text << error.message;
    }
}

TEST(PointsAndLines, ObjStatementsKeepTheirOrder)
{
    const std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\n"
                             "l 1 2/7 3\np 4 -1\nf 1/1 2/2 3/3\nl 1/1 4/2\n";
    EXPECT_EQ(corners_of(read_text(text, MeshFormat::obj)), (Corners{{0, 1, 2}}));
    EXPECT_EQ(corners_of(read_text(text, MeshFormat::obj, with_lines)),
              (Corners{{0, 1, 1}, {1, 2, 2}, {3, 3, 3}, {3, 3, 3}, {0, 1, 2}, {0, 3, 3}}));
}

TEST(PointsAndLines, PlyEdgesAreSegments)
{
    const std::string text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                             "property float y\nproperty float z\nelement edge 2\n"
                             "property uchar red\nproperty int vertex2\nproperty int vertex1\n"
                             "end_header\n0 0 0\n1 0 0\n0 2 0\n255 1 0\n0 2 1\n";
    EXPECT_EQ(corners_of(read_text(text, MeshFormat::ply)), Corners{});
    EXPECT_EQ(corners_of(read_text(text, MeshFormat::ply, with_lines)),
              (Corners{{0, 1, 1}, {1, 2, 2}}));
}

TEST(PointsAndLines, OffFacesOfOneAndTwoCorners)
{
    const std::string text = "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n1 2\n2 0 1\n3 0 1 2 # a face\n";
    EXPECT_NE(error_of(text, MeshFormat::off).message.find("3 or more"), std::string::npos);
    EXPECT_EQ(corners_of(read_text(text, MeshFormat::off, with_lines)),
              (Corners{{2, 2, 2}, {0, 1, 1}, {0, 1, 2}}));
}

TEST(PointsAndLines, FilesOfVerticesAloneArePoints)
{
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 0\n"
                            "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n";
    const Corners points = {{0, 0, 0}, {1, 1, 1}};
    for (const auto& [text, format] : {std::pair(ply, MeshFormat::ply),
                                       {"v 0 0 0\nv 1 0 0\n", MeshFormat::obj},
                                       {"OFF\n2 0 0\n0 0 0\n1 0 0\n", MeshFormat::off}}) {
        EXPECT_EQ(corners_of(read_text(text, format)), Corners{}) << text;
        EXPECT_EQ(corners_of(read_text(text, format, with_lines)), points) << text;
    }
}

TEST(PointsAndLines, WhatIsWrongIsRefused)
{
    const std::string obj = "v 0 0 0\nv 1 0 0\n";
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                            "property float y\nproperty float z\nelement edge ";
    for (const auto& [text, format, message] :
         {std::tuple(obj + "l 1\n", MeshFormat::obj, "a line has 1 corners"),
          {obj + "l\n", MeshFormat::obj, "a line has 0 corners"},
          {obj + "p\n", MeshFormat::obj, "no vertex"},
          {obj + "p 3\n", MeshFormat::obj, "vertex 3"},
          {obj + "l 1 x\n", MeshFormat::obj, "a line has something that is not an index"},
          {obj + "p 0\n", MeshFormat::obj, "a point uses vertex 0"},
          {ply + "1\nproperty int vertex1\nend_header\n0 0 0\n0\n", MeshFormat::ply,
           "vertex1 and vertex2"},
          {ply +
               "1\nproperty list int int vertex1\nproperty int vertex2\nend_header\n0 0 0\n1 0 0\n",
           MeshFormat::ply, "vertex1 and vertex2"},
          {ply + "1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n0 1\n",
           MeshFormat::ply, "edge 0 uses vertex 1"},
          {ply + "2\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n0 0 \n\n\n",
           MeshFormat::ply, "edge 1 of 2"},
          {"OFF\n1 1 0\n0 0 0\n0\n", MeshFormat::off, "1 or more"}}) {
        const Error error = error_of(text, format, with_lines);
        EXPECT_EQ(error.code, ErrorCode::malformed_file) << text;
        EXPECT_NE(error.message.find(message), std::string::npos) << text << error.message;
    }
}

TEST(PointsAndLines, MemoryIsCheckedBeforeItIsTaken)
{
    std::string text;
    for (int i = 0; i < 2000; ++i) text += "1 2 3\n";
    // 12 kB of text, 48 kB of positions and, while they grow, as many again.
    EXPECT_TRUE(read_text(text, MeshFormat::xyz, {.execution = {.budget = {.bytes = 200'000}}}));
    EXPECT_EQ(error_of(text, MeshFormat::xyz, {.execution = {.budget = {.bytes = 80'000}}}).code,
              ErrorCode::budget_exceeded);
}

TEST(PointsAndLines, MeshesOfPointsAndSegments)
{
    const std::vector<Vec3> positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    EXPECT_EQ(corners_of(mesh_of_points(positions)), (Corners{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}));
    const std::array<std::array<std::uint32_t, 2>, 2> segments = {{{0, 1}, {2, 1}}};
    EXPECT_EQ(corners_of(mesh_of_segments(positions, segments)), (Corners{{0, 1, 1}, {2, 1, 1}}));
    const std::array<std::array<std::uint32_t, 2>, 1> outside = {{{0, 3}}};
    const auto refused = mesh_of_segments(positions, outside);
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::invalid_mesh);
    EXPECT_EQ(refused.error().message, "segment 0 uses point 3: there are only 3 points");
    EXPECT_EQ(corners_of(mesh_of_points({})), Corners{});
}

} // namespace
} // namespace proxima::points_and_lines_test
