// FCL 0.7 as a peer in times of contact and penetration depths.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/geometry.h"
#include "proxima/time_of_contact.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace proxima::bench {

/// Conservative advancement, which finds no contact of meshes (FCL's issues 120 and 555), or 200
/// equal steps.
enum class FclAdvance : std::uint8_t { conservative, steps };

/// Continuous collision of two meshes by FCL, with oriented boxes and swept spheres.
class FclTimeOfContact {
public:
    FclTimeOfContact(const TriangleMesh& a, const TriangleMesh& b);
    ~FclTimeOfContact();
    FclTimeOfContact(const FclTimeOfContact&) = delete;
    FclTimeOfContact& operator=(const FclTimeOfContact&) = delete;

    /// The time of contact that it says; nothing where it says there is none.
    [[nodiscard]] std::optional<double> time(const RigidMotion& motion, FclAdvance how) const;

private:
    struct Models;
    std::unique_ptr<Models> models_;
};

/// Continuous collision of two meshes, one of which is translated, by FCL's polynomial solver: the roots
/// of cubics for each vertex and triangle and each pair of edges. It stops at the first pair of triangles
/// that it finds, whose time need not be the earliest.
class FclTranslation {
public:
    FclTranslation(TriangleMesh a, TriangleMesh b);
    ~FclTranslation();
    FclTranslation(const FclTranslation&) = delete;
    FclTranslation& operator=(const FclTranslation&) = delete;

    /// Builds both models at the start of the motion, which each call of time() needs anew: the solver
    /// ignores poses, and leaves the vertices of the models moved. Not to be timed.
    void prepare(const RigidMotion& motion);
    /// The time of contact that it says; nothing where it says there is none. Fits the models' boxes to the
    /// motion, as FCL does in every call. \pre prepare(motion) was called since the last call; no turn
    [[nodiscard]] std::optional<double> time(const RigidMotion& motion);

private:
    struct Models;
    TriangleMesh a_;
    TriangleMesh b_;
    std::unique_ptr<Models> models_;
};

enum class FclDepthMethod : std::uint8_t {
    /// collide() with libccd: Minkowski portal refinement, whose depth is no minimum.
    mpr,
    /// collide() with FCL's own GJK and EPA. Its depths are wrong, most often far too small: 0.58 instead of 1.7 for two
    /// spheres of radius 1 and 1,280 triangles whose centers are 0.3 apart. Larger limits on the faces,
    /// vertices and steps of EPA do not change this.
    gjk_epa,
    /// distance() with enable_signed_distance: GJK and EPA on libccd's simplices.
    signed_distance
};

/// Penetration depth of two convex polyhedra by FCL.
class FclConvexDepth {
public:
    FclConvexDepth(const ConvexPolyhedron& a, const ConvexPolyhedron& b);
    ~FclConvexDepth();
    FclConvexDepth(const FclConvexDepth&) = delete;
    FclConvexDepth& operator=(const FclConvexDepth&) = delete;

    /// 0 where it says that they do not overlap.
    [[nodiscard]] double depth(const RigidTransform& pose_b, FclDepthMethod method) const;

private:
    struct Shapes;
    std::unique_ptr<Shapes> shapes_;
};

} // namespace proxima::bench
