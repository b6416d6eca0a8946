// Signs of distances to the surfaces of any tetrahedra, however they lie in each other, against
// exact crossings of a line to far away.
#include "base/check.h"
#include "decoded_mesh.h"
#include "oracles/exact_winding.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using namespace proxima;
    fuzz::Bytes bytes({data, size});
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code, fuzz::Shape::closed);
    const Execution alone{.threads = {1}};
    const MeshIndex plain = build_mesh_index(mesh, {.execution = alone}).value();
    const MeshIndex index = with_signs(plain, {.execution = alone}).value();
    const double box_size = bounding_box(mesh).upper.cwiseAbs().maxCoeff() +
                            bounding_box(mesh).lower.cwiseAbs().maxCoeff();
    int points = 0;
    do {
        const Vec3 p = fuzz::decode_point(bytes, code, mesh);
        const auto found = signed_distance(index, p);
        PROXIMA_CHECK(found.has_value());
        // Within rounding of the surface either side will do.
        if (std::abs(found->distance) <= 1e-14 * (p.cwiseAbs().maxCoeff() + box_size)) continue;
        const auto winding = oracle::exact_winding(mesh, p);
        if (winding) PROXIMA_CHECK_EQ(found->distance < 0, *winding >= 1);
    } while (bytes.left() > 0 && ++points < 16);
    return 0;
}
