#include "cli/canvas.h"

#include "base/memory_budget.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr int samples_per_axis = 2;

std::uint8_t to_srgb_byte(float linear)
{
    const float clamped = std::clamp(linear, 0.0F, 1.0F);
    const float encoded =
        clamped <= 0.0031308F ? 12.92F * clamped : 1.055F * std::pow(clamped, 1.0F / 2.4F) - 0.055F;
    return static_cast<std::uint8_t>(std::lround(255.0F * encoded));
}

float from_srgb_byte(unsigned byte)
{
    const float encoded = static_cast<float>(byte) / 255.0F;
    return encoded <= 0.04045F ? encoded / 12.92F : std::pow((encoded + 0.055F) / 1.055F, 2.4F);
}

/// Where to look for creases: directions on two rings, turned from sample to sample in a 4x4 pattern,
/// which the average over samples and neighbours smooths.
class CreaseDirections {
public:
    static constexpr int count = 12;

    /// `reach`, the radius of the outer ring, in samples.
    explicit CreaseDirections(double reach)
    {
        constexpr double golden_angle = 2.399963229728653;
        for (std::size_t turn = 0; turn < turns_.size(); ++turn) {
            for (int i = 0; i < count; ++i) {
                const double angle =
                    0.39269908169872414 * static_cast<double>(turn) + golden_angle * i;
                const double length = reach * std::sqrt((i + 0.5) / count);
                turns_[turn][static_cast<std::size_t>(i)] = {
                    static_cast<int>(std::lround(length * std::cos(angle))),
                    static_cast<int>(std::lround(length * std::sin(angle)))};
            }
        }
    }

    [[nodiscard]] const std::array<std::array<int, 2>, count>& of(int x, int y) const noexcept
    {
        const int turn = (x & 3) * 4 + (y & 3);
        return turns_[static_cast<std::size_t>(turn)];
    }

private:
    std::array<std::array<std::array<int, 2>, count>, 16> turns_{};
};

/// Whole numbers of the samples whose centres lie in [lower, upper], cut to [0, count).
struct SampleRange {
    int first;
    int last;

    SampleRange(double lower, double upper, int count)
        : first(static_cast<int>(std::ceil(std::clamp(lower - 0.5, 0.0, 1.0 * count)))),
          last(static_cast<int>(std::floor(std::clamp(upper - 0.5, -1.0, count - 1.0))))
    {}
};

/// The samples of a row that a triangle may cover, some more rather than less: those between its
/// edges from the row's upper end, `top`, to its lower one.
SampleRange part_of_row(const std::array<Vec2, 3>& corners, double top, int count)
{
    double left = std::numeric_limits<double>::infinity();
    double right = -left;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2& from = corners[k];
        const Vec2 along = corners[(k + 1) % 3] - from;
        const double end = from.y() + along.y();
        if (std::max(from.y(), end) < top || std::min(from.y(), end) > top + 1.0) continue;
        for (const double below : {0.0, 1.0}) {
            const double part = along.y() == 0.0 ? below : (top + below - from.y()) / along.y();
            const double x = from.x() + std::clamp(part, 0.0, 1.0) * along.x();
            left = std::min(left, x);
            right = std::max(right, x);
        }
    }
    return {left - 1.0, right + 1.0, count};
}

} // namespace

unsigned hex_of(const Color& color)
{
    return static_cast<unsigned>(to_srgb_byte(color[0])) << 16U |
           static_cast<unsigned>(to_srgb_byte(color[1])) << 8U | to_srgb_byte(color[2]);
}

Color srgb(unsigned hex)
{
    return {from_srgb_byte(hex >> 16U & 0xFFU), from_srgb_byte(hex >> 8U & 0xFFU),
            from_srgb_byte(hex & 0xFFU)};
}

Canvas::Canvas(int width, int height, const Background& background, const Progress* progress)
    : progress_(progress), width_(width), height_(height), columns_(width * samples_per_axis),
      rows_(height * samples_per_axis),
      samples_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      colors_(std::make_unique_for_overwrite<Color[]>(samples_)),
      nearness_(std::make_unique_for_overwrite<float[]>(samples_)),
      line_nearness_(std::make_unique_for_overwrite<float[]>(samples_))
{
    fill(background);
}

void Canvas::fill(const Background& background)
{
    for (int y = 0; y < rows_ && !stopped(); ++y) {
        const float part = (static_cast<float>(y) + 0.5F) / static_cast<float>(rows_);
        const Color color = (1.0F - part) * background.top + part * background.bottom;
        const std::size_t first = sample_index(0, y);
        std::fill_n(&colors_[first], columns_, color);
        std::fill_n(&nearness_[first], columns_, 0.0F);
        std::fill_n(&line_nearness_[first], columns_, 0.0F);
    }
}

