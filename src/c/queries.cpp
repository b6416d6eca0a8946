// Queries of the C interface.
#include "c/handles.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/cull.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/signed_distance.h"
#include "proxima/view_volume.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace {

using namespace proxima;
using namespace proxima::c;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Arrays of C are read and written as the library's own types where these have the same layout.
static_assert(sizeof(Ray) == sizeof(proxima_ray) &&
              offsetof(proxima_ray, t_max) == 7 * sizeof(double));
static_assert(sizeof(RayHit) == sizeof(proxima_hit) &&
              offsetof(proxima_hit, u) == 2 * sizeof(double));
static_assert(sizeof(TrianglePair) == 2 * sizeof(std::uint32_t));
static_assert(sizeof(bool) == sizeof(std::uint8_t));
static_assert(static_cast<int>(FeatureKind::vertex) == PROXIMA_VERTEX &&
              static_cast<int>(FeatureKind::edge) == PROXIMA_EDGE &&
              static_cast<int>(FeatureKind::face) == PROXIMA_FACE);

proxima_closest converted(const ClosestFeature& closest)
{
    proxima_closest answer = {};
    copy_to(answer.point, closest.point);
    std::copy(closest.barycentric.begin(), closest.barycentric.end(), answer.barycentric);
    answer.squared_distance = closest.squared_distance;
    answer.triangle = to_index(closest.triangle);
    answer.feature = closest.feature.id;
    answer.kind = static_cast<std::int32_t>(closest.feature.kind);
    return answer;
}

proxima_hit converted(const RayHit& hit)
{
    return {hit.t, to_index(hit.triangle), hit.u, hit.v};
}

proxima_hit converted(const std::optional<RayHit>& hit)
{
    return hit ? converted(*hit) : proxima_hit{infinity, PROXIMA_NONE, 0, 0};
}

Ray converted(const proxima_ray& ray)
{
    return {vector_of(ray.origin), vector_of(ray.direction), ray.t_min, ray.t_max};
}

std::optional<Faces> faces_of(proxima_faces faces)
{
    switch (faces) {
    case PROXIMA_BOTH:
        return Faces::both;
    case PROXIMA_FRONT:
        return Faces::front;
    case PROXIMA_BACK:
        return Faces::back;
    }
    refused("faces: none of PROXIMA_BOTH, PROXIMA_FRONT, PROXIMA_BACK");
    return {};
}

bool is_finite(const double* point)
{
    if (vector_of(point).allFinite()) return true;
    refused("the point is not finite");
    return false;
}

/// Below 0 nothing is found; NaN is a mistake of the caller. `message` is for that.
bool is_number(double bound, const char* message)
{
    if (!std::isnan(bound)) return true;
    refused(message);
    return false;
}

bool is_ray(const Ray& ray)
{
    if (is_valid(ray)) return true;
    refused("the ray has a number that is not finite, no direction, or an empty range");
    return false;
}

std::span<const Ray> rays_of(const proxima_ray* rays, std::size_t count)
{
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): asserted above
    return {reinterpret_cast<const Ray*>(rays), count};
}

} // namespace

proxima_status proxima_closest_feature(const proxima_index* index, const double point[3],
                                       double radius, proxima_closest* closest)
{
    if (any_null(index, point, closest) || !is_finite(point) ||
        !is_number(radius, "radius: is NaN; give a number, or INFINITY for any distance"))
        return PROXIMA_INVALID_ARGUMENT;
    const auto found = closest_feature(index->index, vector_of(point), {.radius = radius});
    *closest = converted(found.value_or(no_closest_feature()));
    return PROXIMA_OK;
}

