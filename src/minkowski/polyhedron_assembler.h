// Puts a convex polyhedron together from what is known of its surface.
#pragma once

#include "minkowski/quickhull.h"
#include "proxima/convex_polyhedron.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Internal to the makers of polyhedra: the only one that fills a ConvexPolyhedron.
class PROXIMA_HIDDEN PolyhedronAssembler {
public:
    /// A point, a segment, or a half-line. \pre `vertices` are extreme: one point, and at most one
    /// other point or ray.
    [[nodiscard]] static ConvexPolyhedron line(const detail::HullVertices& vertices,
                                               std::span<const std::uint32_t> extreme);

    /// A polygon, with this loop in front and its reverse behind. \pre every vertex of the loop is
    /// extreme, rays stand together, one vertex at least is a point
    [[nodiscard]] static ConvexPolyhedron polygon(const detail::HullVertices& vertices,
                                                  std::span<const std::uint32_t> loop);

    /// A body, coplanar triangles merged and what is not extreme left out.
    [[nodiscard]] static ConvexPolyhedron body(const detail::HullVertices& vertices,
                                               std::span<const detail::HullTriangle> triangles);

    /// The loop of the facet whose triangles all have none of their vertices at `apex`; for the
    /// hull of a polygon and one vertex off its plane. \pre it is a pyramid
    [[nodiscard]] static std::vector<std::uint32_t>
    base_of_pyramid(const detail::HullVertices& vertices,
                    std::span<const detail::HullTriangle> triangles, std::uint32_t apex);

private:
    explicit PolyhedronAssembler(const detail::HullVertices& vertices) : input_(vertices) {}

    /// Loops of merged coplanar triangles, as input vertices, extreme ones only.
    void merge_triangles(std::span<const detail::HullTriangle> triangles);
    void find_groups(std::span<const detail::HullTriangle> triangles);
    [[nodiscard]] bool is_extreme(std::uint32_t vertex) const;
    void append_loop(std::span<const std::uint32_t> loop);

    /// Takes over the input vertices in `extreme`, which ascends.
    void keep_vertices(std::vector<std::uint32_t> extreme);
    void keep_loops();
    void keep_facets();
    void gather_stars();

    detail::HullVertices input_;
    std::vector<std::uint32_t> loop_vertices_; ///< as input vertices
    std::vector<std::uint32_t> loop_first_ = {0};
    std::vector<std::uint32_t> group_; ///< the facet of each triangle
    std::vector<std::array<std::uint32_t, 3>> groups_of_vertex_;
    ConvexPolyhedron result_;
};

} // namespace proxima
