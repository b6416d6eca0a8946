// A mesh's vertices on the grid of the vector lanes, and the exact word on what lanes leave open.
#pragma once

#include "octree/snapped_boxes.h"
#include "octree/snapped_overlap.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <span>

namespace proxima {

/// A point in steps of 2^-snapped_bits root edges from the root's lower corner.
using GridPoint = std::array<std::int32_t, 3>;

/// Some triangles relative to a grid point, and the ids they have in the mesh.
struct LocalTriangles {
    GrowBuffer<SnappedTriangle> triangles;
    std::span<const std::uint32_t> ids;
    GridPoint origin = {};
};

/// Pairs whose cells all have this half size, in grid steps, and lie at depth(children) - 1.
struct PairLevel {
    SnappedPairs pairs;
    std::int32_t half = 0;
    int child_depth = 0;
    /// Children that exist, per pair (bits); all where null.
    const std::uint8_t* allowed = nullptr;
};

/// Immutable view of a mesh and a root. Thread safe.
class SnappedMesh {
public:
    /// The grid may be off by more steps than the lanes can use when the mesh is tiny against its
    /// distance from the origin.
    static constexpr double max_error_steps = 1 << 24;

    /// Not to be used once `progress` is cancelled; a step per vertex.
    /// \pre all vertices that triangles use lie in the frame; both outlive this object
    SnappedMesh(const TriangleMesh& mesh, const OctreeFrame& frame, Threads threads,
                Progress* progress);

    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return mesh_; }

    /// Vertex on the grid.
    [[nodiscard]] const SnappedPoint& vertex(std::uint32_t id) const noexcept
    {
        return vertices_[id];
    }

    [[nodiscard]] SnappedArrays arrays() const noexcept
    {
        return {vertices_.data(), mesh_.triangles().data()};
    }

    /// Distance in whole steps that a vertex may be off against any cell plane.
    [[nodiscard]] std::int32_t margin() const noexcept { return margin_; }

    /// Sets `local` to these triangles of the mesh, relative to `origin`; the ids must outlive it.
    void load(std::span<const std::uint32_t> ids, const GridPoint& origin,
              LocalTriangles& local) const;

    /// masks[pair] = children that the pair's triangle touches, exactly.
    void find_touched(const LocalTriangles& local, const PairLevel& level, SnappedScratch& scratch,
                      std::uint32_t* masks) const;

private:
    [[nodiscard]] bool touches(std::uint32_t triangle, const GridPoint& lower,
                               int depth) const noexcept;

    const TriangleMesh& mesh_;
    OctreeFrame frame_;
    double error_steps_ = 0;
    std::int32_t margin_ = 1;
    GrowBuffer<SnappedPoint> vertices_;
};

} // namespace proxima
