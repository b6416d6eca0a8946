// Follows a triangle from octree cell to children by additions alone (thesis 3.4, 3.5).
//
//     value of a half-space at the cell's lower corner   K = m' . (corner - v),  m' = -m inward
//     a child's                                          K' = K + sum of h m'_k over the set bits
//                                                             of its octant, h = its edge
//     the closed child is not beyond it                  K' >= -h (sum of positive m'_k)
//
// The right side and h m' belong to a depth and halve with it, so nothing is ever multiplied. An
// edge has only two components: four values serve eight children. The eight children together cost
// 9 * 3 + 7 = 34 additions (4.25 per child), 36 + 16 comparisons, and box comparisons.
//
// In std::int64_t, with vertices snapped to the grid [0, 2^20], all is exact down to depth 19 (and
// one more): K is the value at a corner inside the root of a linear function that vanishes in the
// root, so |K| <= 2^20 (|m'_u| + |m'_w|) <= 2^41 for an edge and 2^20 |n|_1 <= 3 * 2^60 for the
// plane (|n_k| <= 2^40); h m' starts at 2^19 m' and is a multiple of the depth's h, so halving it
// never drops a bit; what inflation adds is 2 * |n|_1 <= 6 * 2^40 per unit. All is below 2^62.
//
// Inflation by `margin` replaces the triangle by its sum with the cube [-margin, margin]^3.
// Snapping moves a vertex by at most half a unit per axis, and so every point of the triangle: with
// a margin of one unit no cell that the original triangle touches is missed. It adds margin (|m_u|
// + |m_w|) to K at the root; the recurrence does not see it.
#pragma once

#include "thesis/octree_generation/triangle_cube_sum.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace proxima {

/// The planes between and around the children of a cell.
template <class T>
struct CellPlanes {
    Triple<T> lower;
    Triple<T> middle;
    Triple<T> upper;
};

/// Octants whose bit `axis` is set, as a mask of eight bits.
[[nodiscard]] constexpr unsigned upper_octants(int axis) noexcept
{
    constexpr std::array<unsigned, 3> masks = {0xAAU, 0xCCU, 0xF0U};
    return masks[static_cast<std::size_t>(axis)];
}

/// Children (closed) that the closed box touches, as a mask of octants: at most 12 comparisons.
///
/// Free accept 1: if the mask of a convex set's bounding box has one bit, and the set touches the
/// cell, it touches that child: the cell is the union of its children, and the set's box, so the
/// set, touches no other. Free accept 2: a child that touches a part of the set touches the set;
/// with the box around a vertex (the vertex itself, or inflated) this needs no half-space.
template <class T>
[[nodiscard]] unsigned octants_touched(const Triple<T>& box_lower, const Triple<T>& box_upper,
                                       const CellPlanes<T>& planes)
{
    unsigned touched = 0xFFU;
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        const unsigned upper = upper_octants(axis);
        const unsigned low = static_cast<unsigned>(planes.lower[k] <= box_upper[k]) &
                             static_cast<unsigned>(box_lower[k] <= planes.middle[k]);
        const unsigned high = static_cast<unsigned>(planes.middle[k] <= box_upper[k]) &
                              static_cast<unsigned>(box_lower[k] <= planes.upper[k]);
        touched &= low * (0xFFU & ~upper) | high * upper;
    }
    return touched;
}

/// One triangle's way down an octree whose root is [0, root_edge]^3.
template <class T>
class TriangleCubeDescent {
public:
    /// What all cells of a depth share, for the test of their children.
    struct Level {
        std::array<std::array<T, 2>, 9> side_step; ///< h m', [3 axis + edge][u, w]
        std::array<T, 9> side_floor;
        Triple<T> normal_step; ///< h n
        T plane_floor;
        T plane_reach; ///< the ceiling without inflation
        T plane_ceiling;
    };

    /// What one cell adds: the values at its lower corner.
    struct Cell {
        std::array<T, 9> side;
        T plane;
    };

    /// Cost: the sum's 61 flops, 35 for the root's level, 46 for a margin.
    /// \pre vertices in [0, root_edge], margin >= 0; with integers root_edge a power of two
    TriangleCubeDescent(const CornerCoordinates<T>& vertices, const T& root_edge, const T& margin);

