#include "geometry/view_contact.h"

#include "geometry/view_plane.h"
#include "geometry/whole_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace proxima {

namespace {

using detail::WideInteger;

constexpr double underflow_slack = 64 * std::numeric_limits<double>::min();

/// The values of a plane at a triangle's corners: linear in the triangle's barycentric coordinates.
/// The lines of its own sides are those that make one of these zero.
struct Line {
    std::array<double, 3> values; ///< rounded
    double error;                 ///< no value is off by more
    double size;                  ///< none is larger, error included
};

int exact_determinant_sign(const std::array<std::array<WideInteger, 3>, 3>& m) noexcept
{
    const auto minor = [&](std::size_t i, std::size_t j) {
        return m[0][i] * m[1][j] - m[0][j] * m[1][i];
    };
    return (minor(1, 2) * m[2][0] + minor(2, 0) * m[2][1] + minor(0, 1) * m[2][2]).sign();
}

// Cuts a triangle by one plane after the other [sutherland-1974], in barycentric coordinates and
// without ever computing a corner: a corner is where the line of the edge that leads to it meets
// the line of the edge that it was cut off with, and its side of a plane is the sign of the
// determinant of three lines. With lines positive inside and corners counter-clockwise, the product
// of the line that leads there and the one that leads away is the corner, not its opposite.
// Triangles without an area need no case of their own: barycentric coordinates never see it.
class CutTriangle {
public:
    CutTriangle(std::span<const ViewPlane> planes, const Triangle& triangle) noexcept
        : planes_(planes), triangle_(triangle)
    {
        for (std::uint16_t i = 0; i < 3; ++i) {
            lines_[i] = {{0, 0, 0}, 0, 1};
            lines_[i].values[i] = 1;
            const auto before = static_cast<std::uint16_t>((i + 1) % 3);
            const auto after = static_cast<std::uint16_t>((i + 2) % 3);
            corners_[0][i] = {before, after, after};
        }
    }

    /// Whether anything is left.
    [[nodiscard]] bool cut(std::uint16_t plane) noexcept
    {
        const auto line = static_cast<std::uint16_t>(3 + plane);
        add_line(plane);
        const auto& corners = corners_[turn_];
        std::uint32_t outside = 0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            signs_[i] = static_cast<std::int8_t>(side(corners[i], line));
            outside += signs_[i] < 0 ? 1U : 0U;
        }
        if (outside == 0) return true;
        if (outside == count_) return false;
        turn_ = 1 - turn_;
        auto& cut = corners_[turn_];
        std::uint32_t kept = 0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            const std::uint32_t next = i + 1 == count_ ? 0 : i + 1;
            const std::uint16_t edge = corners[i].edge;
            if (signs_[i] >= 0) {
                // The new corner begins with the line of the cut.
                const bool leaves = signs_[i] == 0 && signs_[next] < 0;
                cut[kept++] = {corners[i].before, corners[i].after, leaves ? line : edge};
            }
            if (signs_[i] > 0 && signs_[next] < 0) cut[kept++] = {edge, line, line};
            if (signs_[i] < 0 && signs_[next] > 0) cut[kept++] = {line, edge, edge};
        }
        count_ = kept;
        return true;
    }