template <class Put>
std::uint64_t Canvas::cover(const std::array<ScreenPoint, 3>& triangle, const Put& put) const
{
    const auto corner = [&](std::size_t i) -> Vec2 {
        return samples_per_axis * Vec2(triangle[i].x, triangle[i].y);
    };
    const Vec2 a = corner(0);
    const Vec2 ab = corner(1) - a;
    const Vec2 ac = corner(2) - a;
    const double area = ab.x() * ac.y() - ab.y() * ac.x();
    if (area == 0.0 || !std::isfinite(area)) return 0;
    const Vec2 lower = a.cwiseMin(corner(1)).cwiseMin(corner(2));
    const Vec2 upper = a.cwiseMax(corner(1)).cwiseMax(corner(2));
    const SampleRange across(lower.x(), upper.x(), columns_);
    const SampleRange down(lower.y(), upper.y(), rows_);
    constexpr int narrow = 8; // samples: to test them all takes no longer than to leave some out
    const bool is_narrow = across.last - across.first < narrow;
    const std::array<Vec2, 3> corners = {a, corner(1), corner(2)};
    std::uint64_t samples = 0;
    for (int y = down.first; y <= down.last && !stopped(); ++y) {
        const SampleRange part = is_narrow ? across : part_of_row(corners, y, columns_);
        for (int x = part.first; x <= part.last; ++x) {
            ++samples;
            const Vec2 offset = Vec2(x + 0.5, y + 0.5) - a;
            const double v = (offset.x() * ac.y() - offset.y() * ac.x()) / area;
            const double w = (ab.x() * offset.y() - ab.y() * offset.x()) / area;
            const double u = 1.0 - v - w;
            if (u < 0.0 || v < 0.0 || w < 0.0) continue;
            const auto nearness = static_cast<float>(
                u * triangle[0].nearness + v * triangle[1].nearness + w * triangle[2].nearness);
            put(sample_index(x, y), nearness, static_cast<float>(u), static_cast<float>(v),
                static_cast<float>(w));
        }
    }
    return samples;
}

std::uint64_t Canvas::draw_triangle(const std::array<ScreenVertex, 3>& triangle)
{
    return cover({triangle[0].point, triangle[1].point, triangle[2].point},
                 [&](std::size_t sample, float nearness, float u, float v, float w) {
                     if (nearness <= nearness_[sample]) return;
                     nearness_[sample] = nearness;
                     colors_[sample] =
                         u * triangle[0].color + v * triangle[1].color + w * triangle[2].color;
                 });
}

void Canvas::blend_triangle(const std::array<ScreenPoint, 3>& triangle, const Color& color,
                            float opacity)
{
    cover(triangle, [&](std::size_t sample, float nearness, float, float, float) {
        if (nearness <= nearness_[sample]) return;
        colors_[sample] = (1.0F - opacity) * colors_[sample] + opacity * color;
    });
}

void Canvas::hide_lines_behind(const std::array<ScreenPoint, 3>& triangle)
{
    cover(triangle, [&](std::size_t sample, float nearness, float, float, float) {
        line_nearness_[sample] = std::max(line_nearness_[sample], nearness);
    });
}

void Canvas::draw_line(const ScreenPoint& from, const ScreenPoint& to, const Color& color,
                       const LineStyle& style)
{
    const Vec2 start = samples_per_axis * Vec2(from.x, from.y);
    const Vec2 along = samples_per_axis * Vec2(to.x, to.y) - start;
    const double length_squared = std::max(along.squaredNorm(), 1e-12);
    if (!std::isfinite(length_squared)) return;
    const double half_width = 0.5 * samples_per_axis * style.width;
    const double reach = half_width + 0.5;
    const Vec2 lower = start.cwiseMin(start + along);
    const Vec2 upper = start.cwiseMax(start + along);
    const SampleRange down(lower.y() - reach, upper.y() + reach, rows_);
    for (int y = down.first; y <= down.last && !stopped(); ++y) {
        // The part of this row that the line may cover.
        double left = lower.x();
        double right = upper.x();
        if (std::abs(along.y()) > 1e-9) {
            const double t0 = std::clamp((y + 0.5 - reach - start.y()) / along.y(), 0.0, 1.0);
            const double t1 = std::clamp((y + 0.5 + reach - start.y()) / along.y(), 0.0, 1.0);
            const double x0 = start.x() + t0 * along.x();
            const double x1 = start.x() + t1 * along.x();
            left = std::min(x0, x1);
            right = std::max(x0, x1);
        }
        const SampleRange across(left - reach, right + reach, columns_);
        for (int x = across.first; x <= across.last; ++x) {
            const Vec2 offset = Vec2(x + 0.5, y + 0.5) - start;
            const double t = std::clamp(offset.dot(along) / length_squared, 0.0, 1.0);
            const double distance = (offset - t * along).norm();
            const double coverage = std::clamp(half_width + 0.5 - distance, 0.0, 1.0);
            if (coverage <= 0.0) continue;
            const double nearness = (1.0 - t) * from.nearness + t * to.nearness;
            const std::size_t sample = sample_index(x, y);
            if (nearness * (1.0 + style.lift) <
                static_cast<double>(std::max(nearness_[sample], line_nearness_[sample]))) {
                continue;
            }
            const float opacity = style.opacity * static_cast<float>(coverage);
            colors_[sample] = (1.0F - opacity) * colors_[sample] + opacity * color;
        }
    }
}

