// Where the rays of proxima raycast come from: a file, or a camera in front of the model.
#pragma once

#include "cli/octree_picture.h"
#include "proxima/base/progress.h"
#include "proxima/base/result.h"
#include "proxima/geometry/ray.h"
#include "proxima/geometry/shapes.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// Pixels.
struct PictureSize {
    int width = 0;
    int height = 0;
};

/// "1024x768": both from 1 to 16384, else nothing.
[[nodiscard]] std::optional<PictureSize> parse_picture_size(std::string_view text) noexcept;

/// Rays of a table ox,oy,oz,dx,dy,dz or ox,oy,oz,dx,dy,dz,tmin,tmax, as CSV or .npy. Errors as
/// read_number_table, and invalid_argument for a row that is no ray.
[[nodiscard]] Result<std::vector<Ray>> read_rays(const std::string& path, Progress* progress);

/// One ray per pixel, row by row from the top, through its middle: seen three-quarter from above,
/// the box's sphere filling the picture. Directions have length 1. \pre the box is not empty
[[nodiscard]] std::vector<Ray> camera_rays(const Box& box, const PictureSize& size, UpAxis up);

} // namespace proxima
