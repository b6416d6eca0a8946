#include "query/field/open_sides.h"

#include "index/signs/sign_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace proxima {

namespace {

constexpr bool is_edge(std::uint32_t edge) noexcept
{
    return edge != to_index(no_edge);
}

/// By edge, how many more triangles have it from the lower vertex to the higher than the other way.
template <class Scalar>
std::vector<std::int32_t> balances_of(std::span<const TriangleRow<Scalar>> rows,
                                      std::size_t edge_count)
{
    std::vector<std::int32_t> balances(edge_count);
    for (const TriangleRow<Scalar>& row : rows) {
        for (std::size_t k = 0; k < 3; ++k)
            if (is_edge(row.edges[k])) balances[row.edges[k]] += row.backward(k) ? -1 : 1;
    }
    return balances;
}

/// The border's length, by row, in the mesh's unit: each edge counts in the first of its rows.
template <class Scalar>
std::vector<double> borders_of(std::span<const TriangleRow<Scalar>> rows, std::size_t edge_count)
{
    std::vector<std::int32_t> balances = balances_of(rows, edge_count);
    std::vector<double> borders(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (!is_edge(rows[i].edges[k])) continue;
            const auto from = static_cast<int>(k);
            const Vec3 side = rows[i].corner(from == 2 ? 0 : from + 1) - rows[i].corner(from);
            std::int32_t& balance = balances[rows[i].edges[k]];
            borders[i] += std::abs(balance) * side.norm();
            balance = 0;
        }
    }
    return borders;
}

} // namespace

OpenSides::OpenSides(const IndexParts& index) : index_(index)
{
    const std::size_t edges = index.edge_count();
    const std::vector<double> rows = index.double_rows().empty()
                                         ? borders_of(index.float_rows(), edges)
                                         : borders_of(index.double_rows(), edges);
    const WindingClusters& winding = index.signs()->arrays().winding;
    borders_.resize(winding.clusters.size());
    for (std::size_t at = borders_.size(); at-- > 0;) {
        const WindingCluster& cluster = winding.clusters[at];
        if (!winding.is_leaf(at)) {
            borders_[at] = borders_[at + 1] + borders_[winding.clusters[at + 1].next];
            continue;
        }
        for (const std::uint32_t row : winding.order.subspan(cluster.first, cluster.count))
            borders_[at] += rows[row] * winding.unit;
    }
}

std::uint64_t OpenSides::bytes(const IndexParts& index) noexcept
{
    return sizeof(std::int32_t) * std::uint64_t{index.edge_count()} +
           sizeof(double) * (index.ids().size() + index.signs()->arrays().winding.clusters.size());
}

std::optional<bool> OpenSides::side_of(const ClearBall& ball) const noexcept
{
    const WindingClusters& winding = index_.signs()->arrays().winding;
    const double radius = ball.radius * winding.unit;
    // Winding numbers are seldom beyond 0 and 1.
    constexpr double most_change = 0.75;
    const double change = radius * slope_in(ball, most_change / radius);
    if (!(change <= most_change)) return std::nullopt;
    constexpr double tolerance = 0.006;
    const WindingEstimate middle = winding::estimate(
        winding, [&](std::uint32_t row) { return index_.triangle(row); }, ball.middle, tolerance);
    // Much more than solid angles are off by that are seen from off the surface.
    constexpr double rounding = 1e-2;
    const double beyond = middle.value - winding::inside_limit;
    if (!(std::abs(beyond) > middle.error + change + rounding)) return std::nullopt;
    return beyond > 0;
}

double OpenSides::slope_in(const ClearBall& ball, double enough) const noexcept
{
    const WindingClusters& winding = index_.signs()->arrays().winding;
    const double radius = ball.radius * winding.unit;
    const double clearance = (ball.distance - ball.radius) * winding.unit;
    const double most_sum = enough / winding::inverse_sphere;
    double sum = 0;
    for (std::size_t at = 0; at < winding.clusters.size();) {
        const WindingCluster& cluster = winding.clusters[at];
        if (borders_[at] == 0) {
            at = cluster.next;
            continue;
        }
        const Vec3 eye = (ball.middle - Vec3(cluster.center.data())) * winding.unit;
        const double gap = eye.norm() - cluster.radius - radius;
        if (!(gap > cluster.radius) && !winding.is_leaf(at)) {
            ++at;
            continue;
        }
        const double distance = std::max(gap, clearance);
        sum += borders_[at] / (distance * distance);
        if (!(sum <= most_sum)) return std::numeric_limits<double>::infinity();
        at = cluster.next;
    }
    return winding::inverse_sphere * sum * (1 + 0x1p-20);
}

} // namespace proxima
