// What `proxima deviation` writes beside its numbers: a coloured mesh, a picture and a histogram.
#pragma once

#include "cli/camera_options.h"
#include "cli/image.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <span>
#include <string>
#include <vector>

namespace proxima {

/// The distances of a mesh's vertices and what their colours span.
struct VertexDeviations {
    std::vector<double> distances; ///< signed or not
    double largest = 0;            ///< has the last colour; its negative the first where signed
    bool is_signed = false;
};

/// 0xRRGGBB: from dark blue at 0 to yellow at the largest; signed from blue through white to red.
[[nodiscard]] unsigned deviation_color(const VertexDeviations& deviations, double distance);

/// Vertices with colours and a `quality`, the distance. Errors: file_not_writable, cancelled.
[[nodiscard]] Status write_deviation_ply(const TriangleMesh& mesh,
                                         const VertexDeviations& deviations,
                                         const std::string& path, Progress* progress);

/// The mesh in these colours, with a legend. Errors: cancelled, budget_exceeded, and those of
/// placed_camera.
[[nodiscard]] Result<Image> draw_deviation(const TriangleMesh& mesh,
                                           const VertexDeviations& deviations,
                                           const CameraChoice& view, Progress* progress);

/// Shares of the area by bins of equal widths from 0 to `end`, one list for each name. Where `end`
/// is 0 there is one bin, of distance 0.
struct DeviationHistogram {
    double end = 0;
    std::vector<std::string> names;
    std::vector<std::vector<double>> shares;
};

/// A bar for each bin of the first list.
[[nodiscard]] std::string histogram_text(const DeviationHistogram& histogram);

/// By extension: .csv, .svg, .pdf, .png. Errors: unsupported_format, file_not_writable, cancelled.
[[nodiscard]] Status write_deviation_histogram(const DeviationHistogram& histogram,
                                               const std::string& title, const std::string& path,
                                               Progress* progress);

} // namespace proxima
