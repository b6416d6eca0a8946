// Triangles that view volumes and boxes see, against a test of every triangle.
#include "base/check.h"
#include "decoded_mesh.h"
#include "geometry/view_contact.h"
#include "proxima/cull.h"
#include "proxima/mesh_index.h"
#include "proxima/view_volume.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace proxima;

/// A box with corners at decoded points, or any planes through such points.
std::vector<ViewPlane> decode_planes(fuzz::Bytes& bytes, const fuzz::PositionCode& code,
                                     const TriangleMesh& mesh)
{
    std::vector<ViewPlane> planes;
    const std::uint8_t form = bytes.next();
    const auto add = [&](const Vec3& normal, const Vec3& through) {
        planes.push_back({normal, -normal.dot(through)});
    };
    if (form % 2 == 0) {
        const Vec3 p = fuzz::decode_point(bytes, code, mesh);
        const Vec3 q = fuzz::decode_point(bytes, code, mesh);
        for (int axis = 0; axis < 3; ++axis) {
            add(Vec3::Unit(axis), p.cwiseMin(q));
            add(-Vec3::Unit(axis), p.cwiseMax(q));
        }
        return planes;
    }
    for (int i = 0; i <= form / 2 % 8; ++i) {
        const Vec3 normal(bytes.next_signed(), bytes.next_signed(), bytes.next_signed());
        if (!normal.isZero()) add(normal, fuzz::decode_point(bytes, code, mesh));
    }
    return planes;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code);
    const MeshIndex index = build_mesh_index(mesh, {.execution = {.threads = {1}}}).value();
    int volumes = 0;
    do {
        const auto volume = make_view_volume(decode_planes(bytes, code, mesh));
        if (!volume) continue;
        for (const CullMode mode : {CullMode::conservative, CullMode::exact}) {
            std::vector<TriangleId> truth;
            for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
                const Triangle triangle = mesh.triangle(TriangleId{i});
                if (mode == CullMode::exact ? meets_volume(*volume, triangle)
                                            : passes_planes(*volume, triangle))
                    truth.push_back(TriangleId{i});
            }
            PROXIMA_CHECK(visible_triangles(index, *volume, mode) == truth);
        }
    } while (bytes.left() > 0 && ++volumes < 8);
    return 0;
}