void Canvas::darken_creases(double radius, float strength)
{
    const CreaseDirections directions(samples_per_axis * radius);
    const auto light = std::make_unique_for_overwrite<float[]>(samples_); // the background's not
    for (int y = 0; y < rows_ && !stopped(); ++y) {
        for (int x = 0; x < columns_; ++x) {
            const float here = nearness_[sample_index(x, y)];
            if (here == 0.0F) continue;
            float closed = 0.0F;
            for (const auto& [dx, dy] : directions.of(x, y)) {
                // Two opposite neighbours that together are nearer than this place close a crease;
                // on a plane, whatever its slope, they balance.
                const auto neighbour = [&](int nx, int ny) {
                    if (nx < 0 || ny < 0 || nx >= columns_ || ny >= rows_) return 0.0F;
                    const float nearness = nearness_[sample_index(nx, ny)];
                    return nearness == 0.0F ? -0.02F : nearness / here - 1.0F;
                };
                const float bend = neighbour(x + dx, y + dy) + neighbour(x - dx, y - dy);
                closed += std::clamp(bend * 60.0F, -0.3F, 1.0F);
            }
            light[sample_index(x, y)] =
                1.0F - strength * std::clamp(closed / CreaseDirections::count, -0.2F, 1.0F);
        }
    }
    constexpr int blur = 2; // samples to each side: the size of the pattern
    for (int y = 0; y < rows_ && !stopped(); ++y) {
        for (int x = 0; x < columns_; ++x) {
            const std::size_t sample = sample_index(x, y);
            const float here = nearness_[sample];
            if (here == 0.0F) continue;
            float sum = 0.0F;
            float weight = 0.0F;
            for (int ny = std::max(0, y - blur); ny < std::min(rows_, y + blur); ++ny) {
                for (int nx = std::max(0, x - blur); nx < std::min(columns_, x + blur); ++nx) {
                    const std::size_t neighbour = sample_index(nx, ny);
                    if (std::abs(nearness_[neighbour] / here - 1.0F) > 0.02F) continue;
                    sum += light[neighbour];
                    weight += 1.0F;
                }
            }
            if (weight > 0.0F) colors_[sample] *= sum / weight;
        }
    }
}

Image Canvas::image() const
{
    Image image{width_, height_, {}};
    image.bytes.reserve(3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    for (int y = 0; y < height_ && !stopped(); ++y) {
        for (int x = 0; x < width_; ++x) {
            Color sum = Color::Zero();
            for (int sample = 0; sample < samples_per_axis * samples_per_axis; ++sample) {
                sum += colors_[sample_index(x * samples_per_axis + sample % samples_per_axis,
                                            y * samples_per_axis + sample / samples_per_axis)];
            }
            sum /= samples_per_axis * samples_per_axis;
            for (const float channel : {sum[0], sum[1], sum[2]}) {
                image.bytes.push_back(to_srgb_byte(channel));
            }
        }
    }
    return image;
}

Result<Canvas> make_canvas(int width, int height, const Background& background,
                           const Progress* progress, MemoryBudget budget)
{
    constexpr std::uint64_t samples = std::uint64_t{samples_per_axis} * samples_per_axis;
    constexpr std::uint64_t sample_bytes = sizeof(Color) + 3 * sizeof(float); // and its creases
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (Status status = check_budget(budget, pixels * (samples * sample_bytes + 3),
                                     "drawing the picture", "ask for a smaller picture");
        !status)
        return tl::unexpected(status.error());
    return Canvas(width, height, background, progress);
}

} // namespace proxima
