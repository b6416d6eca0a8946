// Two overlapping solids, asked along lines and at points of their contour.
#pragma once

#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/signed_distance.h"
#include "query/contacts/solid_parts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace proxima {

/// Unit normals, outward, of A's and B's triangles at a point of both surfaces.
struct SurfaceNormals {
    Vec3 of_a = Vec3::Zero();
    Vec3 of_b = Vec3::Zero();

    /// In which B would move away, of any length.
    [[nodiscard]] Vec3 apart() const { return of_a - of_b; }
    /// Into both, of length 1 or 0.
    [[nodiscard]] Vec3 inward() const { return -unit_of(of_a + of_b); }
};

class PROXIMA_HIDDEN ContactLines {
public:
    /// The parts must outlive it.
    ContactLines(const SolidParts& a, const SolidParts& b, const RigidTransform& pose_b)
        : a_(a), b_(b), pose_(pose_b), back_(true_inverse(pose_b))
    {}

    [[nodiscard]] SurfaceNormals surfaces_at(const Vec3& p) const
    {
        const auto normal = [](const SolidParts& solid, const Vec3& at) -> Vec3 {
            const auto closest = closest_feature(solid.index, at);
            if (!closest) return Vec3::Zero();
            const Triangle t = solid.mesh.triangle(closest->triangle);
            return unit_normal({t[0], t[1]}, {t[0], t[2]});
        };
        return {normal(a_, p), unit_of(pose_.rotation * normal(b_, back_(p)))};
    }

    /// The piece of the line through p along the normal that lies in both; nothing where p is not in
    /// both, nor a little above or below it. `size` is the region's.
    [[nodiscard]] std::optional<RegionPoint> line_through(const Vec3& p, const Vec3& normal,
                                                          double size) const
    {
        for (const double part : {0.0, -0x1p-20, 0x1p-20}) {
            const Vec3 from = p + part * size * normal;
            if (!is_common(from)) continue;
            const double up = leaves_at(from, normal);
            const double down = leaves_at(from, -normal);
            if (!(up + down > 0)) continue;
            return RegionPoint{from + up * normal, from - down * normal, up + down};
        }
        return std::nullopt;
    }

private:
    [[nodiscard]] bool is_common(const Vec3& p) const
    {
        const auto in_a = signed_distance(a_.index, p);
        if (!in_a || in_a->distance > 0) return false;
        const auto in_b = signed_distance(b_.index, back_(p));
        return in_b && in_b->distance <= 0;
    }

    /// How far along the direction the line leaves A or B.
    [[nodiscard]] double leaves_at(const Vec3& from, const Vec3& direction) const
    {
        return std::min(leaves_at(a_.index, from, direction),
                        leaves_at(b_.index, back_(from), back_.rotation * direction));
    }

    /// The end of the piece of the ray that is in the solid. What is between two hits is inside or
    /// outside as a whole: surfaces may pass through a solid's inside, and hits of edges come twice.
    static double leaves_at(const MeshIndex& index, const Vec3& from, const Vec3& direction)
    {
        constexpr std::size_t most = 64;
        std::array<RayHit, most> hits;
        const Ray ray = {.origin = from, .direction = direction};
        const std::size_t count = std::min(all_hits(index, ray, hits), most);
        if (count == 1) return hits[0].t; // from inside to outside
        double inside = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const auto middle = signed_distance(index, ray.at(0.5 * (inside + hits[i].t)));
            if (!middle || middle->distance > 0) break;
            inside = hits[i].t;
        }
        return inside;
    }

    const SolidParts& a_;
    const SolidParts& b_;
    RigidTransform pose_;
    RigidTransform back_;
};

} // namespace proxima
