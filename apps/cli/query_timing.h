// How long single queries take, measured on this machine.
#pragma once

#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <span>
#include <vector>

namespace proxima {

/// Nanoseconds per query.
struct QueryTiming {
    std::size_t queries = 0;
    double median = 0;
    double max = 0;
};

/// Queries to estimate with: half of them anywhere in the box 1.2 times the mesh's, half within 1 %
/// of its diagonal of the surface (sets a and b of query_sets.h), always the same ones.
[[nodiscard]] std::vector<Vec3> estimate_queries(const TriangleMesh& mesh);

/// Times queries one by one on the calling thread. Each is asked five times and the least time
/// kept, less what reading the clock takes. About 5 us per query. \pre there is a query
[[nodiscard]] QueryTiming time_queries(const MeshIndex& index, std::span<const Vec3> points);

/// Nanoseconds per query when all are asked one after the other on the calling thread: the median
/// of five rounds. \pre there is a query
[[nodiscard]] double time_pass(const MeshIndex& index, std::span<const Vec3> points);

} // namespace proxima