    [[nodiscard]] const Level& root_level() const noexcept { return root_level_; }
    [[nodiscard]] const Cell& root_cell() const noexcept { return root_cell_; }

    /// The level below. \pre with integers, the level's cells have an edge of at least 4 units
    [[nodiscard]] Level next_level(const Level& level) const;

    /// The cell's child: 21 additions at most. `level` is the parent's.
    [[nodiscard]] static Cell child(const Level& level, const Cell& cell, int octant);

    /// Children whose plane and edge half-spaces all hold: 34 additions. With the children that the
    /// bounding box touches (box_octants) that is the exact answer.
    [[nodiscard]] static unsigned half_space_octants(const Level& level, const Cell& cell);

    /// Children that the bounding box touches.
    [[nodiscard]] unsigned box_octants(const CellPlanes<T>& planes) const
    {
        return octants_touched(lower_, upper_, planes);
    }

    /// Children that a vertex (inflated) touches.
    [[nodiscard]] unsigned vertex_octants(const CellPlanes<T>& planes) const;

    /// Children that the triangle (inflated) touches: free accept 1, else all half-spaces (their 34
    /// additions are cheaper than asking for vertices first and branching on what is open).
    /// \pre the triangle touches the cell
    [[nodiscard]] unsigned overlapped_octants(const Level& level, const Cell& cell,
                                              const CellPlanes<T>& planes) const;

private:
    static constexpr std::size_t at(int index) noexcept { return static_cast<std::size_t>(index); }

    static T halved(const T& value)
    {
        if constexpr (std::is_integral_v<T>) {
            return value >> 1;
        } else {
            return value * T(0.5);
        }
    }

    [[nodiscard]] static unsigned plane_octants(const Level& level, const Cell& cell);

    template <int Axis>
    [[nodiscard]] static unsigned side_octants(const Level& level, const Cell& cell);

    Level root_level_;
    Cell root_cell_;
    T plane_slack_;   ///< what inflation adds to the ceiling of the plane's value
    Triple<T> lower_; ///< bounding box, inflated
    Triple<T> upper_;
    CornerCoordinates<T> vertex_lower_; ///< vertices, inflated
    CornerCoordinates<T> vertex_upper_;
};

template <class T>
TriangleCubeDescent<T>::TriangleCubeDescent(const CornerCoordinates<T>& vertices,
                                            const T& root_edge, const T& margin)
    : plane_slack_(T(0)), vertex_lower_(vertices), vertex_upper_(vertices)
{
    const TriangleCubeSum<T> sum(vertices);
    const T half = halved(root_edge);
    const auto positive = [](const T& value) { return T(0) < value ? value : T(0); };
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            const auto& side = sum.edge_side(k, i);
            const std::size_t index = at(3 * k + i);
            const T step_u = half * side.u;
            const T step_w = half * side.w;
            root_level_.side_step[index] = {step_u, step_w};
            root_level_.side_floor[index] = -(positive(step_u) + positive(step_w));
            root_cell_.side[index] = -side.offset;
        }
        root_level_.normal_step[at(k)] = half * sum.triangle_normal()[at(k)];
    }
    const Triple<T>& step = root_level_.normal_step;
    root_level_.plane_floor = -(positive(step[0]) + positive(step[1]) + positive(step[2]));
    root_level_.plane_reach = positive(-step[0]) + positive(-step[1]) + positive(-step[2]);
    root_level_.plane_ceiling = root_level_.plane_reach;
    root_cell_.plane = -sum.normal_offset();
    lower_ = sum.lowest();
    upper_ = sum.highest();
    if (!(T(0) < margin)) return;
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
            const std::size_t index = at(3 * k + i);
            root_cell_.side[index] = root_cell_.side[index] + margin * sum.edge_side(k, i).size;
            vertex_lower_[at(i)][at(k)] = vertices[at(i)][at(k)] - margin;
            vertex_upper_[at(i)][at(k)] = vertices[at(i)][at(k)] + margin;
        }
        lower_[at(k)] = lower_[at(k)] - margin;
        upper_[at(k)] = upper_[at(k)] + margin;
    }
    const T slack = margin * sum.normal_size();
    root_cell_.plane = root_cell_.plane + slack;
    plane_slack_ = slack + slack;
    root_level_.plane_ceiling = root_level_.plane_reach + plane_slack_;
}

