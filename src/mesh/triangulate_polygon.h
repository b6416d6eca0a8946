// Cutting polygons into triangles.
//
//     convex: a fan         concave: ears
//     3-----2               4---3   2     ear = corner whose triangle lies inside
//     |   / |               |    \ / \    and holds no other corner
//     | /   |               |     x   \   [meisters-1975]
//     0-----1               0----------1
#pragma once

#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// Concave polygons of more corners are refused: ears cost the square of the corners.
inline constexpr std::size_t max_concave_corners = std::size_t{1} << 14U;

/// Triangulates polygons one after the other; keeps its scratch between them. Not thread safe.
class PolygonTriangulator {
public:
    /// Cuts the polygon with the given corners, indices into `positions`, into corners.size() - 2
    /// triangles of the same orientation, which use every corner. A fan from the first corner where
    /// all its triangles face like the polygon; otherwise ears, found in the plane of the polygon's
    /// area vector, first corners first. A simple planar polygon is covered exactly once; what is
    /// not simple or has no area still gives all its triangles. Deterministic.
    /// Returns false where the polygon is no fan and has more than max_concave_corners.
    /// \pre triangles.size() + 2 == corners.size() >= 3
    [[nodiscard]] bool triangulate(std::span<const std::uint32_t> corners,
                                   std::span<const Vec3> positions,
                                   std::span<TriangleCorners> triangles);

private:
    struct Corner {
        Vec2 position;
        std::uint32_t previous = 0;
        std::uint32_t next = 0;
        bool waiting = false; ///< in the queue of possible ears
        bool removed = false;
        bool blocks = false; ///< not convex: only such corners can spoil an ear
    };

    [[nodiscard]] bool triangulate_scaled(std::span<const std::uint32_t> corners,
                                          std::span<const Vec3> positions,
                                          std::span<TriangleCorners> triangles);
    void flatten(std::span<const std::uint32_t> corners, std::span<const Vec3> positions,
                 const Vec3& area);
    [[nodiscard]] double turn(std::uint32_t corner) const noexcept;
    [[nodiscard]] bool is_ear(std::uint32_t corner);
    [[nodiscard]] std::uint32_t corner_of_last_resort() const noexcept;
    void remove(std::uint32_t corner);
    void enqueue(std::uint32_t corner);

    std::vector<Corner> ring_;
    std::vector<std::uint32_t> queue_;
    std::vector<std::uint32_t> blockers_; ///< the corners that blocked at the start
};

} // namespace proxima
