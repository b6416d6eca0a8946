// Where two meshes in rigid poses meet (thesis section 5.2): whether at all, in which triangles, in
// which curves; whether one lies inside the other; and where a mesh intersects itself.
//
//     auto a = build_mesh_index(mesh_a);
//     auto b = build_mesh_index(mesh_b);
//     if (meshes_intersect(*a, *b, pose)) stop();
//     auto pairs = intersecting_pairs(*a, *b, pose);               // triangles of A and B that meet
//     auto contour = intersection_contour(*a, *b, pose);           // the lines along which they do
//
// Triangles are closed sets: touching counts, and triangles without an area are the segments or
// points that they are. Answers are exact for A's corners as given and B's as pose_b(corner) rounds
// them, once; floats only sort out what surely meets and what surely does not. Coordinates may have
// any scale and lie anywhere. An empty mesh meets nothing. Surfaces are meant: a mesh inside
// another one does not meet it; find_containment says whether it is. \pre of all: the pose is rigid
// (make_rigid_transform).
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// A triangle of A and one of B that meet.
struct TrianglePair {
    TriangleId a{};
    TriangleId b{};

    // NOLINTNEXTLINE(modernize-use-nullptr): of the defaulted comparison's own text
    friend auto operator<=>(const TrianglePair&, const TrianglePair&) = default;
};

/// Whether two meshes meet. Stops at the first pair. Real-time safe: noexcept, no allocation, no
/// lock; any number of threads. 0.1 MB of stack. 1 to 30 us on scanned models; where coordinates
/// are beyond 2^43 times the size of the larger mesh every pair is tested, which takes 10 ns each.
[[nodiscard]] bool meshes_intersect(const MeshIndex& a, const MeshIndex& b,
                                    const RigidTransform& pose_b = {}) noexcept;

/// A triangle of A and one of B that meet, one pair of possibly many.
struct MeshMeeting {
    TriangleId triangle_a{};
    TriangleId triangle_b{};
    std::uint32_t row_a = 0; ///< rows of the indexes: for a later search to start from
    std::uint32_t row_b = 0;
};

struct MeetingOptions {
    /// An answer for another pose: below 1 us while these triangles still meet. Any answer will do,
    /// of other meshes as well.
    const MeshMeeting* start_from = nullptr;
};

/// Like meshes_intersect, and names a pair that meets: that of `start_from` if it does, else any.
[[nodiscard]] std::optional<MeshMeeting> find_meeting(const MeshIndex& a, const MeshIndex& b,
                                                      const RigidTransform& pose_b = {},
                                                      const MeetingOptions& options = {}) noexcept;

/// All pairs of triangles that meet, by a, then b, each once. Allocates the list. 0.3 to 1 us a
/// pair, 10 us where both lie in one plane.
[[nodiscard]] std::vector<TrianglePair> intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                                           const RigidTransform& pose_b);

/// Writes the first pairs.size() of them, and returns how many there are in all. Real-time safe as
/// meshes_intersect.
[[nodiscard]] std::size_t intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                             const RigidTransform& pose_b,
                                             std::span<TrianglePair> pairs) noexcept;

/// Calls visitor(pairs) with pairs as they are found, each once, in no particular order, until it
/// returns Flow::stop; without any where none was found for long, so that it may end the search.
/// Real-time safe as meshes_intersect if the visitor is.
void visit_intersecting_pairs(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b,
                              FunctionRef<Flow(std::span<const TrianglePair>)> visitor);

struct PairOptions {
    Execution execution = {}; ///< stage "intersecting meshes", steps are poses
};

/// The same for many poses. Answers are those of single ones, for any number of threads. Errors:
/// invalid_argument (sizes differ), cancelled.
[[nodiscard]] Status meshes_intersect(const MeshIndex& a, const MeshIndex& b,
                                      std::span<const RigidTransform> poses,
                                      std::span<bool> answers, const PairOptions& options = {});

