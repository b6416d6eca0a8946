// Where two meshes in rigid poses meet (thesis section 5.2): whether at all, or all pairs of
// triangles.
//
//     auto a = build_mesh_index(mesh_a);
//     auto b = build_mesh_index(mesh_b);
//     if (meshes_intersect(*a, *b, pose)) stop();
//     for (const TrianglePair& pair : intersecting_pairs(*a, *b, pose)) mark(pair.a, pair.b);
//
// Triangles are closed sets: touching counts, and triangles without an area are the segments or
// points that they are. Answers are exact for A's corners as given and B's as pose_b(corner) rounds
// them, once; floats only sort out what surely meets and what surely does not. Coordinates may have
// any scale and lie anywhere. An empty mesh meets nothing. Surfaces are meant: a mesh inside
// another one does not meet it. \pre of all: the pose is rigid (make_rigid_transform).
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "geometry/rigid_transform.h"
#include "index/mesh_index.h"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace proxima {

/// A triangle of A and one of B that meet.
struct TrianglePair {
    TriangleId a{};
    TriangleId b{};

    // NOLINTNEXTLINE(modernize-use-nullptr): of the defaulted comparison's own text
    friend auto operator<=>(const TrianglePair&, const TrianglePair&) = default;
};

/// Whether two meshes meet. Stops at the first pair. Real-time safe: noexcept, no allocation, no
/// lock; any number of threads. 0.1 MB of stack. 1 to 30 us on scanned models; where coordinates
/// are beyond 2^43 times the size of the larger mesh every pair is asked, which takes 10 ns each.
[[nodiscard]] bool meshes_intersect(const MeshIndex& a, const MeshIndex& b,
                                    const RigidTransform& pose_b) noexcept;

/// Where two meshes met the last time. Of one pair of indexes.
struct LastMeeting {
    static constexpr std::uint32_t none = 0xFFFFFFFFU;

    std::uint32_t row_a = none; ///< of the indexes
    std::uint32_t row_b = none;
};

/// The same, asking first where they met the last time: below 1 us where the pose has changed so
/// little that they meet there still. Updates `last`.
[[nodiscard]] bool meshes_intersect(const MeshIndex& a, const MeshIndex& b,
                                    const RigidTransform& pose_b, LastMeeting& last) noexcept;

/// All pairs of triangles that meet, by a, then b, each once. Allocates the list. 0.3 to 1 us a
/// pair.
[[nodiscard]] std::vector<TrianglePair> intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                                           const RigidTransform& pose_b);

/// The first pairs.size() of them are written there. Returns how many there are. Real-time safe as
/// meshes_intersect.
[[nodiscard]] std::size_t intersecting_pairs(const MeshIndex& a, const MeshIndex& b,
                                             const RigidTransform& pose_b,
                                             std::span<TrianglePair> pairs) noexcept;

namespace detail {
using VisitPairs = void (*)(void* context, std::span<const TrianglePair> pairs);
void visit_pairs(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b,
                 VisitPairs visit, void* context);
} // namespace detail

/// Calls visitor(std::span<const TrianglePair>) with pairs as they are found, each once, in no
/// particular order. Real-time safe as meshes_intersect if the visitor is.
template <class Visitor>
void visit_intersecting_pairs(const MeshIndex& a, const MeshIndex& b, const RigidTransform& pose_b,
                              Visitor&& visitor)
{
    using Callable = std::remove_reference_t<Visitor>;
    detail::visit_pairs(
        a, b, pose_b,
        [](void* context, std::span<const TrianglePair> pairs) {
            (*static_cast<Callable*>(context))(pairs);
        },
        const_cast<void*>(static_cast<const void*>(&visitor)));
}

struct PairOptions {
    Threads threads = {1};
    Progress* progress = nullptr; ///< stage "intersecting meshes", steps are poses
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

} // namespace proxima