proxima_status proxima_closest_features(const proxima_index* index, const double* points,
                                        size_t count, const proxima_execution* execution,
                                        proxima_closest* closest, double* squared_distances,
                                        uint32_t* triangles)
{
    if (any_null(index) || (count > 0 && any_null(points))) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Execution> how = execution_of(execution);
    if (!how) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        // An error must leave the caller's arrays as they are.
        std::vector<ClosestFeature> answers(closest != nullptr ? count : 0);
        std::vector<double> squared(squared_distances != nullptr ? count : 0);
        std::vector<TriangleId> ids(triangles != nullptr ? count : 0);
        const Status done =
            closest_features(index->index, points_of(points, count),
                             {.answers = answers, .squared_distances = squared, .triangles = ids},
                             {.execution = *how});
        if (!done) return failed(done.error());
        std::copy(squared.begin(), squared.end(), squared_distances);
        std::transform(answers.begin(), answers.end(), closest,
                       [](const ClosestFeature& answer) { return converted(answer); });
        std::transform(ids.begin(), ids.end(), triangles,
                       [](TriangleId id) { return to_index(id); });
        return PROXIMA_OK;
    });
}

proxima_status proxima_signed_distance(const proxima_index* index, const double point[3],
                                       double* distance)
{
    if (any_null(index, point, distance) || !is_finite(point)) return PROXIMA_INVALID_ARGUMENT;
    const auto found = signed_distance(index->index, vector_of(point));
    if (!found) return refused("the index has no signs: build it with PROXIMA_SIGNS");
    *distance = found->distance;
    return PROXIMA_OK;
}

proxima_status proxima_signed_distances(const proxima_index* index, const double* points,
                                        size_t count, const proxima_execution* execution,
                                        double* distances)
{
    if (any_null(index) || (count > 0 && any_null(points, distances)))
        return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Execution> how = execution_of(execution);
    if (!how) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        std::vector<double> found(count);
        const Status done = signed_distances(index->index, points_of(points, count),
                                             {.distances = found}, {.execution = *how});
        if (!done) return failed(done.error());
        std::copy(found.begin(), found.end(), distances);
        return PROXIMA_OK;
    });
}

proxima_status proxima_first_hit(const proxima_index* index, const proxima_ray* ray,
                                 proxima_faces faces, proxima_hit* hit)
{
    if (any_null(index, ray, hit)) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Faces> sides = faces_of(faces);
    const Ray own = converted(*ray);
    if (!sides || !is_ray(own)) return PROXIMA_INVALID_ARGUMENT;
    *hit = converted(closest_hit(index->index, own, *sides));
    return PROXIMA_OK;
}

proxima_status proxima_first_hits(const proxima_index* index, const proxima_ray* rays, size_t count,
                                  proxima_faces faces, const proxima_execution* execution,
                                  proxima_hit* hits)
{
    if (any_null(index) || (count > 0 && any_null(rays, hits))) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Faces> sides = faces_of(faces);
    if (!sides) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Execution> how = execution_of(execution);
    if (!how) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        std::vector<std::optional<RayHit>> found(count);
        const Status done = closest_hits(index->index, rays_of(rays, count), found,
                                         {.faces = *sides, .execution = *how});
        if (!done) return failed(done.error());
        std::transform(found.begin(), found.end(), hits,
                       [](const std::optional<RayHit>& hit) { return converted(hit); });
        return PROXIMA_OK;
    });
}

proxima_status proxima_any_hits(const proxima_index* index, const proxima_ray* rays, size_t count,
                                proxima_faces faces, const proxima_execution* execution,
                                uint8_t* answers)
{
    if (any_null(index) || (count > 0 && any_null(rays, answers))) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Faces> sides = faces_of(faces);
    if (!sides) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Execution> how = execution_of(execution);
    if (!how) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const std::unique_ptr<bool[]> found(new bool[count]());
        const Status done = any_hits(index->index, rays_of(rays, count), {found.get(), count},
                                     {.faces = *sides, .execution = *how});
        if (!done) return failed(done.error());
        std::copy_n(found.get(), count, answers);
        return PROXIMA_OK;
    });
}

