// The Minkowski sum of a triangle and a cube in closed form (thesis 3.2 to 3.5).
//
//     half-space   outward normal                                    support (vertex j, corner i)
//     0, 1         n, -n          n = e0 x e1                         0, by the signs of the normal
//     2 .. 7       -x, +x, -y, +y, -z, +z                             lowest or highest vertex
//     8 + 3k + i   m = -s (a_k x e_i), s = -1 if n_k < 0, else +1     i, by the signs of the normal
//
// with edges e_i = v_(i+1 mod 3) - v_i and axes a_k. Seen as arcs on the sphere of directions, the
// triangle is three half circles from n to -n and the cube three great circles; each half circle
// meets each great circle once: 9 products, so 17 half-spaces, where the thesis looks through 26.
// One sign per axis serves its three edges, because (a_k x e_i) . (opposite vertex - v_i) = n_k.
// With sign(0) = +1 degenerate triangles and those parallel to an axis need no case of their own:
// facets merge or become 0 <= 0, and where n_k = 0 the three edges supply both sides.
//
// Index tracking (thesis 3.5): the topology does not depend on the cube's size, so neither do the
// supports k = i + 8 j; a half-space of any size follows from the same triangle vertex j and cube
// corner i. triangle_cube_descent.h follows them from cell to child by additions.
//
// The scalar may be any type with + - *, unary -, comparisons, and construction from int; abs is
// found by argument. With std::int64_t and vertices in [0, 2^20] all is exact: |n_k| <= 2^40 (twice
// the area of a triangle in a square of edge 2^20), so n . v <= 3 * 2^60 and a half-size up to 2^20
// adds at most as much: below 2^63.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace proxima {

template <class T>
using Triple = std::array<T, 3>;

template <class T>
using CornerCoordinates = std::array<Triple<T>, 3>;

inline constexpr int triangle_cube_half_spaces = 17;

/// The point of the 24 sums of a triangle vertex and a cube corner that a half-space rests on.
struct SumSupport {
    int triangle_vertex; ///< j, 0 to 2
    int cube_corner;     ///< i, bit 0 = x, bit 1 = y, bit 2 = z; a set bit is the upper half

    /// The thesis's k = i + 8 j; i = k mod 8, j = k div 8.
    [[nodiscard]] constexpr int index() const noexcept { return cube_corner + 8 * triangle_vertex; }
};

/// The sum of a triangle and the cube [-h, h]^3: the centres of all closed cubes that touch it.
template <class T>
class TriangleCubeSum {
public:
    /// An edge's half-space of one axis: inward normal, its two components that are not zero in the
    /// order of the axes after that axis.
    struct EdgeSide {
        T u;      ///< component along axis k + 1 mod 3
        T w;      ///< component along axis k + 2 mod 3
        T offset; ///< inward normal . v_i
        T size;   ///< |u| + |w|
    };

    /// All that does not depend on the cube: 61 flops. The half-size is 0 until it is set.
    explicit TriangleCubeSum(const CornerCoordinates<T>& vertices);

    /// Cubes with these half edges from now on: 27 flops. \pre half_size >= 0
    void set_half_size(const T& half_size);

    /// Boxes with these half edges from now on: 49 flops. \pre all >= 0
    void set_half_sizes(const Triple<T>& half_sizes);

    /// Whether the closed cube around `center` touches the closed triangle: at most 17 comparisons
    /// and 32 flops. Exact if no operation rounds; see the bounds above.
    [[nodiscard]] bool contains(const Triple<T>& center) const;

    /// Outward normal; zero where the triangle has no such facet. \pre half_space in [0, 17)
    [[nodiscard]] Triple<T> normal(int half_space) const;

    /// What the half-space rests on, for every size of the cube. \pre half_space in [0, 17)
    [[nodiscard]] SumSupport support(int half_space) const;

