// Batches of rays of which many are all but the same, which packets take together, against a test of
// every triangle: the same bits.
#include "base/check.h"
#include "decoded_mesh.h"
#include "oracles/ray_hits.h"
#include "proxima/cast_ray.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace {

using namespace proxima;

/// Up to 16 rays from one place, or near it, in about one direction; valid ones.
void add_bundle(fuzz::Bytes& bytes, const fuzz::PositionCode& code, const TriangleMesh& mesh,
                std::vector<Ray>& rays)
{
    const std::uint8_t form = bytes.next();
    Ray first;
    first.origin = fuzz::decode_point(bytes, code, mesh);
    first.direction = form % 4 == 0 ? Vec3(Vec3::Unit(form / 4 % 3))
                                    : Vec3(fuzz::decode_point(bytes, code, mesh) - first.origin);
    if (form >= 192) {
        first.t_min = bytes.next_signed() / 16.0;
        first.t_max = first.t_min + bytes.next() / 16.0;
    }
    if (!is_valid(first)) return;
    const double spread = std::ldexp(1.0, -(form / 4 % 32));
    for (int i = form % 3 == 0 ? 16 : 8; i > 0; --i) {
        Ray ray = first;
        for (double& part : ray.direction) part *= 1 + spread * bytes.next_signed() / 128;
        if (form >= 64)
            for (double& part : ray.origin) part *= 1 + spread * bytes.next_signed() / 128;
        rays.push_back(is_valid(ray) ? ray : first);
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    constexpr std::array all_faces = {Faces::both, Faces::both, Faces::front, Faces::back};
    const Faces faces = all_faces[bytes.next() % 4];
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code);
    const Execution alone{.threads = {1}};
    const MeshIndex index = build_mesh_index(mesh, {.execution = alone}).value();
    std::vector<Ray> rays;
    do {
        add_bundle(bytes, code, mesh, rays);
    } while (bytes.left() > 0 && rays.size() < 64);
    if (rays.empty()) return 0;
    std::vector<std::optional<RayHit>> closest(rays.size());
    std::array<bool, 80> any{};
    const RayBatchOptions options{faces, alone};
    PROXIMA_CHECK(closest_hits(index, rays, closest, options).has_value());
    PROXIMA_CHECK(any_hits(index, rays, std::span(any).first(rays.size()), options).has_value());
    const RayHitLists all = all_hits(index, rays, options).value();
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::vector<RayHit> truth = all_hits_by_brute_force(mesh, rays[i], faces);
        const std::optional<RayHit> first =
            truth.empty() ? std::nullopt : std::optional(truth.front());
        PROXIMA_CHECK(closest[i] == first);
        PROXIMA_CHECK_EQ(any[i], first.has_value());
        const auto own = std::span(all.hits).subspan(all.first[i], all.first[i + 1] - all.first[i]);
        PROXIMA_CHECK(std::ranges::equal(own, truth));
    }
    return 0;
}
