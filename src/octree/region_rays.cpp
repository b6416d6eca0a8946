#include "octree/region_rays.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"

#include <algorithm>

namespace proxima {

namespace {

constexpr int most_cells_passed = 256;

/// A line along `axis`, from one coordinate to another.
struct AxisSegment {
    Vec3 from = Vec3::Zero();
    double to = 0.0;
    int axis = 0;
};

enum class Crossing : std::uint8_t { none, outwards, inwards, degenerate };

/// How the segment crosses the triangle. Its ends do not lie on it.
Crossing crossing(const AxisSegment& segment, const Triangle& triangle) noexcept
{
    const Vec3& from = segment.from;
    const int axis = segment.axis;
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const auto misses = [&](int k, double low, double high) {
        const double first = triangle[0][k];
        const double second = triangle[1][k];
        const double third = triangle[2][k];
        return std::max({first, second, third}) < low || std::min({first, second, third}) > high;
    };
    if (misses(u, from[u], from[u]) || misses(v, from[v], from[v]) ||
        misses(axis, std::min(from[axis], segment.to), std::max(from[axis], segment.to))) {
        return Crossing::none;
    }
    // Seen along the axis the line is a point: inside where it lies left of all edges, or right.
    const auto flat = [&](const Vec3& point) { return Vec2(point[u], point[v]); };
    int left = 0;
    int right = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const int side =
            orient2d(flat(triangle.vertices[k]), flat(triangle.vertices[(k + 1) % 3]), flat(from));
        if (side > 0) ++left;
        if (side < 0) ++right;
    }
    if (left > 0 && right > 0) return Crossing::none;
    if (left != 3 && right != 3) return Crossing::degenerate;
    Vec3 to = from;
    to[axis] = segment.to;
    const int before = orient3d(triangle[0], triangle[1], triangle[2], from);
    const int after = orient3d(triangle[0], triangle[1], triangle[2], to);
    if (before == 0 || after == 0) return Crossing::degenerate;
    if (before == after) return Crossing::none;
    return after > 0 ? Crossing::outwards : Crossing::inwards;
}

} // namespace

/// A ray under way: it left its last region and has passed some leaves.
struct RegionRays::Ray {
    Vec3 from = Vec3::Zero();
    int axis = 0;
};

RegionRays::RegionRays(const Octree& octree, const TriangleMesh& mesh, const TriangleMesh& caps,
                       const EmptyGroups& groups, const EmptyRegions& regions)
    : octree_(octree), mesh_(mesh), caps_(caps), groups_(groups), regions_(regions)
{}

RegionRays::Location RegionRays::locate(const std::array<std::uint32_t, 3>& at) const noexcept
{
    std::uint32_t record = 0;
    for (int depth = 1;; ++depth) {
        const auto down = static_cast<unsigned>(octree_.parameters().max_depth - depth);
        const std::uint32_t octant =
            (at[0] >> down & 1U) | (at[1] >> down & 1U) << 1U | (at[2] >> down & 1U) << 2U;
        const EmptyGroups::Octants of = groups_.octants(record);
        if ((of.empty >> octant & 1U) != 0) {
            return {true, EmptyGroups::number(of, octant), depth};
        }
        const OctreeNode node = octree_.nodes()[record];
        const std::uint32_t before = node.recorded_mask() & ((1U << octant) - 1);
        record = node.first + count_octants(before);
        if (octree_.nodes()[record].is_leaf()) return {false, record, depth};
    }
}

std::optional<std::int32_t> RegionRays::crossings(const Ray& ray, double end,
                                                  Scratch& scratch) const
{
    const AxisSegment segment{ray.from, end, ray.axis};
    // A triangle of several leaves is tested in each, which costs less than finding repeats, and
    // counted once.
    scratch.crossed.clear();
    for (const std::uint32_t record : scratch.passed) {
        const OctreeNode leaf = octree_.nodes()[record];
        for (const TriangleId id : octree_.references().subspan(leaf.first, leaf.count())) {
            const Crossing found = crossing(segment, mesh_.triangle(id));
            if (found == Crossing::degenerate) return std::nullopt;
            if (found != Crossing::none) {
                scratch.crossed.push_back({id, found == Crossing::outwards ? -1 : 1});
            }
        }
    }
    std::ranges::sort(scratch.crossed, {}, &Scratch::Crossed::id);
    std::int32_t change = 0;
    for (std::size_t i = 0; i < scratch.crossed.size(); ++i) {
        const bool repeats = i > 0 && scratch.crossed[i].id == scratch.crossed[i - 1].id;
        if (!repeats) change += scratch.crossed[i].change;
    }
    for (std::uint32_t i = 0; i < caps_.triangle_count(); ++i) {
        const Crossing found = crossing(segment, caps_.triangle(TriangleId{i}));
        if (found == Crossing::degenerate) return std::nullopt;
        if (found != Crossing::none) change += found == Crossing::outwards ? -1 : 1;
    }
    return change;
}

