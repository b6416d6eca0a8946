// Rays as rows of a table.
#pragma once

#include "cli/number_table.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <span>
#include <string_view>

namespace proxima {

inline constexpr std::array<std::string_view, 2> ray_layouts = {"ox,oy,oz,dx,dy,dz",
                                                                "ox,oy,oz,dx,dy,dz,tmin,tmax"};
inline constexpr TableForm ray_form = {ray_layouts, "tmin,tmax"};

/// \pre six or eight numbers
[[nodiscard]] inline Ray ray_of_row(std::span<const double> row) noexcept
{
    Ray ray{{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
    if (row.size() == 8) {
        ray.t_min = row[6];
        ray.t_max = row[7];
    }
    return ray;
}

/// Error invalid_argument where the row is no ray.
[[nodiscard]] inline Status check_ray_row(const NumberTable& table, std::size_t row)
{
    if (is_valid(ray_of_row(table.row(row)))) return {};
    return fail(ErrorCode::invalid_argument,
                "this is no ray: its direction is zero, or tmin above tmax", table.place_of(row));
}

} // namespace proxima
