// Limits that are cheap to reach: the number itself is accepted, the next one refused in words.
#include "base/binary_file.h"
#include "base/output_file.h"
#include "base/text.h"
#include "folder_test.h"
#include "mesh/io/gltf_demand.h"
#include "mesh/io/mesh_assembler.h"
#include "mesh/mesh_files.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_repair.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace proxima::limits_test {
namespace {

class Limits : public FolderTest {};

template <class T>
Status status_of(const Result<T>& result)
{
    return result ? Status() : tl::unexpected(result.error());
}

void expect_limit(const char* name, const Status& at_limit, const Status& beyond,
                  const std::string& why)
{
    SCOPED_TRACE(name);
    EXPECT_TRUE(at_limit) << describe(at_limit.error());
    ASSERT_FALSE(beyond);
    EXPECT_NE(describe(beyond.error()).find(why), std::string::npos) << describe(beyond.error());
}

double next_above(double value)
{
    return std::nextafter(value, std::numeric_limits<double>::infinity());
}

TEST_F(Limits, OfFiles)
{
    // A polygon of many corners, all on a circle.
    const auto polygon = [](std::size_t corners) {
        std::string text;
        for (std::size_t i = 0; i < corners; ++i) {
            const double angle =
                2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
            text += concat("v ", std::cos(angle), ' ', std::sin(angle), " 0\n");
        }
        text += 'f';
        for (std::size_t i = 1; i <= corners; ++i) text += concat(' ', i);
        return status_of(read_text(text + '\n', MeshFormat::obj));
    };
    expect_limit("corners of a face", polygon(detail::max_face_corners),
                 polygon(detail::max_face_corners + 1), "corners");

    const auto nodes = [](int depth) {
        std::string text =
            R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)";
        for (int i = 0; i < depth; ++i)
            text += i + 1 < depth ? concat("{\"children\":[", i + 1, "]},") : "{}";
        text += "]}";
        return status_of(detail::check_gltf_demand({"scene", text}, text, {.bytes = 100'000'000}));
    };
    if (reads_scenes)
        expect_limit("depth of nodes", nodes(1000), nodes(1001), "deep in each other");

    const FileFormat format{{'l', 'i', 'm', 'i', 't', 's', ' ', ' '}, 1, "file of a test"};
    const auto sections = [&](std::uint32_t count) -> Status {
        std::vector<BinarySection> list;
        for (std::uint32_t i = 0; i < count; ++i) list.push_back({i + 1, 1, {}});
        if (Status written = write_binary_file(path("sections"), format, list); !written)
            return written;
        return status_of(BinaryFile::open(path("sections"), format, {}));
    };
    expect_limit("sections", sections(256), sections(257), "too many sections");

    const auto links = [&](int count) -> Status {
        const std::filesystem::path place = path(concat("links", count));
        std::filesystem::create_directory(place);
        for (int i = 0; i < count; ++i)
            std::filesystem::create_symlink(concat(i + 1), place / concat(i));
        auto file = OutputFile::create(place / "0");
        if (!file) return tl::unexpected(file.error());
        if (Status written = file->write("text"); !written) return written;
        return file->commit();
    };
    expect_limit("links to a file", links(40), links(41), "links41");
}

TEST_F(Limits, OfBuilders)
{
    const TriangleMesh cube = *sample_mesh("cube");
    const MeshIndex index = *build_mesh_index(cube);
    const auto octree = [&](int depth) {
        return status_of(build_octree(cube, {.max_depth = depth, .threshold = 100}));
    };
    expect_limit("depth of octrees", octree(max_octree_depth), octree(max_octree_depth + 1),
                 "maximum depth");
    expect_limit("least depth of octrees", octree(0), octree(-1), "maximum depth");
    const auto lists = [&](const ListOptions& options) {
        return status_of(with_lists(index, options));
    };
    expect_limit("depth of lists", lists({.max_depth = max_list_depth}),
                 lists({.max_depth = max_list_depth + 1}), "depth");
    expect_limit("margin of lists", lists({.margin = max_list_margin}),
                 lists({.margin = next_above(max_list_margin)}), "margin");
    const TriangleMesh triangle = *make_triangle_mesh(
        {Vec3(1e100, 0, 0), Vec3(0, 1e100, 0), Vec3(0, 0, -1e100)}, {{0, 1, 2}});
    const TriangleMesh larger = *make_triangle_mesh(
        {Vec3(next_above(1e100), 0, 0), Vec3(0, 1e100, 0), Vec3(0, 0, -1e100)}, {{0, 1, 2}});
    expect_limit("coordinates of octrees", status_of(build_octree(triangle)),
                 status_of(build_octree(larger)), "1e100");
    const auto hull = [](double x) {
        const std::vector<Vec3> points = {Vec3(0, 0, 0), Vec3(-x, 0, 0)};
        return status_of(convex_hull(points));
    };
    expect_limit("coordinates of polyhedra", hull(max_polyhedron_coordinate),
                 hull(next_above(max_polyhedron_coordinate)), "2^300");
    const auto weld = [&](double distance) {
        return status_of(repair_mesh(cube, {.weld_distance = distance}));
    };
    expect_limit("distance of welding", weld(1e300), weld(next_above(1e300)), "weld");
    expect_limit("least distance of welding", weld(0), weld(-std::numeric_limits<double>::min()),
                 "weld");
}

TEST_F(Limits, OfScenes)
{
    const TouchBody cube = *build_touch_body(*sample_mesh("cube"));
    TouchScene scene({Vec3::Constant(-100), Vec3::Constant(100)});
    Status at_limit;
    for (std::size_t i = 0; i < max_scene_objects && at_limit; ++i) {
        at_limit =
            status_of(scene.add(cube, {Mat3::Identity(), Vec3(static_cast<double>(i), 0, 0)}));
    }
    expect_limit("objects", at_limit, status_of(scene.add(cube, {})), "64");
    std::vector<HapticRenderer> tools;
    const auto add_tool = [&]() -> Status {
        auto tool = make_haptic_renderer(scene, {20, Vec3(0, 0, 9)}, *find_device("omni"));
        if (!tool) return tl::unexpected(tool.error());
        tools.push_back(std::move(*tool));
        return {};
    };
    for (std::size_t i = 0; i < max_scene_tools && at_limit; ++i) at_limit = add_tool();
    expect_limit("tools", at_limit, add_tool(), "8");
}

} // namespace
} // namespace proxima::limits_test
