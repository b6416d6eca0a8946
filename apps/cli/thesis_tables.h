// The figures of the thesis's tables, as printed there.
#pragma once

#include "proxima/octree.h"

#include <array>
#include <cstdint>
#include <string_view>

namespace proxima::thesis {

/// A row of Table 2.1 (by depth, threshold 1) or 2.2 (by threshold, depth 5): sphere:100x100.
struct SphereRow {
    int depth;
    std::uint32_t threshold;
    std::uint64_t total;
    std::uint64_t leaves;
    double occupied_percent;
    std::uint32_t min_triangles;
    std::uint32_t max_triangles;
    std::uint64_t references;
};

inline constexpr std::array<SphereRow, 5> table_2_1 = {{{1, 1, 9, 8, 100.0, 2669, 2950, 22476},
                                                        {2, 1, 73, 64, 87.5, 79, 1285, 24332},
                                                        {3, 1, 521, 456, 59.6, 9, 763, 28052},
                                                        {4, 1, 2697, 2360, 49.2, 2, 513, 35720},
                                                        {5, 1, 11977, 10480, 45.4, 1, 398, 52480}}};

inline constexpr std::array<SphereRow, 9> table_2_2 = {{{5, 1, 11977, 10480, 45.4, 1, 398, 52480},
                                                        {5, 50, 3017, 2640, 60.3, 2, 398, 39320},
                                                        {5, 100, 1417, 1240, 62.6, 4, 398, 33688},
                                                        {5, 150, 777, 680, 65.9, 9, 398, 30720},
                                                        {5, 200, 713, 624, 64.1, 9, 398, 30328},
                                                        {5, 250, 553, 484, 63.6, 9, 398, 29004},
                                                        {5, 300, 553, 484, 63.6, 9, 398, 29004},
                                                        {5, 350, 489, 428, 62.6, 9, 398, 28348},
                                                        {5, 400, 297, 260, 63.0, 11, 398, 26740}}};

/// A model of Table 2.3, all at depth 5: with threshold 1, then with the threshold of the two-pass
/// heuristic. Mean and standard deviation are over all leaves.
struct ModelRow {
    std::uint32_t threshold;
    std::uint64_t total;
    std::uint64_t leaves;
    double occupied_percent;
    double mean;
    double std;
};

struct Model {
    std::string_view name;
    std::string_view file;    ///< its name in the Stanford repository
    std::string_view archive; ///< what has it there
    std::uint64_t triangles;
    std::array<ModelRow, 2> rows;
};

inline constexpr std::array<Model, 3> table_2_3 = {
    {{"Bunny",
      "bun_zipper_res2.ply",
      "bunny.tar.gz",
      16301,
      {{{1, 11137, 9745, 53.3, 9.03, 10.36}, {47, 5905, 5167, 73.5, 14.74, 11.97}}}},
     {"Buddha",
      "happy_vrip_res4.ply",
      "happy_recon.tar.gz",
      15536,
      {{{1, 16297, 14260, 59.2, 8.70, 9.48}, {61, 3273, 2864, 81.0, 23.20, 17.09}}}},
     {"Dragon",
      "dragon_vrip_res3.ply",
      "dragon_recon.tar.gz",
      47794,
      {{{1, 14257, 12475, 55.9, 17.32, 19.86}, {89, 7545, 6602, 77.8, 29.16, 22.71}}}}}};

/// A row of Table 3.3: seconds on a Pentium 4 of 3.2 GHz.
struct TimeRow {
    int depth;
    double separating_axis;
    double index_tracking;
    double minkowski;
    double pairwise;

    /// Seconds of a method; 0 for `fast`, which the thesis does not have.
    [[nodiscard]] constexpr double seconds(OverlapMethod method) const noexcept
    {
        switch (method) {
        case OverlapMethod::separating_axis:
            return separating_axis;
        case OverlapMethod::index_tracking:
            return index_tracking;
        case OverlapMethod::minkowski:
            return minkowski;
        case OverlapMethod::pairwise:
            return pairwise;
        case OverlapMethod::fast:
            break;
        }
        return 0.0;
    }
};

inline constexpr std::array<TimeRow, 5> table_3_3 = {{{1, 1.047, 27.422, 27.329, 200.687},
                                                      {2, 1.672, 38.328, 51.672, 408.204},
                                                      {3, 2.484, 49.578, 77.000, 642.140},
                                                      {4, 3.296, 60.953, 103.266, 922.171},
                                                      {5, 4.453, 74.500, 129.235, 1296.297}}};

} // namespace proxima::thesis