template <class T>
auto TriangleCubeDescent<T>::next_level(const Level& level) const -> Level
{
    Level next;
    for (std::size_t i = 0; i < 9; ++i) {
        next.side_step[i] = {halved(level.side_step[i][0]), halved(level.side_step[i][1])};
        next.side_floor[i] = halved(level.side_floor[i]);
    }
    for (std::size_t k = 0; k < 3; ++k) next.normal_step[k] = halved(level.normal_step[k]);
    next.plane_floor = halved(level.plane_floor);
    next.plane_reach = halved(level.plane_reach);
    next.plane_ceiling = next.plane_reach + plane_slack_;
    return next;
}

template <class T>
auto TriangleCubeDescent<T>::child(const Level& level, const Cell& cell, int octant) -> Cell
{
    Cell result = cell;
    for (int axis = 0; axis < 3; ++axis) {
        if ((octant >> axis & 1) == 0) continue;
        // The axis is the second after (w of) the axis one further, the first after (u of) the
        // next.
        const int with_u = 3 * ((axis + 2) % 3);
        const int with_w = 3 * ((axis + 1) % 3);
        for (int edge = 0; edge < 3; ++edge) {
            const std::size_t first = at(with_u + edge);
            const std::size_t second = at(with_w + edge);
            result.side[first] = result.side[first] + level.side_step[first][0];
            result.side[second] = result.side[second] + level.side_step[second][1];
        }
        result.plane = result.plane + level.normal_step[at(axis)];
    }
    return result;
}

template <class T>
unsigned TriangleCubeDescent<T>::plane_octants(const Level& level, const Cell& cell)
{
    std::array<T, 8> value;
    value[0] = cell.plane;
    for (std::size_t octant = 1; octant < 8; ++octant) { // 7 additions: one bit more each
        const auto bit = static_cast<std::size_t>(std::countr_zero(octant));
        value[octant] = value[octant & (octant - 1)] + level.normal_step[bit];
    }
    unsigned open = 0;
    for (std::size_t octant = 0; octant < 8; ++octant) {
        const bool crossed =
            level.plane_floor <= value[octant] && value[octant] <= level.plane_ceiling;
        open |= static_cast<unsigned>(crossed) << octant;
    }
    return open;
}

template <class T>
template <int Axis>
unsigned TriangleCubeDescent<T>::side_octants(const Level& level, const Cell& cell)
{
    constexpr unsigned u = upper_octants((Axis + 1) % 3);
    constexpr unsigned w = upper_octants((Axis + 2) % 3);
    unsigned open = 0xFFU;
    for (std::size_t index = at(3 * Axis); index < at(3 * Axis + 3); ++index) {
        const T& floor = level.side_floor[index];
        const T& low_low = cell.side[index];
        const T high_low = low_low + level.side_step[index][0];
        const T low_high = low_low + level.side_step[index][1];
        const T high_high = high_low + level.side_step[index][1];
        unsigned beyond = 0; // branches here would be unpredictable
        beyond |= static_cast<unsigned>(low_low < floor) * (~u & ~w);
        beyond |= static_cast<unsigned>(high_low < floor) * (u & ~w);
        beyond |= static_cast<unsigned>(low_high < floor) * (~u & w);
        beyond |= static_cast<unsigned>(high_high < floor) * (u & w);
        open &= ~beyond;
    }
    return open;
}

template <class T>
unsigned TriangleCubeDescent<T>::half_space_octants(const Level& level, const Cell& cell)
{
    return plane_octants(level, cell) & side_octants<0>(level, cell) &
           side_octants<1>(level, cell) & side_octants<2>(level, cell);
}

template <class T>
unsigned TriangleCubeDescent<T>::vertex_octants(const CellPlanes<T>& planes) const
{
    unsigned touched = 0;
    for (std::size_t j = 0; j < 3; ++j)
        touched |= octants_touched(vertex_lower_[j], vertex_upper_[j], planes);
    return touched;
}

template <class T>
unsigned TriangleCubeDescent<T>::overlapped_octants(const Level& level, const Cell& cell,
                                                    const CellPlanes<T>& planes) const
{
    const unsigned boxed = box_octants(planes);
    if (std::has_single_bit(boxed)) return boxed;
    return boxed & half_space_octants(level, cell);
}

extern template class TriangleCubeDescent<double>;
extern template class TriangleCubeDescent<std::int64_t>;

} // namespace proxima
