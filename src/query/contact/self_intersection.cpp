#include "query/contact/self_intersection.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_intersection.h"
#include "proxima/intersect_meshes.h"
#include "query/contact/contact_search.h"
#include "query/contact/triangles_in_box.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace proxima {
namespace {

bool has_corner(const Triangle& triangle, const Vec3& point) noexcept
{
    return triangle[0] == point || triangle[1] == point || triangle[2] == point;
}

/// Where the corners of one triangle that the other does not have are beside its plane.
enum class BesidePlane : std::uint8_t {
    one_side, ///< all: then the triangles meet in nothing but what they share
    within,   ///< all in the plane, or the other has none
    across
};

BesidePlane beside_plane(const Triangle& triangle, const Triangle& other) noexcept
{
    bool above = false;
    bool below = false;
    bool within = false;
    for (const Vec3& corner : triangle.vertices) {
        if (has_corner(other, corner)) continue;
        const int side = orient3d(other[0], other[1], other[2], corner);
        above = above || side > 0;
        below = below || side < 0;
        within = within || side == 0;
    }
    if (above || below)
        return within || (above && below) ? BesidePlane::across : BesidePlane::one_side;
    return BesidePlane::within;
}

/// Corners of a triangle as seen along an axis, counter-clockwise from one of them.
using FlatTriangle = std::array<Vec2, 3>;

/// Turns a triangle so that `first` comes first. Nothing where it is seen edge-on.
std::optional<FlatTriangle> flattened(const Triangle& triangle, int first, int axis) noexcept
{
    FlatTriangle flat;
    for (int i = 0; i < 3; ++i) {
        const Vec3& corner = triangle[(first + i) % 3];
        flat[static_cast<std::size_t>(i)] = {corner[(axis + 1) % 3], corner[(axis + 2) % 3]};
    }
    const int turn = orient2d(flat[0], flat[1], flat[2]);
    if (turn == 0) return std::nullopt;
    if (turn < 0) std::swap(flat[1], flat[2]);
    return flat;
}

/// Whether a direction from the first corner points into the triangle's angle there, or along a side.
bool points_into(const FlatTriangle& triangle, const Vec2& to) noexcept
{
    return orient2d(triangle[0], triangle[1], to) >= 0 &&
           orient2d(triangle[0], to, triangle[2]) >= 0;
}

/// Whether two triangles in one plane that have one or two corners in common meet in more: whether
/// their angles at a common corner do. Nothing where one has no area.
std::optional<bool> overlap_in_plane(const Triangle& a, const Triangle& b) noexcept
{
    int first_a = 0;
    while (!has_corner(b, a[first_a])) ++first_a;
    int first_b = 0;
    while (b[first_b] != a[first_a]) ++first_b;
    int broadest = 0; // seen along this axis, nothing is edge-on but for rounding
    scaled_normal(a).cwiseAbs().maxCoeff(&broadest);
    for (int i = 0; i < 3; ++i) {
        const int axis = (broadest + i) % 3;
        const auto flat_a = flattened(a, first_a, axis);
        const auto flat_b = flattened(b, first_b, axis);
        if (!flat_a || !flat_b) continue;
        const auto& [start_a, left_a, right_a] = *flat_a;
        const auto& [start_b, left_b, right_b] = *flat_b;
        // A common edge, and the triangles on either side of it.
        if (left_a == right_b || right_a == left_b) return false;
        return points_into(*flat_a, left_b) || points_into(*flat_a, right_b) ||
               points_into(*flat_b, left_a) || points_into(*flat_b, right_a);
    }
    return std::nullopt;
}

constexpr std::uint32_t chunk_rows = 1024;
constexpr std::uint32_t round_chunks = 64;

} // namespace

bool meet_beyond_corners(const Triangle& a, const Triangle& b) noexcept
{
    const int shared = static_cast<int>(has_corner(a, b[0])) +
                       static_cast<int>(has_corner(a, b[1])) +
                       static_cast<int>(has_corner(a, b[2]));
    if (shared == 0) return triangles_meet(a, b);
    if (shared == 3 && !is_degenerate(b)) return true;
    const BesidePlane a_beside = beside_plane(a, b);
    if (a_beside == BesidePlane::one_side || beside_plane(b, a) == BesidePlane::one_side)
        return false;
    if (a_beside == BesidePlane::within && shared < 3) {
        if (const auto overlap = overlap_in_plane(a, b)) return *overlap;
    }
    const TriangleIntersection found = intersect(a, b);
    const auto is_shared = [&](const MeetingParts& parts) {
        return is_corner(parts.of_a)   ? has_corner(b, a[number_of(parts.of_a)])
               : is_corner(parts.of_b) ? has_corner(a, b[number_of(parts.of_b)])
                                       : false;
    };
    if (found.size() < 2) return false; // a point that both have is the corner
    return found.size() > 2 || !std::ranges::all_of(found.ends(), is_shared);
}

Result<SelfIntersections> find_self_intersections(const MeshIndex& index,
                                                  const SelfIntersectionOptions& options)
{
    const IndexParts& parts = index.parts();
    const std::uint32_t rows = parts.triangle_count();
    begin_stage(options.execution.progress, "finding self-intersections", rows);
    SelfIntersections result;
    // Rows of the index, so that neighbours are looked for where the last ones were. Rounds have a
    // fixed size: where the work ends does not depend on threads.
    for (std::uint32_t start = 0; start < rows; start += round_chunks * chunk_rows) {
        const std::uint32_t count = std::min(rows - start, round_chunks * chunk_rows);
        std::vector<std::vector<TrianglePair>> found(chunk_count(count, chunk_rows));
        const auto search = [&](std::size_t first, std::size_t end) {
            std::vector<TrianglePair>& pairs = found[first / chunk_rows];
            StageSteps steps(options.execution.progress, 8);
            for (auto row = start + static_cast<std::uint32_t>(first); row < start + end; ++row) {
                if (!steps.done(1) || pairs.size() > options.max_pairs) return;
                const Triangle triangle = parts.triangle(row);
                const TriangleId id = parts.id(row);
                visit_triangles_in_box(parts, bounding_box(triangle),
                                       [&](TriangleId other, const Triangle& there) {
                                           if (id < other && meet_beyond_corners(triangle, there))
                                               pairs.push_back({id, other});
                                           return pairs.size() <= options.max_pairs &&
                                                  !is_cancelled(options.execution.progress);
                                       });
            }
        };
        parallel_chunks(count, chunk_rows, options.execution.threads, search);
        if (is_cancelled(options.execution.progress))
            return cancelled("finding self-intersections");
        for (const auto& pairs : found)
            result.pairs.insert(result.pairs.end(), pairs.begin(), pairs.end());
        if (result.pairs.size() > options.max_pairs) {
            result.complete = false;
            break;
        }
    }
    std::ranges::sort(result.pairs);
    if (!result.complete) result.pairs.resize(options.max_pairs);
    return result;
}

} // namespace proxima
