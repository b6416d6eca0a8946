// Vectors in the JSON that commands write.
#pragma once

#include "proxima/geometry.h"

#include <nlohmann/json.hpp>

namespace proxima {

[[nodiscard]] inline nlohmann::ordered_json json_numbers(const Vec3& v)
{
    return {v.x(), v.y(), v.z()};
}

} // namespace proxima
