// What physics asks of two closed meshes that overlap: where, in which direction, and how deep.
//
//     auto a = build_solid(*index_a);                       // once per mesh; as b
//     auto depth = penetration_depth(*a, *b, pose_b);       // how far B must move to be free
//     move_b(depth->translation);
//     auto met = contact_regions(*a, *b, pose_b);
//     for (const ContactRegion& region : met->regions)
//         for (const RegionPoint& p : region.contacts()) push(p.on_a, p.on_b, region.normal);
//          ______________                penetration depth: the shortest translation of B that
//         |      B       |               separates the two: one number for the pair
//      ___|______________|___  contour
//     |   '--------------'   |           contact region: a connected part of the contour, with a
//     |         A            |           normal from A to B and a depth along it
//
// Solids are closed sets: what touches, overlaps. Moved meshes are those of B's vertices as the pose
// rounds them. docs/contacts.md defines all terms, with a picture.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

struct SolidParts;

/// A closed mesh with its inside, its convex hull and signs. Immutable and cheap to copy. Thread safe.
/// Made by build_solid.
class Solid {
public:
    /// With signs.
    [[nodiscard]] const MeshIndex& index() const noexcept;
    [[nodiscard]] const Enclosure& enclosure() const noexcept;
    /// Whether the mesh is its convex hull, up to hull_error().
    [[nodiscard]] bool is_convex() const noexcept;
    /// How far points of a convex mesh's hull are from the solid at most: coordinates of round shapes
    /// are rounded, and their faces are never quite flat. 0 where exact predicates say that it is its
    /// hull; they are asked of meshes of up to 2^20 pairs of a triangle and a corner of the hull. In the
    /// mesh's unit.
    [[nodiscard]] double hull_error() const noexcept;

    /// For the library's own searches.
    [[nodiscard]] const SolidParts& parts() const noexcept { return *parts_; }
    /// For the library's own builders. \pre parts is not null
    explicit Solid(std::shared_ptr<const SolidParts> parts) noexcept;

    // Copies only: a moved-from one would have no parts.
    Solid(const Solid&) noexcept = default;
    Solid& operator=(const Solid&) noexcept = default;
    ~Solid() = default;

private:
    std::shared_ptr<const SolidParts> parts_; ///< never null
};

struct SolidOptions {
    Execution execution = {};
};

/// Prepares a mesh for contacts; adds signs where the index has none. Vertices at one position are one.
/// The solid is what the surface winds round, either way, as encloses tells it, and the surface.
/// Components face outward, or inward where they bound a cavity: such a one touches neither another component
/// nor itself, but for single vertices that cavities share, not all of one, and lies inside of what the others fill.
/// Errors: invalid_mesh (an empty index; a mesh that is open, not consistently oriented, or with a
/// component that is turned inside out and no cavity's; all vertices in one plane), limit_exceeded
/// (coordinates above max_polyhedron_coordinate), those of with_signs. O(n log n), 5 to 15 us per
/// triangle.
[[nodiscard]] Result<Solid> build_solid(const MeshIndex& index, const SolidOptions& options = {});

/// Whether two solids have a point in common. Exact. No allocation.
[[nodiscard]] bool solids_overlap(const Solid& a, const Solid& b,
                                  const RigidTransform& pose_b = {}) noexcept;

enum class PenetrationMethod : std::uint8_t {
    apart,  ///< no point in common: the depth is 0
    convex, ///< of two convex meshes, by their Minkowski sum: the interval is as wide as roundings
    bounds  ///< of others: the depth is in the interval, which may be wide
};

/// The penetration depth: the length of the shortest translation of B that separates the two, or rather
/// the infimum of such lengths, as after the shortest one they still touch.
struct PenetrationDepth {
    /// No translation shorter than this separates them.
    double lower = 0;
    /// B moved by `translation`, no longer than this, is free.
    double upper = 0;
    Vec3 direction = Vec3::Zero(); ///< of `translation`, of length 1; zero where they are apart
    /// Added to the translation of B's pose, it makes solids_overlap say no.
    Vec3 translation = Vec3::Zero();
    /// A point of both, but for roundings and hull errors; zero where they are apart. Of the method
    /// `bounds` with a `lower` above 0 that where balls in A and in B, both about it, are together the
    /// largest that were found: the reason for `lower`.
    Vec3 deepest = Vec3::Zero();
    PenetrationMethod method = PenetrationMethod::apart;
};

/// Of points and of directions that may be asked for.
inline constexpr std::uint32_t max_penetration_search = 1'000'000;