std::optional<RegionRays::End> RegionRays::cast(std::uint32_t region, int direction,
                                                Scratch& scratch) const
{
    const OctreeFrame& frame = octree_.frame();
    const int deepest = octree_.parameters().max_depth;
    const std::uint32_t last_plane = 1U << static_cast<unsigned>(deepest);
    const auto axis = static_cast<std::size_t>(direction / 2);
    const bool up = direction % 2 != 0;

    // The ray leaves through a point of the first cell's face that lies on no line of symmetry,
    // diagonals included. It lies between two planes of the deepest cells, so that integers tell
    // which cells it passes.
    constexpr std::array<double, 3> parts = {0.381966, 0.276393, 0.447214};
    const CellKey key = regions_.start[region];
    const auto shift = static_cast<unsigned>(deepest - depth(key));
    std::array<std::uint32_t, 3> at = cell_coordinates(key);
    Ray ray;
    ray.axis = static_cast<int>(axis);
    scratch.passed.clear();
    for (std::size_t k = 0; k < 3; ++k) {
        const auto offset = static_cast<std::uint32_t>(parts[k] * static_cast<double>(1U << shift));
        at[k] = (at[k] << shift) + offset;
        const double below = frame.plane(static_cast<int>(k), at[k], deepest);
        const double above = frame.plane(static_cast<int>(k), at[k] + 1, deepest);
        ray.from[static_cast<int>(k)] = std::min(below + parts[k] * (above - below), above);
    }

    for (int passed = 0; passed < most_cells_passed; ++passed) {
        const Location location = locate(at);
        const auto size = 1U << static_cast<unsigned>(deepest - location.depth);
        const std::uint32_t exit = up ? (at[axis] & ~(size - 1)) + size : at[axis] & ~(size - 1);
        const double exit_plane = frame.plane(ray.axis, exit, deepest);
        const std::uint32_t here =
            location.is_empty ? regions_.of_group[location.id] : EmptyRegions::none;
        if (here == region) {
            // A closed empty cell is free of triangles, and so is its face.
            ray.from[ray.axis] = exit_plane;
            scratch.passed.clear();
        } else if (here != EmptyRegions::none) {
            const std::uint32_t entry = up ? exit - size : exit + size;
            const auto change = crossings(ray, frame.plane(ray.axis, entry, deepest), scratch);
            if (!change) return std::nullopt;
            return End{here, *change};
        } else if (!location.is_empty) {
            if (octree_.nodes()[location.id].count() == 0) return std::nullopt;
            scratch.passed.push_back(location.id);
        }
        if (exit == (up ? last_plane : 0)) {
            const double beyond = (up ? 1.0 : -1.0) * frame.edge[ray.axis];
            const auto change = crossings(ray, exit_plane + beyond, scratch);
            if (!change) return std::nullopt;
            return End{EmptyRegions::none, *change};
        }
        at[axis] = up ? exit : exit - 1;
    }
    return std::nullopt;
}

void tie_regions(const RegionRays& rays, DisjointOffsets& windings, Threads threads,
                 Progress* progress)
{
    constexpr std::size_t chunk = 64;
    const std::uint32_t outside = rays.region_count();
    std::vector<std::uint32_t> untied;
    std::vector<std::optional<RegionRays::End>> ends;
    for (int direction = 0; direction < RegionRays::directions; ++direction) {
        untied.clear();
        for (std::uint32_t region = 0; region < outside; ++region) {
            if (!are_tied(windings, region, outside)) untied.push_back(region);
        }
        if (untied.empty() || is_cancelled(progress)) return;
        begin_stage(progress, "regions", untied.size());
        ends.assign(untied.size(), std::nullopt);
        parallel_chunks(untied.size(), chunk, threads, [&](std::size_t first, std::size_t end) {
            RegionRays::Scratch scratch;
            for (std::size_t i = first; i < end && !is_cancelled(progress); ++i) {
                ends[i] = rays.cast(untied[i], direction, scratch);
            }
            advance_stage(progress, end - first);
        });
        for (std::size_t i = 0; i < untied.size(); ++i) {
            if (!ends[i]) continue;
            const bool left_root = ends[i]->region == EmptyRegions::none;
            windings.unite(untied[i], left_root ? outside : ends[i]->region, ends[i]->change);
        }
    }
}

} // namespace proxima
