// Whether a Voronoi region meets a box, by trying all corners that planes can have, in 113-bit
// numbers: the half-spaces of the thesis's equations (4.3), (4.7) and (4.11), not the rays that the
// library makes regions of.
#pragma once

#include "oracles/quad_distance.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cmath>
#include <vector>

namespace proxima::oracle {

/// normal . x <= offset, the normal of length 1 but for 64-bit rounding.
struct QuadPlane {
    QuadPoint normal;
    Quad offset = 0;
};

inline QuadPlane plane_through(const Vec3& point, const QuadPoint& normal)
{
    const Quad length = root(dot(normal, normal));
    const QuadPoint unit = (1 / length) * normal;
    return {unit, dot(unit, QuadPoint(point))};
}

inline QuadPoint quad_normal(const Triangle& t)
{
    const QuadPoint a(t[0]);
    return cross(QuadPoint(t[1]) - a, QuadPoint(t[2]) - a);
}

/// The local region of a feature: equal to its exterior Voronoi region on a convex mesh.
inline std::vector<QuadPlane> region_planes(const TriangleMesh& mesh, const Topology& topology,
                                            Feature feature)
{
    std::vector<QuadPlane> planes;
    switch (feature.kind) {
    case FeatureKind::vertex: {
        const VertexId v{feature.id};
        for (const EdgeId edge : topology.edges(v)) {
            const Vec3& w = mesh.position(topology.other_end(edge, v));
            planes.push_back(
                plane_through(mesh.position(v), QuadPoint(w) - QuadPoint(mesh.position(v))));
        }
        break;
    }
    case FeatureKind::edge: {
        const auto [low, high] = topology.vertices(EdgeId{feature.id});
        const Vec3& p = mesh.position(low);
        const Vec3& q = mesh.position(high);
        const QuadPoint along = QuadPoint(q) - QuadPoint(p);
        planes.push_back(plane_through(q, along));
        planes.push_back(plane_through(p, Quad(-1) * along));
        for (const TriangleId t : topology.triangles(EdgeId{feature.id})) {
            // Outward in the face: away from its third corner.
            QuadPoint outward = cross(along, quad_normal(mesh.triangle(t)));
            for (const Vec3& corner : mesh.triangle(t).vertices) {
                const bool third = corner != p && corner != q;
                if (third && dot(outward, QuadPoint(corner) - QuadPoint(p)) > 0)
                    outward = Quad(-1) * outward;
            }
            planes.push_back(plane_through(p, Quad(-1) * outward));
        }
        break;
    }
    case FeatureKind::face: {
        const Triangle t = mesh.triangle(TriangleId{feature.id});
        const QuadPoint normal = quad_normal(t);
        planes.push_back(plane_through(t[0], Quad(-1) * normal));
        for (int i = 0; i < 3; ++i) {
            const QuadPoint side = QuadPoint(t[(i + 1) % 3]) - QuadPoint(t[i]);
            planes.push_back(plane_through(t[i], cross(side, normal)));
        }
        break;
    }
    }
    return planes;
}

/// Whether a point of the box is behind all planes, each moved outward by `shift`.
inline bool meets_box(std::vector<QuadPlane> planes, const Box& box, double shift)
{
    for (QuadPlane& plane : planes) plane.offset += shift;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 unit = Vec3::Unit(axis);
        planes.push_back({QuadPoint(unit), box.upper[axis]});
        planes.push_back({Quad(-1) * QuadPoint(unit), -Quad(box.lower[axis])});
    }
    const Quad scale = Quad((box.upper - box.lower).maxCoeff());
    const auto is_in = [&](const QuadPoint& x) {
        for (const QuadPlane& plane : planes)
            if (dot(plane.normal, x) > plane.offset + Quad(1e-17) * scale) return false;
        return true;
    };
    for (std::size_t i = 0; i < planes.size(); ++i) {
        for (std::size_t j = i + 1; j < planes.size(); ++j) {
            const QuadPoint line = cross(planes[i].normal, planes[j].normal);
            for (std::size_t k = j + 1; k < planes.size(); ++k) {
                const Quad determinant = dot(line, planes[k].normal);
                if (determinant == 0) continue;
                const QuadPoint x = (1 / determinant) *
                                    (planes[i].offset * cross(planes[j].normal, planes[k].normal) +
                                     planes[j].offset * cross(planes[k].normal, planes[i].normal) +
                                     planes[k].offset * line);
                if (is_in(x)) return true;
            }
        }
    }
    return false;
}

} // namespace proxima::oracle
