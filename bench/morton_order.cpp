#include "morton_order.h"

#include "base/morton_code.h"
#include "base/radix_sort.h"

#include <algorithm>
#include <array>

namespace proxima::bench {
namespace {

/// Cells of a cube about a box, 2^bits along each axis.
class CubeGrid {
public:
    CubeGrid(const Box& box, int bits)
        : lower_(box.center() - Vec3::Constant(reach * box.extent().maxCoeff())),
          last_(static_cast<double>((1U << static_cast<unsigned>(bits)) - 1)),
          cells_per_length_((last_ + 1) / std::max(2 * reach * box.extent().maxCoeff(), 1e-300))
    {}

    [[nodiscard]] std::array<std::uint32_t, 3> cell_of(const Vec3& point) const
    {
        std::array<std::uint32_t, 3> cell{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            const double at = cells_per_length_ * (point[k] - lower_[k]);
            cell[axis] = static_cast<std::uint32_t>(std::clamp(at, 0.0, last_));
        }
        return cell;
    }

private:
    static constexpr double reach = 1.25 / 2; ///< half the cube's edge over the box's

    Vec3 lower_;
    double last_;
    double cells_per_length_;
};

struct CurvePoint {
    std::uint32_t key = 0;
    std::uint32_t index = 0;
};

} // namespace

std::vector<std::uint32_t> morton_order(std::span<const Vec3> points, const Box& box, int bits)
{
    const CubeGrid grid(box, bits);
    std::vector<CurvePoint> along(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i)
        along[i] = {static_cast<std::uint32_t>(morton_code(grid.cell_of(points[i]))), i};
    StageSteps unwatched(nullptr, "", 0);
    (void)radix_sort(
        along, 3 * static_cast<unsigned>(bits), [](const CurvePoint& point) { return point.key; },
        unwatched);
    std::vector<std::uint32_t> order(points.size());
    std::ranges::transform(along, order.begin(), &CurvePoint::index);
    return order;
}

bool pays_to_sort(std::span<const Vec3> points, const Box& box)
{
    constexpr std::size_t samples = 64;
    if (points.size() < 4 * samples) return false;
    const CubeGrid grid(box, batch_order_bits);
    std::size_t apart = 0;
    for (std::size_t i = 0; i < samples; ++i) {
        const std::size_t at = points.size() / samples * i;
        apart += grid.cell_of(points[at]) != grid.cell_of(points[at + 1]) ? 1 : 0;
    }
    return 2 * apart > samples;
}

} // namespace proxima::bench