proxima_status proxima_all_hits(const proxima_index* index, const proxima_ray* ray,
                                proxima_faces faces, proxima_hit* hits, size_t capacity,
                                size_t* count)
{
    if (any_null(index, ray, count) || (capacity > 0 && any_null(hits)))
        return PROXIMA_INVALID_ARGUMENT;
    const std::optional<Faces> sides = faces_of(faces);
    const Ray own = converted(*ray);
    if (!sides || !is_ray(own)) return PROXIMA_INVALID_ARGUMENT;
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): asserted above
    const std::span<RayHit> found(reinterpret_cast<RayHit*>(hits), capacity);
    *count = all_hits(index->index, own, found, *sides);
    return PROXIMA_OK;
}

proxima_status proxima_meshes_intersect(const proxima_index* a, const proxima_index* b,
                                        const double pose_b[12], int32_t* answer)
{
    if (any_null(a, b, answer)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<RigidTransform> pose = pose_of(pose_b);
        if (!pose) return failed(pose.error());
        *answer = meshes_intersect(a->index, b->index, *pose) ? 1 : 0;
        return PROXIMA_OK;
    });
}

proxima_status proxima_intersecting_pairs(const proxima_index* a, const proxima_index* b,
                                          const double pose_b[12], uint32_t* pairs, size_t capacity,
                                          size_t* count)
{
    if (any_null(a, b, count) || (capacity > 0 && any_null(pairs))) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<RigidTransform> pose = pose_of(pose_b);
        if (!pose) return failed(pose.error());
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): asserted above
        const std::span<TrianglePair> found(reinterpret_cast<TrianglePair*>(pairs), capacity);
        *count = intersecting_pairs(a->index, b->index, *pose, found);
        return PROXIMA_OK;
    });
}

proxima_status proxima_mesh_distance(const proxima_index* a, const proxima_index* b,
                                     const double pose_b[12], double farthest,
                                     proxima_distance* distance)
{
    if (any_null(a, b, distance) ||
        !is_number(farthest, "farthest: is NaN; give a number, or INFINITY for any distance"))
        return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<RigidTransform> pose = pose_of(pose_b);
        if (!pose) return failed(pose.error());
        const auto near = mesh_distance(a->index, b->index, *pose, {.farthest = farthest});
        *distance = {infinity, {}, {}, PROXIMA_NONE, PROXIMA_NONE};
        if (!near) return PROXIMA_OK;
        distance->distance = near->distance;
        copy_to(distance->point_a, near->point_a);
        copy_to(distance->point_b, near->point_b);
        distance->triangle_a = to_index(near->triangle_a);
        distance->triangle_b = to_index(near->triangle_b);
        return PROXIMA_OK;
    });
}

proxima_status proxima_visible_triangles(const proxima_index* index, const double* planes,
                                         size_t plane_count, int32_t exact, uint32_t* ids,
                                         size_t capacity, size_t* count)
{
    if (any_null(index, planes, count) || (capacity > 0 && any_null(ids)))
        return PROXIMA_INVALID_ARGUMENT;
    static_assert(max_view_planes == 1024);
    if (const auto status =
            check_count(plane_count, max_view_planes, "a view volume has at most 1024 planes");
        status != PROXIMA_OK)
        return status;
    return guarded([&] {
        std::vector<ViewPlane> sides(plane_count);
        for (std::size_t i = 0; i < plane_count; ++i)
            sides[i] = {vector_of(planes + 4 * i), planes[4 * i + 3]};
        const Result<ViewVolume> volume = make_view_volume(sides);
        if (!volume) return failed(volume.error());
        const std::vector<TriangleId> seen = visible_triangles(
            index->index, *volume, exact != 0 ? CullMode::exact : CullMode::conservative);
        *count = seen.size();
        std::transform(seen.begin(),
                       seen.begin() + static_cast<std::ptrdiff_t>(std::min(*count, capacity)), ids,
                       [](TriangleId id) { return to_index(id); });
        return PROXIMA_OK;
    });
}