    [[nodiscard]] const CornerCoordinates<T>& vertices() const noexcept { return vertices_; }
    /// The triangle's own normal e0 x e1.
    [[nodiscard]] const Triple<T>& triangle_normal() const noexcept { return normal_; }
    [[nodiscard]] const T& normal_offset() const noexcept { return normal_offset_; } ///< n . v_0
    [[nodiscard]] const T& normal_size() const noexcept { return normal_size_; } ///< sum of |n_k|
    /// \pre axis and edge in [0, 3)
    [[nodiscard]] const EdgeSide& edge_side(int axis, int edge) const noexcept
    {
        return sides_[at(3 * axis + edge)];
    }
    [[nodiscard]] const Triple<T>& lowest() const noexcept { return lowest_; }   ///< bounding box
    [[nodiscard]] const Triple<T>& highest() const noexcept { return highest_; } ///< bounding box

private:
    static constexpr std::size_t at(int index) noexcept { return static_cast<std::size_t>(index); }
    enum class Extreme : std::uint8_t { lowest, highest };
    [[nodiscard]] int extreme_vertex(int axis, Extreme extreme) const;

    CornerCoordinates<T> vertices_;
    Triple<T> normal_;
    T normal_offset_;
    T normal_size_;
    std::array<EdgeSide, 9> sides_; ///< [3 axis + edge]
    Triple<T> lowest_;
    Triple<T> highest_;
    // What the size of the cube adds:
    Triple<T> box_floor_;
    Triple<T> box_ceiling_;
    T plane_floor_;
    T plane_ceiling_;
    std::array<T, 9> side_floor_;
};

template <class T>
TriangleCubeSum<T>::TriangleCubeSum(const CornerCoordinates<T>& vertices)
    : vertices_(vertices), lowest_(vertices[0]), highest_(vertices[0])
{
    using std::abs;
    CornerCoordinates<T> edges;
    for (std::size_t i = 0; i < 3; ++i) // 9 subtractions
        for (std::size_t k = 0; k < 3; ++k) edges[i][k] = vertices[(i + 1) % 3][k] - vertices[i][k];
    for (std::size_t k = 0; k < 3; ++k) { // 9 flops
        const std::size_t u = (k + 1) % 3;
        const std::size_t w = (k + 2) % 3;
        normal_[k] = edges[0][u] * edges[1][w] - edges[0][w] * edges[1][u];
    }
    normal_offset_ = normal_[0] * vertices[0][0] + normal_[1] * vertices[0][1] +
                     normal_[2] * vertices[0][2];                       // 5 flops
    normal_size_ = abs(normal_[0]) + abs(normal_[1]) + abs(normal_[2]); // 2 flops
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t u = (k + 1) % 3;
        const std::size_t w = (k + 2) % 3;
        const bool flip = normal_[k] < T(0);
        for (std::size_t i = 0; i < 3; ++i) { // 9 times 4 flops
            EdgeSide& side = sides_[3 * k + i];
            side.u = flip ? edges[i][w] : -edges[i][w];
            side.w = flip ? -edges[i][u] : edges[i][u];
            side.offset = side.u * vertices[i][u] + side.w * vertices[i][w];
            side.size = abs(side.u) + abs(side.w);
        }
        for (std::size_t i = 1; i < 3; ++i) {
            if (vertices[i][k] < lowest_[k]) lowest_[k] = vertices[i][k];
            if (highest_[k] < vertices[i][k]) highest_[k] = vertices[i][k];
        }
    }
    box_floor_ = lowest_;
    box_ceiling_ = highest_;
    plane_floor_ = normal_offset_;
    plane_ceiling_ = normal_offset_;
    for (std::size_t i = 0; i < 9; ++i) side_floor_[i] = sides_[i].offset;
}

template <class T>
void TriangleCubeSum<T>::set_half_size(const T& half_size)
{
    for (std::size_t k = 0; k < 3; ++k) {
        box_floor_[k] = lowest_[k] - half_size;
        box_ceiling_[k] = highest_[k] + half_size;
    }
    const T reach = half_size * normal_size_;
    plane_floor_ = normal_offset_ - reach;
    plane_ceiling_ = normal_offset_ + reach;
    for (std::size_t i = 0; i < 9; ++i)
        side_floor_[i] = sides_[i].offset - half_size * sides_[i].size;
}