/// Pairs of many poses: those of pose i are pairs[first[i]] to pairs[first[i + 1] - 1].
struct PairLists {
    std::vector<std::size_t> first;
    std::vector<TrianglePair> pairs;
};
[[nodiscard]] Result<PairLists> intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                                   std::span<const RigidTransform> poses,
                                                   const PairOptions& options = {});

/// A vertex (its id, twice), an edge (its vertices, ascending) or a face (its triangle, twice). Of
/// vertices at one position the lowest one that the pairs' triangles use.
struct SurfacePart {
    FeatureKind kind = FeatureKind::vertex;
    std::array<std::uint32_t, 2> ids{};
    friend constexpr bool operator==(const SurfacePart&, const SurfacePart&) = default;
    // NOLINTNEXTLINE(modernize-use-nullptr): of the defaulted comparison's own text
    friend constexpr auto operator<=>(const SurfacePart&, const SurfacePart&) = default;
};

/// A point of both surfaces, in A's coordinates: the only common point of the insides of the two
/// features (of B moved).
struct ContourPoint {
    Vec3 position = Vec3::Zero();
    SurfacePart on_a;
    SurfacePart on_b;
};

/// points[first] to points[first + count - 1]; a closed one goes on to its first point again. One
/// point alone: the meshes touch there and nowhere near.
struct ContourLine {
    std::size_t first = 0;
    std::size_t count = 0;
    bool closed = false;
};

struct IntersectionContour {
    std::vector<ContourPoint> points;
    std::vector<ContourLine> lines;

    [[nodiscard]] std::span<const ContourPoint> points_of(const ContourLine& line) const noexcept
    {
        return std::span(points).subspan(line.first, line.count);
    }
    /// Of all lines together.
    [[nodiscard]] double length() const noexcept;
};

/// The contour of A and B moved by the pose. Where surfaces pass through each other in general
/// position, all lines end only at borders: those of two closed meshes are closed. Besides:
/// - Triangles in one plane share an area. Of that the contour has the border, and edges within it
///   only where triangles of different planes meet there too.
/// - Where surfaces only touch along an edge, the line along it ends where the edge does.
/// - Where more than two segments meet in a point, lines go on along any of them, and no segment
///   comes twice.
/// - Where triangles of one mesh cover each other (a flap, there and back), the line ends
///   with them.
/// - Triangles with the same three corners count once, under the lowest id.
/// - A triangle without an area joins the segments of its neighbours; two of them add nothing.
/// O(pairs log pairs), about 4 us each, 20 us where both lie in one plane; allocates. Same bits on
/// every machine. \pre differences of coordinates are finite
[[nodiscard]] IntersectionContour intersection_contour(const MeshIndex& a, const MeshIndex& b,
                                                       const RigidTransform& pose_b = {});

struct ContourOptions {
    Execution execution =
        {}; ///< one thread; stage "finding the intersection contour", steps are pairs
};

/// Like this, and can be watched and cancelled. Error cancelled.
[[nodiscard]] Result<IntersectionContour> intersection_contour(const MeshIndex& a,
                                                               const MeshIndex& b,
                                                               const RigidTransform& pose_b,
                                                               const ContourOptions& options);

/// The contour of pairs of triangles that the caller has found, in any order. Pairs that do not meet
/// are left out.
/// About 3 us each. \pre the meshes are those of the indexes, or at least these triangles of them
[[nodiscard]] IntersectionContour intersection_contour(const TriangleMesh& a, const TriangleMesh& b,
                                                       const RigidTransform& pose_b,
                                                       std::span<const TrianglePair> pairs);

/// Like this, and can be watched and cancelled. Error cancelled.
[[nodiscard]] Result<IntersectionContour>
intersection_contour(const TriangleMesh& a, const TriangleMesh& b, const RigidTransform& pose_b,
                     std::span<const TrianglePair> pairs, const ContourOptions& options);

