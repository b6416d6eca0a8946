// Whether one of two meshes lies inside of the other one, their surfaces not meeting.
//
//     const Enclosure a = build_enclosure(mesh_a).value();   // once per mesh
//     const Enclosure b = build_enclosure(mesh_b).value();
//     if (!meshes_intersect(index_a, index_b, pose))
//         if (find_containment(a, b, pose).containment == Containment::a_in_b) ...
//
// A mesh is inside of another one if all of it is: every part that is connected by vertices, each
// asked by one of its vertices, since a part that does not cross a surface is on one side of it.
#pragma once

#include "octree/winding_number.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// What a mesh's inside is; vertices at one position are one for this.
enum class InsideMethod : std::uint8_t {
    crossings,     ///< closed, consistently oriented: where it winds round, either way; exact
    parity,        ///< closed, not consistently oriented: behind an odd number of faces; exact
    winding_number ///< open: where the generalised winding number's size is at least 1/2
};

enum class Containment : std::uint8_t { none, a_in_b, b_in_a };

/// Immutable; refers to the mesh, which must outlive it. Thread safe.
class Enclosure {
public:
    [[nodiscard]] const TriangleMesh& mesh() const noexcept { return *mesh_; }
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }
    [[nodiscard]] InsideMethod method() const noexcept { return method_; }

    /// The lowest vertex of every connected part, ascending.
    [[nodiscard]] std::span<const VertexId> parts() const noexcept { return parts_; }

    /// For open meshes only.
    [[nodiscard]] const WindingNumber& winding() const noexcept { return *winding_; }

private:
    friend class EnclosureBuilder;

    const TriangleMesh* mesh_ = nullptr;
    Box bounds_;
    InsideMethod method_ = InsideMethod::crossings;
    std::vector<VertexId> parts_;
    std::optional<WindingNumber> winding_;
};

struct EnclosureOptions {
    Execution execution = {};
};

/// Errors: invalid_mesh (empty, NaN), cancelled. O(triangles log triangles), up to 1 us each.
[[nodiscard]] Result<Enclosure> build_enclosure(const TriangleMesh& mesh,
                                                const EnclosureOptions& options = {});

/// Whether the point lies inside of the mesh moved by the pose: of its corners as the pose rounds
/// them (by winding numbers: of the mesh as it is, and the point moved back). Either may be said of
/// a point on the surface. No allocation; O(triangles), 25 ns each, unless outside of the bounds.
/// \pre point is finite
[[nodiscard]] bool encloses(const Enclosure& enclosure, const RigidTransform& pose,
                            const Vec3& point) noexcept;

struct ContainmentAnswer {
    Containment containment = Containment::none;
    /// Of the mesh that contains the other; of none, the less certain of the two.
    InsideMethod method = InsideMethod::crossings;
};

/// Of A and B moved by the pose. Where the surfaces meet, what it says means nothing. Real-time
/// safe: no allocation, no lock; any number of threads. O(triangles of one mesh times parts of the
/// other), most often the bounds say it.
[[nodiscard]] ContainmentAnswer find_containment(const Enclosure& a, const Enclosure& b,
                                                 const RigidTransform& pose_b = {}) noexcept;

} // namespace proxima
