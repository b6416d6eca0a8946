#include "cli/ray_sources.h"

#include "cli/number_table.h"
#include "cli/ray_rows.h"

namespace proxima {

namespace {

Result<std::vector<Ray>> rays_of(const Result<NumberTable>& table)
{
    if (!table) return tl::unexpected(table.error());
    std::vector<Ray> rays(table->rows());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (Status status = check_ray_row(*table, i); !status)
            return tl::unexpected(status.error());
        rays[i] = ray_of_row(table->row(i));
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
