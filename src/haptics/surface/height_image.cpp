#include "haptics/surface/height_image.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace proxima {

namespace {

/// FourNumbers numbers along an axis.
using FourNumbers = std::array<double, 4>;

/// A wrapped_index index of 0 to count - 1.
std::size_t wrapped_index(std::int64_t index, std::size_t count) noexcept
{
    const auto n = static_cast<std::int64_t>(count);
    return static_cast<std::size_t>((index % n + n) % n);
}

/// The weights of four samples at t of 0 to 1 between the middle two, and their derivatives.
struct SplineWeights {
    FourNumbers value;
    FourNumbers rate;
};

SplineWeights weights_at(double t) noexcept
{
    const double s = 1 - t;
    return {{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
             (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6},
            {-s * s / 2, t * (1.5 * t - 2), -s * (1.5 * s - 2), t * t / 2}};
}

/// Where a period has the position: the first of four samples, and the part between the middle two.
struct SplineCell {
    std::int64_t first = 0;
    double part = 0;
};

SplineCell spline_cell(double turns, std::size_t count) noexcept
{
    const double at = (turns - std::floor(turns)) * static_cast<double>(count) - 0.5;
    const double below = std::floor(at);
    return {static_cast<std::int64_t>(below) - 1, at - below};
}

/// The Bezier points of a cubic between the middle two of four control points of a B-spline.
FourNumbers bezier_points(const FourNumbers& control) noexcept
{
    return {(control[0] + 4 * control[1] + control[2]) / 6, (2 * control[1] + control[2]) / 3,
            (control[1] + 2 * control[2]) / 3, (control[1] + 4 * control[2] + control[3]) / 6};
}

/// Bounds of a cell's derivatives by pixels: a spline's derivatives are means of differences of its
/// Bezier points.
struct SplineBounds {
    double slope = 0;
    double curvature = 0; ///< of the Hessian's norm, by the sum of a row
};

SplineBounds spline_bounds(const std::array<FourNumbers, 4>& control) noexcept
{
    std::array<FourNumbers, 4> by_columns{};
    std::array<FourNumbers, 4> points{}; // [column][row]
    for (std::size_t row = 0; row < 4; ++row) by_columns[row] = bezier_points(control[row]);
    for (std::size_t column = 0; column < 4; ++column) {
        points[column] = bezier_points({by_columns[0][column], by_columns[1][column],
                                        by_columns[2][column], by_columns[3][column]});
    }
    double along = 0;
    double across = 0;
    double bent = 0;
    double twisted = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            along = std::max(along, std::abs(points[j + 1][i] - points[j][i]));
            across = std::max(across, std::abs(points[i][j + 1] - points[i][j]));
        }
        for (std::size_t j = 0; j < 2; ++j) {
            bent = std::max(bent, std::abs(points[j + 2][i] - 2 * points[j + 1][i] + points[j][i]));
            bent = std::max(bent, std::abs(points[i][j + 2] - 2 * points[i][j + 1] + points[i][j]));
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            twisted = std::max(twisted, std::abs(points[i + 1][j + 1] - points[i + 1][j] -
                                                 points[i][j + 1] + points[i][j]));
        }
    }
    return {3 * std::hypot(along, across), 6 * bent + 9 * twisted};
}

} // namespace

HeightSamples::HeightSamples(std::vector<float> samples, std::size_t columns)
    : samples_(std::move(samples)), columns_(columns), rows_(samples_.size() / columns)
{
    // The rounding of a few additions of numbers up to 1.
    constexpr double rounding = 1e-14;
    SplineBounds most;
    std::array<const float*, 4> rows{};
    std::array<FourNumbers, 4> control{};
    for (std::size_t row = 0; row < rows_; ++row) {
        for (std::size_t i = 0; i < 4; ++i)
            rows[i] = samples_.data() + (row + i) % rows_ * columns_;
        for (std::size_t column = 0; column < columns_; ++column) {
            for (std::size_t j = 0; j < 4; ++j) {
                const std::size_t at = (column + j) % columns_;
                for (std::size_t i = 0; i < 4; ++i) control[i][j] = rows[i][at];
            }
            const SplineBounds cell = spline_bounds(control);
            most.slope = std::max(most.slope, cell.slope);
            most.curvature = std::max(most.curvature, cell.curvature);
        }
    }
    const auto width = static_cast<double>(columns_);
    const bool flat = std::ranges::all_of(samples_, [&](float x) { return x == samples_[0]; });
    slope_ = flat ? 0 : 2 * width * (most.slope + rounding);
    curvature_ = flat ? 0 : 2 * width * width * (most.curvature + rounding);
}

