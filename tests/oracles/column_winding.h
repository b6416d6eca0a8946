// The winding number of a closed mesh along vertical lines: exact as exact_winding.h, of which it
// asks only the triangles in the point's column, so that a million points are a matter of seconds.
#pragma once

#include "oracles/exact_winding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace proxima::oracle {

/// Refers to the mesh.
class ColumnWinding {
public:
    explicit ColumnWinding(const TriangleMesh& mesh) : mesh_(mesh), box_(bounding_box(mesh))
    {
        side_ = std::clamp(static_cast<int>(std::sqrt(mesh.triangle_count())), 1, 512);
        columns_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            const Triangle t = mesh.triangle(TriangleId{i});
            const Vec3 lower = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
            const Vec3 upper = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
            // place() is monotonous, so no triangle over a point is missed.
            for (int y = place(lower, 1); y <= place(upper, 1); ++y) {
                for (int x = place(lower, 0); x <= place(upper, 0); ++x)
                    columns_[column(x, y)].push_back(TriangleId{i});
            }
        }
    }

    /// How often the mesh winds round p; nothing if p is on it.
    [[nodiscard]] std::optional<int> at(const Vec3& p) const
    {
        if (!box_.contains(p)) return 0;
        const Vec3 far(p.x(), p.y(), box_.upper.z() + box_.extent().maxCoeff());
        if (const auto sum = crossings(mesh_, columns_[column(place(p, 0), place(p, 1))], p, far))
            return sum;
        return exact_winding(mesh_, p);
    }

private:
    [[nodiscard]] int place(const Vec3& p, int axis) const
    {
        const double extent = box_.extent()[axis];
        const double part = extent > 0 ? (p[axis] - box_.lower[axis]) / extent : 0;
        return std::clamp(static_cast<int>(part * side_), 0, side_ - 1);
    }
    [[nodiscard]] std::size_t column(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
               static_cast<std::size_t>(x);
    }

    const TriangleMesh& mesh_;
    Box box_;
    int side_ = 1;
    std::vector<std::vector<TriangleId>> columns_;
};

} // namespace proxima::oracle