private:
    struct Corner {
        std::uint16_t before; ///< of the lines that meet in it, in this order
        std::uint16_t after;
        std::uint16_t edge; ///< the line to the next corner
    };
    static constexpr std::size_t capacity = max_view_planes + 3;

    void add_line(std::uint16_t plane) noexcept
    {
        const ViewPlane& cutting = planes_[plane];
        Line& line = lines_[3U + plane];
        line.error = 0;
        line.size = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 products = cutting.normal.cwiseProduct(triangle_.vertices[i]);
            line.values[i] = ((products.x() + products.y()) + products.z()) + cutting.offset;
            const double size = products.cwiseAbs().sum() + std::abs(cutting.offset);
            line.error = std::max(line.error, 0x1p-50 * size + underflow_slack);
            line.size = std::max(line.size, std::abs(line.values[i]));
        }
        line.size += line.error;
        // By the power of two that brings the size to 1, so that no product of two or three lines
        // over- or underflows. A size that is not finite leaves all signs unsure.
        if (!(line.size <= std::numeric_limits<double>::max())) return;
        int exponent = 0;
        std::frexp(line.size, &exponent);
        const double scale = std::ldexp(1.0, -exponent);
        for (double& value : line.values) value *= scale;
        line.error *= scale;
        line.size *= scale;
    }

    // Six products of three are off by at most the error of one factor times the sizes of the
    // others, each, and by less than 6 u of their size for rounding.
    [[nodiscard]] int side(const Corner& corner, std::uint16_t line) const noexcept
    {
        const Line& a = lines_[corner.before];
        const Line& b = lines_[corner.after];
        const Line& c = lines_[line];
        const auto minor = [&](std::size_t i, std::size_t j) {
            return a.values[i] * b.values[j] - a.values[j] * b.values[i];
        };
        const double value =
            minor(1, 2) * c.values[0] + minor(2, 0) * c.values[1] + minor(0, 1) * c.values[2];
        const double errors =
            (a.error * b.size + a.size * b.error) * c.size + a.size * b.size * c.error;
        const double error = 8 * errors + 0x1p-46 * (a.size * b.size * c.size) + underflow_slack;
        if (value > error) return 1;
        if (value < -error) return -1;
        return exact_determinant_sign(
            {exact_line(corner.before), exact_line(corner.after), exact_line(line)});
    }

    [[nodiscard]] std::array<WideInteger, 3> exact_line(std::uint16_t line) const noexcept
    {
        std::array<WideInteger, 3> values;
        if (line < 3) {
            values[line] = WideInteger(std::numeric_limits<double>::denorm_min()); // 1
            return values;
        }
        const ViewPlane& plane = planes_[line - 3U];
        const auto p = detail::whole_numbers(std::array<double, 4>{
            plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset});
        for (std::size_t i = 0; i < 3; ++i) {
            const auto x = detail::whole_numbers(triangle_.vertices[i]);
            values[i] = p[0] * x[0] + p[1] * x[1] + (p[2] * x[2] + p[3] * x[3]);
        }
        return values;
    }

    std::span<const ViewPlane> planes_;
    const Triangle& triangle_;
    std::array<Line, capacity> lines_; ///< of the sides, then of the planes; those in use are set
    std::array<std::array<Corner, capacity>, 2> corners_; ///< in turns: as cut so far, and cutting
    std::array<std::int8_t, capacity> signs_;
    std::size_t turn_ = 0;
    std::uint32_t count_ = 3;
};

Vec3 box_corner(const Box& box, unsigned bits) noexcept
{
    return {(bits & 1U) != 0 ? box.upper.x() : box.lower.x(),
            (bits & 2U) != 0 ? box.upper.y() : box.lower.y(),
            (bits & 4U) != 0 ? box.upper.z() : box.lower.z()};
}

} // namespace

Vec3 innermost_corner(const ViewPlane& plane, const Box& box) noexcept
{
    return (plane.normal.array() >= 0).select(box.upper, box.lower);
}

Vec3 outermost_corner(const ViewPlane& plane, const Box& box) noexcept
{
    return (plane.normal.array() >= 0).select(box.lower, box.upper);
}

bool passes_planes(const ViewVolume& volume, const Triangle& triangle) noexcept
{
    if (volume.empty()) return false;
    return std::ranges::all_of(volume.planes(), [&](const ViewPlane& plane) {
        return std::ranges::any_of(triangle.vertices, [&](const Vec3& corner) {
            return side_of_plane(plane, corner) >= 0;
        });
    });
}

bool passes_planes(const ViewVolume& volume, const Box& box) noexcept
{
    if (volume.empty()) return false;
    return std::ranges::all_of(volume.planes(), [&](const ViewPlane& plane) {
        return side_of_plane(plane, innermost_corner(plane, box)) >= 0;
    });
}

bool meets_volume(const ViewVolume& volume, const Triangle& triangle) noexcept
{
    if (volume.empty()) return false;
    const std::span<const ViewPlane> planes = volume.planes();
    std::array<bool, 3> inside = {true, true, true};
    for (const ViewPlane& plane : planes) {
        bool any = false;
        for (std::size_t i = 0; i < 3; ++i) {
            const bool in = side_of_plane(plane, triangle.vertices[i]) >= 0;
            any = any || in;
            inside[i] = inside[i] && in;
        }
        if (!any) return false;
    }
    if (inside[0] || inside[1] || inside[2]) return true;
    CutTriangle rest(planes, triangle);
    for (std::size_t i = 0; i < planes.size(); ++i)
        if (!rest.cut(static_cast<std::uint16_t>(i))) return false;
    return true;
}

bool meets_volume(const ViewVolume& volume, const Box& box) noexcept
{
    if (!passes_planes(volume, box)) return false;
    // The volume meets a side of the box, or lies within it.
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned b = 1U << (axis + 1) % 3;
        const unsigned c = 1U << (axis + 2) % 3;
        for (const unsigned fixed : {0U, 1U << axis}) {
            const auto at = [&](unsigned bits) { return box_corner(box, fixed | bits); };
            if (meets_volume(volume, Triangle{{at(0), at(b), at(b | c)}}) ||
                meets_volume(volume, Triangle{{at(0), at(b | c), at(c)}}))
                return true;
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 unit = Vec3::Unit(axis);
        if (side_of_plane(ViewPlane{unit, -box.lower[axis]}, volume.inner_point()) < 0 ||
            side_of_plane(ViewPlane{-unit, box.upper[axis]}, volume.inner_point()) < 0)
            return false;
    }
    return true;
}

} // namespace proxima