ImageHeight height_at(const HeightSamples& image, double right, double up) noexcept
{
    const std::size_t columns = image.columns();
    const std::size_t rows = image.rows();
    const auto width = static_cast<double>(columns);
    const SplineCell column = spline_cell(right, columns);
    const SplineCell row = spline_cell(-up * width / static_cast<double>(rows), rows);
    const SplineWeights along = weights_at(column.part);
    const SplineWeights down = weights_at(row.part);
    std::array<std::size_t, 4> at{};
    for (std::size_t j = 0; j < 4; ++j)
        at[j] = wrapped_index(column.first + static_cast<std::int64_t>(j), columns);
    double value = 0;
    double by_column = 0;
    double by_row = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const float* const samples =
            image.samples().data() +
            wrapped_index(row.first + static_cast<std::int64_t>(i), rows) * columns;
        double sum = 0;
        double rate = 0;
        for (std::size_t j = 0; j < 4; ++j) {
            sum += along.value[j] * samples[at[j]];
            rate += along.rate[j] * samples[at[j]];
        }
        value += down.value[i] * sum;
        by_column += down.value[i] * rate;
        by_row += down.rate[i] * sum;
    }
    return {2 * value - 1, 2 * width * by_column, -2 * width * by_row};
}

ImageAxes image_axes(const Vec3& direction) noexcept
{
    const Vec3 towards = direction.normalized();
    const Vec3 sizes = towards.cwiseAbs();
    const bool along_z = sizes.z() >= sizes.x() && sizes.z() >= sizes.y();
    const Vec3 upright = along_z ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
    const Vec3 right = upright.cross(towards).normalized();
    return {right, towards.cross(right)};
}

HeightImage::HeightImage(std::shared_ptr<const HeightSamples> parts) noexcept
    : parts_(std::move(parts))
{}

std::size_t HeightImage::columns() const noexcept
{
    return parts_->columns();
}

std::size_t HeightImage::rows() const noexcept
{
    return parts_->rows();
}

std::span<const float> HeightImage::samples() const noexcept
{
    return parts_->samples();
}

Result<HeightImage> build_height_image(std::span<const float> samples, std::size_t columns)
{
    constexpr const char* where = "height image";
    if (samples.empty() || columns == 0) {
        return fail(ErrorCode::invalid_argument,
                    "the image has no samples: give one row and one column at least", where);
    }
    if (samples.size() % columns != 0) {
        return fail(ErrorCode::invalid_argument,
                    concat(samples.size(), " samples are no whole number of rows of ", columns),
                    where);
    }
    const std::size_t rows = samples.size() / columns;
    if (columns > most_image_side || rows > most_image_side) {
        return fail(ErrorCode::invalid_argument,
                    concat("the image has ", columns, " x ", rows,
                           " samples and must have at most ", most_image_side,
                           " along each side: scale it down"),
                    where);
    }
    const auto* const wrong =
        std::find_if(samples.data(), samples.data() + samples.size(),
                     [](float sample) { return !(sample >= 0 && sample <= 1); });
    if (wrong != samples.data() + samples.size()) {
        const auto at = static_cast<std::size_t>(wrong - samples.data());
        return fail(ErrorCode::invalid_argument,
                    concat("the sample in row ", at / columns, ", column ", at % columns, " is ",
                           static_cast<double>(*wrong),
                           " and must be from 0, the deepest, to 1, the surface"),
                    where);
    }
    return HeightImage(std::make_shared<const HeightSamples>(
        std::vector<float>(samples.begin(), samples.end()), columns));
}

} // namespace proxima
