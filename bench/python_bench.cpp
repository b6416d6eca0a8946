// The C++ side of python_bench.py, which calls it in its own process, so that both sides take turns in the same memory.
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

using namespace proxima;

namespace {

MeshIndex mesh_index;
std::vector<ClosestFeature> answers;

std::span<const Vec3> points_of(const double* points, std::size_t count)
{
    return {static_cast<const Vec3*>(static_cast<const void*>(points)), count};
}

constexpr BatchOptions one_thread{.execution = {.threads = {1}}};

} // namespace

extern "C" {

/// Whether the mesh could be read and its index built.
PROXIMA_EXPORT bool prepare(const char* mesh, std::size_t most_points)
{
    const auto built =
        read_mesh(mesh).and_then([](const TriangleMesh& read) { return build_mesh_index(read); });
    if (!built) return false;
    mesh_index = *built;
    answers.resize(most_points);
    return true;
}

PROXIMA_EXPORT bool distances_and_ids(const double* points, std::size_t count, double* squared,
                                      TriangleId* triangles)
{
    return closest_features(
               mesh_index, points_of(points, count),
               {.squared_distances = {squared, count}, .triangles = {triangles, count}}, one_thread)
        .has_value();
}

PROXIMA_EXPORT bool all_columns(const double* points, std::size_t count)
{
    return closest_features(mesh_index, points_of(points, count),
                            {.answers = std::span(answers).first(count)}, one_thread)
        .has_value();
}

/// The sum of the distances, one query for each point.
PROXIMA_EXPORT double one_by_one(const double* points, std::size_t count)
{
    double sum = 0;
    for (const Vec3& point : points_of(points, count))
        sum += std::sqrt(closest_feature(mesh_index, point)->squared_distance);
    return sum;
}
}
