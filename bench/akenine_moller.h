// The usual way to build an octree, as a peer: recursive, one triangle and one cell at a time, with
// the early-out triangle-box test of [akenine-moller-2001] in floats. Cheap box comparisons come
// first, then the nine edge axes, then the plane.
#pragma once

#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

namespace proxima::bench {

using FloatPoint = std::array<float, 3>;

class AkenineMollerOctree {
public:
    AkenineMollerOctree(const TriangleMesh& mesh, const OctreeFrame& frame, int max_depth,
                        std::uint32_t threshold)
        : max_depth_(max_depth), threshold_(threshold),
          scratch_(static_cast<std::size_t>(max_depth) + 1)
    {
        corners_.reserve(mesh.triangle_count());
        for (const TriangleCorners& corners : mesh.triangles()) {
            std::array<FloatPoint, 3> triangle;
            for (std::size_t j = 0; j < 3; ++j) {
                const Vec3& position = mesh.positions()[corners[j]];
                for (int axis = 0; axis < 3; ++axis) {
                    triangle[j][static_cast<std::size_t>(axis)] =
                        static_cast<float>(position[axis]);
                }
            }
            corners_.push_back(triangle);
        }
        std::vector<std::uint32_t> all(mesh.triangle_count());
        std::iota(all.begin(), all.end(), 0U);
        const Vec3 center = frame.lower + frame.edge / 2;
        grow(all,
             {static_cast<float>(center[0]), static_cast<float>(center[1]),
              static_cast<float>(center[2])},
             static_cast<float>(frame.edge[0] / 2), 0);
    }

    [[nodiscard]] const std::vector<std::uint32_t>& references() const { return references_; }
    [[nodiscard]] std::uint64_t cell_count() const { return cells_; }
    /// (triangle, split cell) pairs: each is tested against eight children.
    [[nodiscard]] std::uint64_t pair_count() const { return pairs_; }

private:
    static bool axis_separates(float p, float q, float radius)
    {
        return std::min(p, q) > radius || std::max(p, q) < -radius;
    }

    static bool overlaps(const std::array<FloatPoint, 3>& triangle, const FloatPoint& center,
                         float half)
    {
        std::array<FloatPoint, 3> v;
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t j = 0; j < 3; ++j) v[j][k] = triangle[j][k] - center[k];
            if (std::min({v[0][k], v[1][k], v[2][k]}) > half ||
                std::max({v[0][k], v[1][k], v[2][k]}) < -half) {
                return false;
            }
        }
        std::array<FloatPoint, 3> e;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) e[j][k] = v[(j + 1) % 3][k] - v[j][k];
            const FloatPoint f = {std::fabs(e[j][0]), std::fabs(e[j][1]), std::fabs(e[j][2])};
            const FloatPoint& a = v[j];
            const FloatPoint& b = v[(j + 2) % 3];
            if (axis_separates(e[j][2] * a[1] - e[j][1] * a[2], e[j][2] * b[1] - e[j][1] * b[2],
                               (f[2] + f[1]) * half) ||
                axis_separates(e[j][0] * a[2] - e[j][2] * a[0], e[j][0] * b[2] - e[j][2] * b[0],
                               (f[2] + f[0]) * half) ||
                axis_separates(e[j][1] * a[0] - e[j][0] * a[1], e[j][1] * b[0] - e[j][0] * b[1],
                               (f[1] + f[0]) * half)) {
                return false;
            }
        }
        const FloatPoint n = {e[0][1] * e[1][2] - e[0][2] * e[1][1],
                              e[0][2] * e[1][0] - e[0][0] * e[1][2],
                              e[0][0] * e[1][1] - e[0][1] * e[1][0]};
        const float radius = half * (std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2]));
        return std::fabs(n[0] * v[0][0] + n[1] * v[0][1] + n[2] * v[0][2]) <= radius;
    }

    void grow(const std::vector<std::uint32_t>& triangles, const FloatPoint& center, float half,
              int depth)
    {
        ++cells_;
        if (triangles.size() <= threshold_ || depth == max_depth_) {
            references_.insert(references_.end(), triangles.begin(), triangles.end());
            return;
        }
        pairs_ += triangles.size();
        const float quarter = half / 2;
        for (unsigned octant = 0; octant < 8; ++octant) {
            FloatPoint child = center;
            for (unsigned axis = 0; axis < 3; ++axis) {
                child[axis] += (octant >> axis & 1U) != 0 ? quarter : -quarter;
            }
            std::vector<std::uint32_t>& inside = scratch_[static_cast<std::size_t>(depth)];
            inside.clear();
            for (const std::uint32_t triangle : triangles) {
                if (overlaps(corners_[triangle], child, quarter)) inside.push_back(triangle);
            }
            grow(inside, child, quarter, depth + 1);
        }
    }

    int max_depth_;
    std::uint32_t threshold_;
    std::vector<std::array<FloatPoint, 3>> corners_;
    std::vector<std::vector<std::uint32_t>> scratch_; ///< one list per depth, reused
    std::vector<std::uint32_t> references_;
    std::uint64_t cells_ = 0;
    std::uint64_t pairs_ = 0;
};

} // namespace proxima::bench
