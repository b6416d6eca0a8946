// FCL 0.7 as a peer in times of contact and penetration depths.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/geometry.h"
#include "proxima/time_of_contact.h"
#include "proxima/triangle_mesh.h"

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

/// Penetration depth of two convex polyhedra by FCL's GJK and EPA (libccd).
class FclConvexDepth {
public:
    FclConvexDepth(const ConvexPolyhedron& a, const ConvexPolyhedron& b);
    ~FclConvexDepth();
    FclConvexDepth(const FclConvexDepth&) = delete;
    FclConvexDepth& operator=(const FclConvexDepth&) = delete;

    /// 0 where it says that they do not overlap.
    [[nodiscard]] double depth(const RigidTransform& pose_b) const;

private:
    struct Shapes;
    std::unique_ptr<Shapes> shapes_;
};

} // namespace proxima::bench
