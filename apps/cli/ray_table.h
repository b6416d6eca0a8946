// Answers of proxima raycast as files, as CSV or as NumPy's .npy (all columns float64).
//
//     index,t,triangle,u,v                                     hits; a miss has t inf, triangle -1
//     0,2.5,17,0.25,0.5
//     ray,cell_depth,cx,cy,cz,enter,exit,chord,penetration     cells, in order along each ray
#pragma once

#include "cli/answer_table.h"
#include "proxima/cast_ray.h"
#include "proxima/cells_along_ray.h"

#include <optional>
#include <span>
#include <string>

namespace proxima {

[[nodiscard]] std::string hit_header(AnswerFormat format, std::uint64_t rows);
[[nodiscard]] std::string cell_header(AnswerFormat format, std::uint64_t rows);

/// The rows of hits of the rays from number `first` on. CSV has 17 significant digits.
[[nodiscard]] std::string hit_rows(AnswerFormat format, std::uint64_t first,
                                   std::span<const std::optional<RayHit>> hits);

/// The rows of one ray's cells; cx, cy, cz are the cell's coordinates at its depth.
[[nodiscard]] std::string cell_rows(AnswerFormat format, std::uint64_t ray,
                                    std::span<const CellOnRay> cells);

} // namespace proxima
