#include "cli/ray_sources.h"

#include "base/text.h"
#include "cli/number_table.h"

#include <algorithm>
#include <array>
#include <charconv>
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

std::optional<int> parse_pixels(std::string_view text) noexcept
{
    constexpr int most = 16384;
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    if (value < 1 || value > most) return std::nullopt;
    return value;
}

} // namespace

std::optional<PictureSize> parse_picture_size(std::string_view text) noexcept
{
    const std::size_t cross = text.find('x');
    if (cross == std::string_view::npos) return std::nullopt;
    const auto width = parse_pixels(text.substr(0, cross));
    const auto height = parse_pixels(text.substr(cross + 1));
    if (!width || !height) return std::nullopt;
    return PictureSize{*width, *height};
}

Result<std::vector<Ray>> read_rays(const std::string& path, Progress* progress)
{
    return rays_of(read_number_table(path, ray_form, {.execution = {.progress = progress}}));
}

Result<std::vector<Ray>> parse_rays(std::span<const std::string> rays)
{
    return rays_of(parse_number_rows(rays, ray_form, "--ray"));
}

RayList::RayList(const Box& box, const PictureSize& size, UpAxis up)
    : count_(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height)),
      size_(size)
{
    constexpr double half_angle_tangent = 0.3;
    const Vec3 up_axis = up == UpAxis::y ? Vec3::UnitY() : Vec3::UnitZ();
    const Vec3 ahead_axis = up == UpAxis::y ? Vec3::UnitZ() : Vec3(-Vec3::UnitY());
    const Vec3 side_axis = up_axis.cross(ahead_axis);
    toward_eye_ = (0.45 * side_axis + 0.35 * up_axis + ahead_axis).normalized();
    double radius = 0.5 * box.extent().norm();
    if (!(radius > 0)) radius = std::max(1e-6 * box.upper.cwiseAbs().maxCoeff(), 1e-6);
    // The sphere touches the sides of the narrower view.
    const double sine = half_angle_tangent / std::hypot(1.0, half_angle_tangent);
    eye_ = box.center() + radius / sine * toward_eye_;
    const double pixel = 2 * half_angle_tangent / std::min(size.width, size.height);
    right_ = pixel * up_axis.cross(toward_eye_).normalized();
    above_ = toward_eye_.cross(right_);
}

Ray RayList::operator[](std::size_t number) const noexcept
{
    if (!rays_.empty()) return rays_[number];
    const auto width = static_cast<std::size_t>(size_.width);
    const double across = static_cast<double>(number % width) + 0.5 - 0.5 * size_.width;
    const double down = static_cast<double>(number / width) + 0.5 - 0.5 * size_.height;
    return {eye_, (across * right_ - down * above_ - toward_eye_).normalized()};
}

} // namespace proxima
