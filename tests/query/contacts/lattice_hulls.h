// Hulls with small whole coordinates, whose contours meet themselves, and these contours by all pairs of triangles.
#pragma once

#include "geometry/triangle_contact.h"
#include "proxima/geometry.h"
#include "proxima/minkowski_sum.h"
#include "proxima/triangle_mesh.h"
#include "query/contacts/solid_shapes.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

namespace proxima::testing {

/// A hull of points with small whole coordinates: its edges often meet another one's edges and corners.
inline TriangleMesh lattice_hull(std::mt19937_64& random)
{
    for (;;) {
        std::vector<Vec3> points;
        const auto whole = [&] { return static_cast<double>(random() % 5U); };
        for (int i = 0; i < 7; ++i) {
            const double x = whole();
            const double y = whole();
            points.emplace_back(x, y, whole());
        }
        const auto hull = convex_hull(points);
        if (hull && hull->dimension() == 3) return surface_of(*hull);
    }
}

struct BruteSegment {
    Vec3 from;
    Vec3 to;
};

/// What different points of lattice hulls' contours are apart at least, and more than roundings of them.
inline constexpr double one_point = 1e-9;

inline bool have_common_point(const BruteSegment& s, const BruteSegment& t)
{
    const auto distance_from = [](const Vec3& p, const BruteSegment& segment) {
        const Vec3 along = segment.to - segment.from;
        const double part =
            std::clamp((p - segment.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
        return (segment.from + part * along - p).norm();
    };
    // Segments of contours do not cross: one of them ends there.
    return distance_from(s.from, t) < one_point || distance_from(s.to, t) < one_point ||
           distance_from(t.from, s) < one_point || distance_from(t.to, s) < one_point;
}

/// The segments in which triangles of lattice hulls meet, each once; nothing where triangles that meet lie in
/// one plane, or meet in a point that is on no segment.
inline std::optional<std::vector<BruteSegment>> segments_by_brute_force(const TriangleMesh& a,
                                                                        const TriangleMesh& b)
{
    std::vector<BruteSegment> segments;
    std::vector<Vec3> alone;
    const auto add_ends = [](const Triangle& edges, const Triangle& face, std::vector<Vec3>& ends) {
        const Vec3 normal = (face[1] - face[0]).cross(face[2] - face[0]); // whole numbers
        for (int i = 0; i < 3; ++i) {
            const Vec3& p = edges[i];
            const Vec3& q = edges[(i + 1) % 3];
            if (!segment_meets_triangle(p, q, face)) continue;
            const double above = normal.dot(p - face[0]);
            const double below = normal.dot(q - face[0]);
            if (above != below) ends.push_back(p + above / (above - below) * (q - p));
        }
    };
    for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
        for (std::uint32_t k = 0; k < b.triangle_count(); ++k) {
            const Triangle s = a.triangle(TriangleId{i});
            const Triangle t = b.triangle(TriangleId{k});
            if (!triangles_meet(s, t)) continue;
            const Vec3 normal = (s[1] - s[0]).cross(s[2] - s[0]);
            if (normal.cross((t[1] - t[0]).cross(t[2] - t[0])).isZero(0)) return std::nullopt;
            std::vector<Vec3> ends;
            add_ends(s, t, ends);
            add_ends(t, s, ends);
            BruteSegment longest = {ends.at(0), ends.at(0)};
            for (const Vec3& end : ends) {
                if ((end - longest.from).norm() > (longest.to - longest.from).norm())
                    longest.to = end;
            }
            if ((longest.to - longest.from).norm() < one_point) {
                alone.push_back(longest.from);
                continue;
            }
            const auto is_same = [&](const BruteSegment& other) {
                const auto near = [](const Vec3& p, const Vec3& q) {
                    return (p - q).norm() < one_point;
                };
                return (near(other.from, longest.from) && near(other.to, longest.to)) ||
                       (near(other.from, longest.to) && near(other.to, longest.from));
            };
            if (std::ranges::none_of(segments, is_same)) segments.push_back(longest);
        }
    }
    for (const Vec3& p : alone) {
        const auto is_on = [&](const BruteSegment& segment) {
            return (segment.from - p).norm() < one_point || (segment.to - p).norm() < one_point;
        };
        if (std::ranges::none_of(segments, is_on)) return std::nullopt;
    }
    return segments;
}

/// Lengths of what is connected of segments.
inline std::vector<double> connected_lengths(const std::vector<BruteSegment>& segments)
{
    std::vector<std::size_t> joined_to(segments.size());
    std::iota(joined_to.begin(), joined_to.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (joined_to[i] != i) i = joined_to[i];
        return i;
    };
    for (std::size_t i = 0; i < segments.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k)
            if (have_common_point(segments[i], segments[k])) joined_to[root(i)] = root(k);
    }
    std::map<std::size_t, double> sums;
    for (std::size_t i = 0; i < segments.size(); ++i)
        sums[root(i)] += (segments[i].to - segments[i].from).norm();
    std::vector<double> lengths;
    for (const auto& [number, length] : sums) lengths.push_back(length);
    std::ranges::sort(lengths);
    return lengths;
}

} // namespace proxima::testing
