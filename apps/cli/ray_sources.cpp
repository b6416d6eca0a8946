#include "cli/ray_sources.h"

#include "cli/number_table.h"

#include <array>
#include <string_view>

namespace proxima {

namespace {

constexpr std::array<std::string_view, 2> ray_layouts = {"ox,oy,oz,dx,dy,dz",
                                                         "ox,oy,oz,dx,dy,dz,tmin,tmax"};
constexpr TableForm ray_form = {ray_layouts, "tmin,tmax"};

Result<std::vector<Ray>> rays_of(const Result<NumberTable>& table)
{
    if (!table) return tl::unexpected(table.error());
    std::vector<Ray> rays(table->rows());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::span<const double> row = table->row(i);
        rays[i].origin = {row[0], row[1], row[2]};
        rays[i].direction = {row[3], row[4], row[5]};
        if (row.size() == 8) {
            rays[i].t_min = row[6];
            rays[i].t_max = row[7];
        }
        if (is_valid(rays[i])) continue;
        return fail(ErrorCode::invalid_argument,
                    "this is no ray: its direction is zero, or tmin above tmax",
                    table->place_of(i));
    }
    return rays;
}

} // namespace

Result<std::vector<Ray>> read_rays(const std::string& path, Session& session)
{
    return rays_of(session.load_table(path, ray_form));
}

Result<std::vector<Ray>> parse_rays(std::span<const std::string> rays)
{
    return rays_of(parse_number_rows(rays, ray_form, "--ray"));
}

RayList::RayList(const OrbitCamera& camera, ViewSize size)
    : count_(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height)),
      view_(View(camera, size)), width_(static_cast<std::size_t>(size.width))
{}

Ray RayList::operator[](std::size_t number) const noexcept
{
    if (!view_) return rays_[number];
    const std::size_t row = number / width_;
    const Vec2 pixel(static_cast<double>(number % width_) + 0.5, static_cast<double>(row) + 0.5);
    return {view_->eye(), view_->direction(pixel).normalized()};
}

} // namespace proxima
