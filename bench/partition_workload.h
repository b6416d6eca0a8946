// The overlap questions that building an octree asks, as plain numbers: which cells of a grid a
// triangle is tested against.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima::bench {

using WholePoint = std::array<std::int64_t, 3>;
using WholeTriangle = std::array<WholePoint, 3>;

/// Root edges are 2^14 grid steps, so that doubles hold every product of a test exactly.
inline constexpr int workload_grid_bits = 14;

/// A triangle and all cells of one depth that it touches and that are split: it is tested against
/// their eight children each, whose sum with it is the same.
struct WorkloadGroup {
    WholeTriangle triangle;
    std::int64_t child_half = 0;
    std::vector<WholePoint> cells; ///< lower corners
};

struct PartitionWorkload {
    std::string name;
    std::vector<WorkloadGroup> groups;
    std::size_t pairs = 0; ///< (triangle, cell), each of eight questions
};

/// The workload of building an octree over a mesh (a sample's name or a file), of every nth
/// triangle. Empty if there is no such mesh.
[[nodiscard]] PartitionWorkload partition_workload(const std::string& name, const std::string& mesh,
                                                   int max_depth, std::size_t threshold,
                                                   std::size_t every_nth);

} // namespace proxima::bench
