// What proxima intersect writes: what was found pose by pose, pairs of triangles, and contours.
//
//     pose,intersecting,pairs,contained[,separation,ax,ay,az,bx,by,bz,triangle_a,triangle_b]
//         [,cell_pairs,cells_a,cells_b,cell_triangles_a,cell_triangles_b]
//                                       .csv or .npy (float64); contained: 1 for A in B, 2 for B in A
//     pose,a,b                          .csv or .npy (float64): ascending
//     o pose_0 / v x y z / l 1 2 3 1    .obj: polylines; a closed one ends where it began
#pragma once

#include "cli/answer_table.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace proxima {

/// The header line, or the header of .npy for `rows` pairs.
[[nodiscard]] std::string pair_header(AnswerFormat format, std::uint64_t rows);

[[nodiscard]] std::string pair_rows(AnswerFormat format, std::uint64_t pose,
                                    std::span<const TrianglePair> pairs);

/// Leaves of two octrees that meet.
struct MeetingCells {
    std::uint64_t pairs = 0;
    std::uint64_t of_a = 0; ///< different ones
    std::uint64_t of_b = 0;
    std::uint64_t triangles_of_a = 0; ///< in them
    std::uint64_t triangles_of_b = 0;
};

struct PoseRow {
    std::uint64_t pairs = 0;
    Containment containment = Containment::none;
    const MeshDistance* nearest = nullptr;  ///< null where it was not asked for
    std::optional<MeetingCells> cells = {}; ///< none where they were not asked for
};

/// What a row has beside pairs and containment.
struct PoseColumns {
    bool distance = false;
    bool cells = false;
};

/// The header line, or the header of .npy for `rows` poses.
[[nodiscard]] std::string pose_header(AnswerFormat format, PoseColumns columns, std::uint64_t rows);

[[nodiscard]] std::string pose_row(AnswerFormat format, std::uint64_t pose, const PoseRow& row);

/// `first_vertex` is the number that the file's next vertex has, from 1. Numbers have 17
/// significant digits. Points alone are written as `p`.
[[nodiscard]] std::string contour_obj(const IntersectionContour& contour, std::uint64_t pose,
                                      std::uint64_t first_vertex);

} // namespace proxima