struct PenetrationOptions {
    /// At which distances to both surfaces are taken, for `lower`; 64 bytes each.
    std::uint32_t max_points = 4000;
    std::uint32_t max_directions = 48; ///< that are tried besides those of hull, axes and surfaces
    Execution execution = {};          ///< one thread
};

/// The penetration depth of A and B moved by the pose, as an interval that holds it.
///
/// Two convex meshes: the least distance of the origin from the facets of the Minkowski sum of B and
/// the mirrored A (minkowski_sum.h). The interval is as wide as both hull_error() and 2^-46 of the
/// coordinates.
///
/// Others. Upper bound: a translation that separates the hulls separates the meshes; shorter ones are
/// looked for along many directions, and each is tested exactly: surfaces do not meet, and no part of
/// one mesh is inside the other. Lower bound: where a point is a deep in A and b deep in B, two balls
/// have a common centre, and B must move by a + b at least to part them; branch and bound looks
/// for the largest sum.
///
/// A pose's matrix may be no rotation by a little: answers are those of B's vertices as it moves them.
///
/// Errors: invalid_argument (a number of the pose is NaN or infinite, its matrix is no rotation by
/// more than nearly_rigid_tolerance), limit_exceeded (of the sum; options above
/// max_penetration_search), cancelled. Convex: O(facets of the sum). Others: 10 to 400 ms for
/// models of thousands of triangles. Allocates. Thread safe. The same for every instruction set, and on every
/// machine whose C library has the same sines.
[[nodiscard]] Result<PenetrationDepth> penetration_depth(const Solid& a, const Solid& b,
                                                         const RigidTransform& pose_b = {},
                                                         const PenetrationOptions& options = {});

/// Points of a line along a region's normal where it enters and leaves what A and B have in common. Both
/// are on the surface of what is common. Where the line leaves B before A, as where B is thin or has turned
/// past the normal, `on_a` is on B's surface and inside of A; likewise `on_b`.
struct RegionPoint {
    Vec3 on_a = Vec3::Zero(); ///< the end along the normal: most often on A's surface
    Vec3 on_b = Vec3::Zero(); ///< the end against the normal: most often on B's surface
    double depth = 0;         ///< how far apart the two are
};

/// What a region has for physics at most.
inline constexpr std::size_t max_contact_points = 4;

/// A connected part of the contour. Depths are those of lines through it along the normal: how long the
/// piece of the line is that lies in both solids and meets the region's mean plane.
struct ContactRegion {
    Vec3 position = Vec3::Zero(); ///< mean of the contour's segments by length
    /// From A to B, of length 1: of the plane that the contour's loops span, by their vector area; of
    /// a contour that spans none, by the surfaces along it. Where the faces at both ends of the middle line
    /// are parallel, theirs. Where faces of both share a plane: of the one so found, and the normals of
    /// faces at the region that look at each other, that of the least depth.
    Vec3 normal = Vec3::Zero();
    /// The largest depth found, no more than the region's greatest one; 0 where they only touch.
    double depth = 0;
    double length = 0; ///< of the contour
    double area = 0;   ///< that the loops span, along the normal
    /// The deepest first, or one as deep but for 2^-20 of it that is farther from `position`.
    std::array<RegionPoint, max_contact_points> points;
    std::size_t point_count = 0;
    std::size_t first_line = 0; ///< lines of the contour: those numbers of `lines`
    std::size_t line_count = 0;

    [[nodiscard]] std::span<const RegionPoint> contacts() const noexcept
    {
        return std::span(points).first(point_count);
    }
};

/// All regions, in the order of the contour's lines.
struct ContactRegions {
    IntersectionContour contour;
    std::vector<std::size_t> lines; ///< numbers of the contour's lines, region by region
    std::vector<ContactRegion> regions;
};

struct ContactRegionOptions {
    Execution execution = {}; ///< one thread; stage "measuring contact regions"
};

/// The contact regions of A and B moved by the pose. Lines of the contour that have a point in common
/// are one region. None where the surfaces do not meet, as where one mesh is inside the other. Of
/// each region at most four points: the deepest, the farthest from it, the farthest from the line
/// through both, and the one that makes the largest quadrilateral, seen along the normal. Allocates.
/// Thread safe. 4 us per pair of triangles that meet, 30 us in one plane, and 0.3 to 10 ms per region,
/// 30 ms of flush faces. The same as penetration_depth is. Errors: invalid_argument (as penetration_depth's), cancelled.
/// \pre differences of coordinates are finite
[[nodiscard]] Result<ContactRegions> contact_regions(const Solid& a, const Solid& b,
                                                     const RigidTransform& pose_b = {},
                                                     const ContactRegionOptions& options = {});

} // namespace proxima
