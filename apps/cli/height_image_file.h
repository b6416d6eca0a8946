// Heights from pictures, for textures: a grey PNG, or an array of NumPy's.
//
//     PNG    1 to 16 bits of grey, without colours and transparency; the values as they are stored
//     .npy   (rows, columns), the first row on top; floats from 0 to 1, or whole numbers from 0 on of
//            one or two bytes, whose largest is 1
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <string>

namespace proxima {

/// Black is deepest, white is the surface. The content decides about the format. Errors name the
/// file: file_not_found, unsupported_format (neither, colours, other numbers), malformed_file (cut
/// off, damaged, a number out of range, other shapes), invalid_argument (a side that is too long),
/// budget_exceeded (more than 64 MB), cancelled. No memory is taken for sizes that are refused.
[[nodiscard]] Result<HeightImage> read_height_image(const std::string& path,
                                                    Progress* progress = nullptr);

} // namespace proxima
