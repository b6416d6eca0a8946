// Points that the soak asks for.
//
//     volume         1.2 times the mesh's box, uniformly
//     near_surface   up to 1 % of the diagonal from a point of the surface
//     boundaries     on sides, edges and corners of cells; where two features are as close: above
//                    their common border, between them, where halving finds the change
//     outside        outside of the root, to a million times its size
#pragma once

#include "proxima/mesh_index.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

namespace proxima::soak {

enum class PointSet : std::uint8_t { volume, near_surface, boundaries, outside };
inline constexpr std::array all_point_sets = {PointSet::volume, PointSet::near_surface,
                                              PointSet::boundaries, PointSet::outside};
[[nodiscard]] std::string_view name_of(PointSet set) noexcept;

/// Refers to what it is given. Members may be called from any thread.
class PointMaker {
public:
    PointMaker(const TriangleMesh& mesh, const Topology& topology, const MeshIndex& listed);

    /// The same for the same seed. Finite.
    [[nodiscard]] std::vector<Vec3> make(PointSet set, std::size_t count, std::uint64_t seed) const;

    [[nodiscard]] double diagonal() const noexcept { return diagonal_; }

private:
    using Random = std::mt19937_64;

    [[nodiscard]] Vec3 in_volume(Random& random) const;
    [[nodiscard]] Vec3 on_surface(Random& random) const;
    [[nodiscard]] Vec3 near_surface(Random& random) const;
    [[nodiscard]] Vec3 outside(Random& random) const;
    [[nodiscard]] Vec3 on_boundary(std::size_t kind, Random& random) const;
    [[nodiscard]] Vec3 on_cell(Vec3 point, Random& random) const;
    [[nodiscard]] Vec3 above_vertex(Random& random) const;
    [[nodiscard]] Vec3 above_edge(Random& random) const;
    [[nodiscard]] Vec3 above_circumcentre(Random& random) const;
    [[nodiscard]] Vec3 between_features(Random& random) const;
    [[nodiscard]] TriangleId any_triangle(Random& random) const;
    [[nodiscard]] Vec3 height_over(TriangleId triangle, Random& random) const;

    const TriangleMesh& mesh_;
    const Topology& topology_;
    const MeshIndex& index_;
    Box box_;
    double diagonal_ = 0;
    std::vector<double> areas_; ///< running sums
};

} // namespace proxima::soak
