#include "octree/snapped_mesh.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/triangle_box.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr double grid_steps = 1 << snapped_bits;

/// How many steps a snapped vertex can be off against the double plane of a cell: half a step for
/// rounding to the grid, the rounding of (v - lower) * (steps / edge), and that of
/// OctreeFrame::plane, two roundings of at most 2^-53 (|lower| + edge).
double snapping_error(const OctreeFrame& frame) noexcept
{
    // Steps that are no normal doubles, or of which so many as 1 leave the doubles.
    constexpr double smallest_edge = 1e-290;
    if (frame.edge.minCoeff() < smallest_edge) return std::numeric_limits<double>::infinity();
    const Vec3 distance = frame.lower.cwiseAbs().cwiseQuotient(frame.edge);
    constexpr double unit = 1.0 / (std::uint64_t{1} << 52U);
    return 0.5 + grid_steps * unit * (distance.maxCoeff() + 4);
}

/// Vertices outside the root or NaN are not used by a triangle, so any grid point will do.
std::int32_t snap(double offset, double scale) noexcept
{
    // A sum with this number has no digits behind the point. std::nearbyint is a call unless the
    // compiler may assume SSE4.1.
    constexpr double rounder = 0x1.8p52;
    const double step = (offset * scale + rounder) - rounder;
    return step > 0 ? static_cast<std::int32_t>(std::min(step, grid_steps)) : 0;
}

} // namespace

SnappedMesh::SnappedMesh(const TriangleMesh& mesh, const OctreeFrame& frame, Threads threads,
                         Progress* progress)
    : mesh_(mesh), frame_(frame), error_steps_(snapping_error(frame)),
      margin_(static_cast<std::int32_t>(std::ceil(std::min(error_steps_, max_error_steps))))
{
    const Vec3 scale = Vec3::Constant(grid_steps).cwiseQuotient(frame.edge);
    vertices_.resize(mesh.vertex_count());
    constexpr std::size_t chunk = 1 << 14;
    parallel_chunks(mesh.vertex_count(), chunk, threads, [&](std::size_t first, std::size_t end) {
        if (is_cancelled(progress)) return;
        for (std::size_t vertex = first; vertex < end; ++vertex) {
            const Vec3 offset = mesh.positions()[vertex] - frame.lower;
            vertices_[vertex] = {snap(offset[0], scale[0]), snap(offset[1], scale[1]),
                                 snap(offset[2], scale[2]), 0};
        }
        advance_stage(progress, end - first);
    });
}

void SnappedMesh::load(std::span<const std::uint32_t> ids, const GridPoint& origin,
                       LocalTriangles& local) const
{
    local.origin = origin;
    local.ids = ids;
    // Lanes without a triangle use the first one.
    local.triangles.resize(std::max<std::size_t>(ids.size(), 1));
    const SnappedPoint from = {origin[0], origin[1], origin[2], 0};
    for (std::size_t slot = 0; slot < ids.size(); ++slot) {
        const TriangleCorners& corners = mesh_.triangles()[ids[slot]];
        for (std::size_t j = 0; j < 3; ++j) {
            const SnappedPoint& vertex = vertices_[corners[j]];
            for (std::size_t k = 0; k < 4; ++k) {
                local.triangles[slot][j][k] = vertex[k] - from[k];
            }
        }
    }
}

bool SnappedMesh::touches(std::uint32_t triangle, const GridPoint& lower, int depth) const noexcept
{
    const int shift = snapped_bits - depth;
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
        const auto index =
            static_cast<std::uint32_t>(lower[static_cast<std::size_t>(axis)] >> shift);
        box.lower[axis] = frame_.plane(axis, index, depth);
        box.upper[axis] = frame_.plane(axis, index + 1, depth);
    }
    return triangle_overlaps_box(mesh_.triangle(TriangleId{triangle}), box);
}

void SnappedMesh::find_touched(const LocalTriangles& local, const PairLevel& level,
                               SnappedScratch& scratch, std::uint32_t* masks) const
{
    const SnappedPairs& pairs = level.pairs;
    if (error_steps_ > max_error_steps) {
        // The grid says nothing about such a mesh: every child of every pair is unsure.
        scratch.unsure.clear();
        for (std::size_t pair = 0; pair < pairs.count; ++pair) {
            masks[pair] = 0;
            scratch.unsure.push_back({static_cast<std::uint32_t>(pair), 0xFF});
        }
    } else {
        const SnappedLevel lanes{.half = level.half,
                                 .error =
                                     static_cast<float>(error_steps_ * (1 + 1e-6) / level.half),
                                 .margin = margin_};
        find_touched_children(local.triangles.data(), lanes, pairs, scratch, masks);
    }
    if (level.allowed != nullptr) {
        for (std::size_t pair = 0; pair < pairs.count; ++pair) masks[pair] &= level.allowed[pair];
    }
    for (const UnsurePair& unsure : scratch.unsure) {
        const std::uint32_t triangle = local.ids[pairs.triangle[unsure.pair]];
        std::uint32_t left = unsure.children;
        if (level.allowed != nullptr) left &= level.allowed[unsure.pair];
        std::uint32_t& mask = masks[unsure.pair];
        // The triangle touches the cell. If a single child is left and no other is touched, the
        // triangle touches it.
        const bool decided = mask == 0 && std::has_single_bit(left);
        if (decided) mask = left;
        for (; !decided && left != 0; left &= left - 1) {
            const int child = std::countr_zero(left);
            GridPoint lower = local.origin;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const bool upper = (static_cast<unsigned>(child) >> axis & 1U) != 0;
                lower[axis] += pairs.center[axis][unsure.pair] - (upper ? 0 : level.half);
            }
            if (touches(triangle, lower, level.child_depth)) mask |= 1U << child;
        }
    }
}

} // namespace proxima
