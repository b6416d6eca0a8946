#include "partition_workload.h"

#include "proxima/mesh_io.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <utility>

namespace proxima::bench {
namespace {

/// A mesh whose vertices lie on the grid of the root [0, 2^14]^3.
Result<TriangleMesh> on_grid(const TriangleMesh& mesh)
{
    Box box;
    for (const Vec3& position : mesh.positions()) box.extend(position);
    const double edge = std::ldexp(1.0, workload_grid_bits);
    const double scale = edge / box.extent().maxCoeff();
    std::vector<Vec3> positions;
    for (const Vec3& position : mesh.positions()) {
        const Vec3 placed = scale * (position - box.center()) + Vec3::Constant(edge / 2);
        positions.emplace_back(placed.array().round().max(0).min(edge).matrix());
    }
    return make_triangle_mesh(std::move(positions),
                              {mesh.triangles().begin(), mesh.triangles().end()});
}

WholePoint whole(const Vec3& point)
{
    return {std::llround(point.x()), std::llround(point.y()), std::llround(point.z())};
}

} // namespace

PartitionWorkload partition_workload(const std::string& name, const std::string& mesh_name,
                                     int max_depth, std::size_t threshold, std::size_t every_nth)
{
    PartitionWorkload load{name, {}, 0};
    auto given = is_sample_mesh_name(mesh_name) ? sample_mesh(mesh_name) : read_mesh(mesh_name);
    if (!given) {
        std::fprintf(stderr, "%s: %s\n", name.c_str(), describe(given.error()).c_str());
        return load;
    }
    const auto mesh = on_grid(*given);
    const double edge = std::ldexp(1.0, workload_grid_bits);
    OctreeOptions options{.max_depth = max_depth,
                          .threshold = static_cast<std::uint32_t>(threshold),
                          .root = OctreeFrame{Vec3::Zero(), Vec3::Constant(edge)},
                          .classification = Classification::none};
    const auto octree = build_octree(*mesh, options);
    if (!octree) {
        std::fprintf(stderr, "%s: %s\n", name.c_str(), describe(octree.error()).c_str());
        return load;
    }

    // A split cell is touched by the triangles of the leaves below it.
    std::map<std::pair<std::uint32_t, int>, std::vector<WholePoint>> cells;
    const std::function<std::vector<std::uint32_t>(const Cell&)> collect = [&](const Cell& cell) {
        std::vector<std::uint32_t> touching;
        if (octree->is_leaf(cell)) {
            for (const TriangleId id : octree->triangles(cell)) {
                if (to_index(id) % every_nth == 0) touching.push_back(to_index(id));
            }
            return touching;
        }
        for (int octant = 0; octant < 8; ++octant) {
            const auto below = collect(octree->child(cell, octant));
            touching.insert(touching.end(), below.begin(), below.end());
        }
        std::sort(touching.begin(), touching.end());
        touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
        const WholePoint lower = whole(cell_box(octree->frame(), cell.key).lower);
        for (const std::uint32_t id : touching) cells[{id, depth(cell.key)}].push_back(lower);
        return touching;
    };
    static_cast<void>(collect(octree->root()));

    for (auto& [key, lower_corners] : cells) {
        WorkloadGroup group;
        const auto& corners = mesh->triangles()[key.first];
        for (std::size_t j = 0; j < 3; ++j)
            group.triangle[j] = whole(mesh->positions()[corners[j]]);
        group.child_half = std::int64_t{1} << (workload_grid_bits - key.second - 2);
        load.pairs += lower_corners.size();
        group.cells = std::move(lower_corners);
        load.groups.push_back(std::move(group));
    }
    return load;
}

} // namespace proxima::bench
