#include "proxima/octree_io.h"

#include "base/text.h"
#include "code_of.h"
#include "octree/classify_cells.h"
#include "octree/exported_leaves.h"
#include "octree/slow_builder.h"
#include "octree/small_meshes.h"
#include "proxima/octree.h"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <unistd.h>

namespace proxima::export_test {
namespace {

using namespace testing;

/// As read_exported_leaves.py prints a .htg: the root's box, and leaves in units of 2^-20 of it,
/// for VTK finds their places by its own sums.
std::vector<std::string> expected_grid(const Octree& octree)
{
    const Box root = octree.box(octree.root());
    std::string first = "root";
    for (const Vec3& corner : {root.lower, root.upper}) {
        for (const double coordinate : corner) first += concat(",", hex(coordinate));
    }
    std::vector<std::string> lines = {first};
    const std::function<void(const Cell&)> visit = [&](const Cell& cell) {
        if (!octree.is_leaf(cell)) {
            for (int octant = 0; octant < 8; ++octant) visit(octree.child(cell, octant));
            return;
        }
        const auto up = static_cast<unsigned>(20 - depth(cell.key));
        std::string line;
        for (const std::uint32_t side : {0U, 1U}) {
            for (const std::uint32_t at : cell_coordinates(cell.key)) {
                line += concat((at + side) << up, ",");
            }
        }
        line += concat(static_cast<int>(cell.type), ",", depth(cell.key), ",",
                       octree.triangles(cell).size());
        lines.push_back(line);
    };
    visit(octree.root());
    std::sort(lines.begin(), lines.end());
    return lines;
}

std::vector<std::string> expected_leaves(const Octree& octree, const std::string& format)
{
    if (format == "htg") return expected_grid(octree);
    std::vector<std::string> lines;
    const std::function<void(const Cell&)> visit = [&](const Cell& cell) {
        if (!octree.is_leaf(cell)) {
            for (int octant = 0; octant < 8; ++octant) visit(octree.child(cell, octant));
            return;
        }
        const Box box = octree.box(cell);
        if (format == "glb" && cell.type != CellClass::boundary) return;
        const Vec3 origin = octree.box(octree.root()).center();
        std::string line;
        for (const Vec3& corner : {box.lower, box.upper}) {
            for (int axis = 0; axis < 3; ++axis) {
                const volatile float offset = static_cast<float>(corner[axis] - origin[axis]);
                line += concat(hex(format == "glb" ? offset + origin[axis] : corner[axis]), ",");
            }
        }
        const bool has_depth = format != "glb";
        const bool has_triangles = format == "vtu";
        line += concat(static_cast<int>(cell.type), ",", has_depth ? depth(cell.key) : -1, ",");
        line += has_triangles ? to_text(octree.triangles(cell).size()) : "-1";
        lines.push_back(line);
    };
    visit(octree.root());
    std::sort(lines.begin(), lines.end());
    return lines;
}

class Export : public ::testing::TestWithParam<const char*> {
protected:
    void SetUp() override
    {
        folder = std::filesystem::path(::testing::TempDir()) /
                 ("export_" + std::string(GetParam()) + "_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }
    std::filesystem::path folder;
};

TEST_P(Export, IsReadBackLeafByLeaf)
{
    const std::string format = GetParam();
    const TriangleMesh open =
        without(torus_mesh(1.0, 0.4, 24, 12), [](std::size_t i) { return i < 9; });
    const TriangleMesh far =
        moved(open, [](const Vec3& p) { return Vec3(p + Vec3(1e6, -3e6, 0.1)); });
    struct Case {
        const char* name;
        const TriangleMesh& mesh;
        SlowOctreeOptions options;
        bool classified;
    };
    const OctreeFrame box{Vec3(-1.5, -2, -0.5), Vec3(3, 4, 1)};
    const std::vector<Case> cases = {
        {"one leaf", open, {.max_depth = 0}, true},
        {"adaptive", open, {.max_depth = 5, .threshold = 3}, true},
        {"unclassified", open, {.max_depth = 3}, false},
        {"box", open, {.max_depth = 4, .root = box}, true},
        {"far", far, {.max_depth = 4}, true},
        {"uniform", open, {.max_depth = 3, .subdivision = Subdivision::uniform}, true}};
    std::vector<std::filesystem::path> paths;
    std::vector<std::vector<std::string>> expected;
    for (const Case& test : cases) {
        SCOPED_TRACE(test.name);
        Octree octree = slow_octree(test.mesh, test.options);
        if (test.classified) octree = classify_cells(octree, test.mesh).value();
        paths.push_back(folder / concat(expected.size(), ".", format));
        const Status status = export_octree(octree, test.mesh, paths.back());
        ASSERT_TRUE(status) << describe(status.error());
        expected.push_back(expected_leaves(octree, format));
        if (format == "glb") {
            expected.back().push_back(concat("mesh,", test.mesh.triangle_count()));
        }
    }
    const Output found = read_by_python(paths);
    if (found.status == 77) GTEST_SKIP() << found.last_line;
    ASSERT_EQ(found.status, 0) << found.last_line;
    ASSERT_EQ(found.files.size(), cases.size());
    for (std::size_t i = 0; i < cases.size(); ++i) {
        SCOPED_TRACE(cases[i].name);
        ASSERT_EQ(found.files[i].size(), expected[i].size());
        for (std::size_t line = 0; line < expected[i].size(); ++line) {
            ASSERT_EQ(found.files[i][line], expected[i][line]);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, Export, ::testing::Values("vtu", "htg", "ply", "glb"),
                         [](const auto& format) { return std::string(format.param); });

TEST(ExportErrors, AreReported)
{
    const TriangleMesh mesh = cube_mesh(Vec3::Zero(), 1.0);
    const Octree octree = slow_octree(mesh, {.max_depth = 2});
    EXPECT_EQ(code_of(export_octree(octree, mesh, "octree.obj")), ErrorCode::unsupported_format);
    EXPECT_EQ(code_of(export_octree(octree, mesh, "octree")), ErrorCode::unsupported_format);
    for (const char* format : {"vtu", "htg", "ply", "glb"}) {
        const std::string path = std::string("/nowhere/octree.") + format;
        EXPECT_EQ(code_of(export_octree(octree, mesh, path)), ErrorCode::file_not_writable);
    }
    EXPECT_EQ(code_of(export_vtu(octree, "/dev/full")), ErrorCode::file_not_writable);
    EXPECT_EQ(code_of(export_htg(octree, "/dev/full")), ErrorCode::file_not_writable);
    EXPECT_EQ(code_of(export_ply(octree, "/dev/full")), ErrorCode::file_not_writable);
    EXPECT_EQ(code_of(export_glb(octree, mesh, "/dev/full")), ErrorCode::file_not_writable);
    const TriangleMesh huge = moved(mesh, [](const Vec3& p) { return Vec3(p * 1e60); });
    EXPECT_EQ(code_of(export_glb(slow_octree(huge, {.max_depth = 1}), huge, "/dev/full")),
              ErrorCode::limit_exceeded);
}

} // namespace
} // namespace proxima::export_test