/// What a mesh's inside is; vertices at one position are one for this.
enum class InsideMethod : std::uint8_t {
    crossings,     ///< closed, consistently oriented: where it winds round, either way; exact
    parity,        ///< closed, not consistently oriented: behind an odd number of faces; exact
    winding_number ///< open: where the winding number's size is at least 1/2
};

enum class Containment : std::uint8_t { none, a_in_b, b_in_a };

struct EnclosureParts;

/// What containment is asked of: a mesh with its inside. Immutable and cheap to copy. It shares the
/// arrays of the index that it was made from. Thread safe. Made by build_enclosure.
class Enclosure {
public:
    [[nodiscard]] InsideMethod method() const noexcept;

    /// For the library's own searches.
    [[nodiscard]] const EnclosureParts& parts() const noexcept { return *parts_; }
    /// For the library's own builders. \pre parts is not null
    explicit Enclosure(std::shared_ptr<const EnclosureParts> parts) noexcept;

    // Copies only: a moved-from one would have no parts.
    Enclosure(const Enclosure&) noexcept = default;
    Enclosure& operator=(const Enclosure&) noexcept = default;
    ~Enclosure() = default;

private:
    std::shared_ptr<const EnclosureParts> parts_; ///< never null
};

struct EnclosureOptions {
    Execution execution = {};
};

/// Finds out how the inside of the index's mesh is told. For open meshes it takes the winding numbers
/// of the index's signs or, where there are none, builds its own (50 bytes per triangle). Errors:
/// invalid_mesh (an empty index), broken_invariant (mesh_of), cancelled. O(triangles log triangles),
/// up to 1 us each.
[[nodiscard]] Result<Enclosure> build_enclosure(const MeshIndex& index,
                                                const EnclosureOptions& options = {});

/// Whether the point lies inside of the mesh moved by the pose: of its corners as the pose rounds
/// them (by winding numbers: of the mesh as it is, and the point moved back). Either may be said of
/// a point on the surface. No allocation. O(log triangles), and the triangles near a ray along
/// x: 6 us on a scan of 70,000 triangles.
/// \pre point is finite
[[nodiscard]] bool encloses(const Enclosure& enclosure, const RigidTransform& pose,
                            const Vec3& point) noexcept;

struct ContainmentAnswer {
    Containment containment = Containment::none;
    /// Of the mesh that contains the other; of none, the less certain of the two.
    InsideMethod method = InsideMethod::crossings;
};

/// Whether A lies inside of B moved by the pose, or the other way round. Every part that is connected
/// by vertices must: one vertex of each is asked, for a part that crosses no surface is on one side
/// of it. Where the surfaces meet, the answer means nothing. Real-time safe: no allocation, no lock;
/// any number of threads. As many calls of encloses() as there are parts; most often the bounds say
/// it.
[[nodiscard]] ContainmentAnswer find_containment(const Enclosure& a, const Enclosure& b,
                                                 const RigidTransform& pose_b = {}) noexcept;

struct SelfIntersectionOptions {
    std::size_t max_pairs = 1'000'000; ///< stops where more were found
    Execution execution = {};          ///< stage "finding self-intersections", steps are triangles
};

struct SelfIntersections {
    std::vector<TrianglePair> pairs; ///< a < b in each; by a, then b
    bool complete = true;            ///< false: there are more, these are max_pairs of them
};

/// All pairs of triangles of the mesh that meet in more than what they share:
///
///     no corner in common      they meet
///     one                      they meet elsewhere, too
///     two                      they lie in one plane, on the same side of their common edge
///     three                    always: one covers the other; but without an area never
///
/// Corners at one position are common, whatever their ids: seams do not count. Exact, and the same
/// for any number of threads. Error cancelled. About 5 us per triangle of a scanned model; quadratic
/// where many triangles lie close together.
[[nodiscard]] Result<SelfIntersections>
find_self_intersections(const MeshIndex& index, const SelfIntersectionOptions& options = {});

} // namespace proxima
