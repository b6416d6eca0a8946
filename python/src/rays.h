// What rays are made of, and columns of what they hit.
#pragma once

#include "arrays.h"
#include "proxima/cast_ray.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima::python {

/// Origins (n, 3) or (3,), directions (n, 3), the least and the greatest t of each or of all.
[[nodiscard]] std::vector<Ray> rays_of(const py::object& origins, const py::object& directions,
                                       const py::object& t_min, const py::object& t_max);

/// Of "both", "front" or "back".
[[nodiscard]] Faces faces_named(const std::string& name);

/// What a ray that hits nothing has in the columns.
inline constexpr RayHit no_hit{infinity, no_triangle, nan, nan};

/// Columns of hits.
class HitArrays {
public:
    explicit HitArrays(std::size_t size);

    void set(std::size_t i, const RayHit& hit) noexcept
    {
        to_t_[i] = hit.t;
        to_triangle_[i] = static_cast<std::int32_t>(to_index(hit.triangle));
        to_u_[i] = hit.u;
        to_v_[i] = hit.v;
    }

    [[nodiscard]] py::tuple columns() const;

private:
    py::array_t<double> t_;
    py::array_t<std::int32_t> triangle_;
    py::array_t<double> u_;
    py::array_t<double> v_;
    double* to_t_;
    std::int32_t* to_triangle_;
    double* to_u_;
    double* to_v_;
};

} // namespace proxima::python
