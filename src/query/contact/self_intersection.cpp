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

namespace proxima {
namespace {

bool has_corner(const Triangle& triangle, const Vec3& point) noexcept
{
    return triangle[0] == point || triangle[1] == point || triangle[2] == point;
}

/// Whether the corners of one triangle that the other does not have are all on one side of the
/// other's plane: then they meet in nothing but what they share.
bool leaves_plane(const Triangle& triangle, const Triangle& other) noexcept
{
    int side = 0;
    for (const Vec3& corner : triangle.vertices) {
        if (has_corner(other, corner)) continue;
        const int here = orient3d(other[0], other[1], other[2], corner);
        if (here == 0 || here * side < 0) return false;
        side = here;
    }
    return side != 0;
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
    if (leaves_plane(a, b) || leaves_plane(b, a)) return false;
    const TriangleIntersection found = intersect(a, b);
    const auto is_shared = [&](const MeetingParts& parts) {
        return is_corner(parts.of_a)   ? has_corner(b, a[number_of(parts.of_a)])
               : is_corner(parts.of_b) ? has_corner(a, b[number_of(parts.of_b)])
                                       : false;
    };
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
            StageSteps steps(options.execution.progress, 64);
            for (auto row = start + static_cast<std::uint32_t>(first); row < start + end; ++row) {
                if (!steps.done(1) || pairs.size() > options.max_pairs) return;
                const Triangle triangle = parts.triangle(row);
                const TriangleId id = parts.id(row);
                visit_triangles_in_box(parts, bounding_box(triangle),
                                       [&](TriangleId other, const Triangle& there) {
                                           if (id < other && meet_beyond_corners(triangle, there))
                                               pairs.push_back({id, other});
                                           return pairs.size() <= options.max_pairs;
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
