// An index fitted to vertices that moved anywhere, saved and loaded, answers like a look at every
// triangle: the same bits. Closest features also from any earlier answer, and within radii.
#include "base/check.h"
#include "decoded_mesh.h"
#include "oracles/ray_hits.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/index_io.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"
#include "query/closest/brute_force.h"
#include "slow_answers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

using namespace proxima;

constexpr Execution alone{.threads = {1}};

/// The mesh with some of its vertices elsewhere.
TriangleMesh moved(const TriangleMesh& mesh, fuzz::Bytes& bytes, const fuzz::PositionCode& code)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    const std::uint8_t every = 1 + bytes.next() % 8;
    for (std::size_t i = 0; i < positions.size(); i += every)
        positions[i] = fuzz::decode_point(bytes, code, mesh);
    const auto triangles = mesh.triangles();
    return *make_triangle_mesh(std::move(positions), {triangles.begin(), triangles.end()});
}

/// The index from its file.
MeshIndex saved_and_loaded(const MeshIndex& index)
{
    const auto file = std::filesystem::temp_directory_path() /
                      ("proxima_fuzz_" + std::to_string(::getpid()) + ".pxi");
    PROXIMA_CHECK(save_index(index, file).has_value());
    const auto loaded = load_index(file);
    std::filesystem::remove(file);
    PROXIMA_CHECK(loaded.has_value());
    return *loaded;
}

/// From where the last answer was and within radii about the distance. A radius is taken for one that is off by a few
/// roundings, and squares of the smallest vanish.
void check_closest(const MeshIndex& index, const Vec3& p, const ClosestFeature& truth,
                   const ClosestFeature& start)
{
    fuzz::expect_same(closest_feature(index, p).value(), truth);
    fuzz::expect_same(closest_feature(index, p, {.start_from = &start}).value(), truth);
    const double distance = std::sqrt(truth.squared_distance);
    if (distance < 1e-140 || !std::isfinite(distance)) return;
    const auto within = [&](double radius) {
        return closest_feature(index, p, {.radius = radius, .start_from = &start});
    };
    fuzz::expect_same(within(distance * (1 + 1e-12)).value(), truth);
    PROXIMA_CHECK(!within(distance * (1 - 1e-12)).has_value());
    PROXIMA_CHECK(!within(-distance).has_value());
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint8_t form = bytes.next();
    const fuzz::PositionCode code(bytes);
    const TriangleMesh before = fuzz::decode_mesh(bytes, code);
    MeshIndex index = build_mesh_index(before, {.execution = alone}).value();
    if (form % 8 == 0) {
        const ListOptions small{.list_bytes = 20'000, .max_depth = 6, .execution = alone};
        if (auto listed = with_lists(index, small)) index = *listed;
    }
    const TriangleMesh mesh = moved(before, bytes, code);
    const Topology topology = build_topology(mesh).value();
    const auto refitted = refit_index(index, mesh, topology, {.execution = alone});
    if (!refitted) return 0; // lists that no longer fit their size
    index = form % 16 == 1 ? saved_and_loaded(*refitted) : *refitted;
    const TriangleMesh again = mesh_of(index).value();
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle expected = mesh.triangle(TriangleId{i});
        PROXIMA_CHECK(again.triangle(TriangleId{i}).vertices == expected.vertices);
    }
    const auto pairs = find_self_intersections(index, {.execution = alone}).value().pairs;
    PROXIMA_CHECK(pairs == fuzz::self_intersections(mesh));
    ClosestFeature start = no_closest_feature();
    int asked = 0;
    do {
        const Vec3 p = fuzz::decode_point(bytes, code, mesh);
        const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, p);
        check_closest(index, p, truth, start);
        start = truth;
        const Ray ray{.origin = p, .direction = fuzz::decode_point(bytes, code, mesh) - p};
        PROXIMA_CHECK(all_hits(index, ray) == all_hits_by_brute_force(mesh, ray, Faces::both));
    } while (bytes.left() > 0 && ++asked < 16);
    return 0;
}
