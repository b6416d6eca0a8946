// Hits of rays with any triangles against a test of every triangle: the same bits.
#include "base/check.h"
#include "decoded_mesh.h"
#include "oracles/ray_hits.h"
#include "proxima/cast_ray.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace {

using namespace proxima;

/// From a point towards another, along an axis, or in any direction; with any range.
Ray decode_ray(fuzz::Bytes& bytes, const fuzz::PositionCode& code, const TriangleMesh& mesh)
{
    Ray ray;
    const std::uint8_t form = bytes.next();
    ray.origin = fuzz::decode_point(bytes, code, mesh);
    ray.direction = form % 4 == 0   ? Vec3::Unit(form / 4 % 3)
                    : form % 4 == 1 ? Vec3(bytes.next_signed(), bytes.next_signed(), 1)
                                    : fuzz::decode_point(bytes, code, mesh) - ray.origin;
    if (form >= 128) ray.t_min = bytes.next_signed() / 16.0;
    if (form >= 192) ray.t_max = bytes.next_signed() / 16.0;
    return ray;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    constexpr Faces all_faces[] = {Faces::both, Faces::both, Faces::front, Faces::back};
    const Faces faces = all_faces[bytes.next() % 4];
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code);
    const Execution alone{.threads = {1}};
    const MeshIndex index = build_mesh_index(mesh, {.execution = alone}).value();
    std::vector<Ray> rays;
    do {
        rays.push_back(decode_ray(bytes, code, mesh));
    } while (bytes.left() > 0 && rays.size() < 16);
    std::vector<std::optional<RayHit>> closest(rays.size());
    const bool all_sound = std::ranges::all_of(rays, is_valid);
    const Status done = closest_hits(index, rays, closest, {faces, alone});
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::vector<RayHit> truth = all_hits_by_brute_force(mesh, rays[i], faces);
        const std::optional<RayHit> first =
            truth.empty() ? std::nullopt : std::optional(truth.front());
        PROXIMA_CHECK(all_hits(index, rays[i], faces) == truth);
        PROXIMA_CHECK(closest_hit(index, rays[i], faces) == first);
        PROXIMA_CHECK_EQ(any_hit(index, rays[i], faces), first.has_value());
        if (all_sound) PROXIMA_CHECK(done.has_value() && closest[i] == first);
    }
    return 0;
}