template <class T>
void TriangleCubeSum<T>::set_half_sizes(const Triple<T>& half_sizes)
{
    using std::abs;
    for (std::size_t k = 0; k < 3; ++k) {
        box_floor_[k] = lowest_[k] - half_sizes[k];
        box_ceiling_[k] = highest_[k] + half_sizes[k];
    }
    const T reach = half_sizes[0] * abs(normal_[0]) + half_sizes[1] * abs(normal_[1]) +
                    half_sizes[2] * abs(normal_[2]);
    plane_floor_ = normal_offset_ - reach;
    plane_ceiling_ = normal_offset_ + reach;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
            const EdgeSide& side = sides_[3 * k + i];
            side_floor_[3 * k + i] = side.offset - (half_sizes[(k + 1) % 3] * abs(side.u) +
                                                    half_sizes[(k + 2) % 3] * abs(side.w));
        }
    }
}

template <class T>
bool TriangleCubeSum<T>::contains(const Triple<T>& center) const
{
    for (std::size_t k = 0; k < 3; ++k) // 6 comparisons
        if (center[k] < box_floor_[k] || box_ceiling_[k] < center[k]) return false;
    const T along =
        normal_[0] * center[0] + normal_[1] * center[1] + normal_[2] * center[2]; // 5 flops
    if (along < plane_floor_ || plane_ceiling_ < along) return false;             // 2 comparisons
    for (std::size_t k = 0; k < 3; ++k) {
        const T& center_u = center[(k + 1) % 3];
        const T& center_w = center[(k + 2) % 3];
        for (std::size_t i = 0; i < 3; ++i) { // 9 times 3 flops and a comparison
            const EdgeSide& side = sides_[3 * k + i];
            if (side.u * center_u + side.w * center_w < side_floor_[3 * k + i]) return false;
        }
    }
    return true;
}

template <class T>
Triple<T> TriangleCubeSum<T>::normal(int half_space) const
{
    Triple<T> result = {T(0), T(0), T(0)};
    if (half_space < 2) {
        for (std::size_t k = 0; k < 3; ++k) result[k] = half_space == 0 ? normal_[k] : -normal_[k];
    } else if (half_space < 8) {
        const int box_side = half_space - 2;
        result[at(box_side / 2)] = box_side % 2 == 0 ? T(-1) : T(1);
    } else {
        const int axis = (half_space - 8) / 3;
        const EdgeSide& side = sides_[at(half_space - 8)];
        result[at((axis + 1) % 3)] = -side.u;
        result[at((axis + 2) % 3)] = -side.w;
    }
    return result;
}

template <class T>
int TriangleCubeSum<T>::extreme_vertex(int axis, Extreme extreme) const
{
    int best = 0;
    for (int j = 1; j < 3; ++j) {
        const T& value = vertices_[at(j)][at(axis)];
        const T& best_value = vertices_[at(best)][at(axis)];
        const bool is_better =
            extreme == Extreme::highest ? best_value < value : value < best_value;
        if (is_better) best = j;
    }
    return best;
}

template <class T>
SumSupport TriangleCubeSum<T>::support(int half_space) const
{
    const Triple<T> outward = normal(half_space);
    SumSupport result = {0, 0};
    for (int k = 0; k < 3; ++k)
        if (T(0) < outward[at(k)]) result.cube_corner |= 1 << k;
    if (half_space >= 8) {
        result.triangle_vertex = (half_space - 8) % 3;
    } else if (half_space >= 2) {
        const Extreme extreme = half_space % 2 == 1 ? Extreme::highest : Extreme::lowest;
        result.triangle_vertex = extreme_vertex((half_space - 2) / 2, extreme);
    }
    return result;
}

extern template class TriangleCubeSum<double>;
extern template class TriangleCubeSum<std::int64_t>;

} // namespace proxima
