// Signs of distances to the surfaces of any tetrahedra, however they lie in each other, and what they
// enclose, against exact crossings of a line to far away. Batches have the same bits.
#include "base/check.h"
#include "decoded_mesh.h"
#include "oracles/exact_winding.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

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
    const Enclosure enclosure = build_enclosure(plain, {alone}).value();
    PROXIMA_CHECK(enclosure.method() == InsideMethod::crossings);
    std::vector<Vec3> points;
    do {
        points.push_back(fuzz::decode_point(bytes, code, mesh));
    } while (bytes.left() > 0 && points.size() < 16);
    std::vector<SignedDistance> batch(points.size());
    PROXIMA_CHECK(
        signed_distances(index, points, {.answers = batch}, {.execution = alone}).has_value());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3& p = points[i];
        const auto found = signed_distance(index, p);
        PROXIMA_CHECK(found.has_value());
        PROXIMA_CHECK(batch[i].distance == found->distance && batch[i].method == found->method);
        PROXIMA_CHECK(batch[i].closest.feature == found->closest.feature);
        const auto again = sign_of(index, *closest_feature(index, p), p);
        PROXIMA_CHECK(again && again->distance == found->distance &&
                      again->method == found->method);
        // Within rounding of the surface either side will do.
        if (std::abs(found->distance) <= 1e-14 * (p.cwiseAbs().maxCoeff() + box_size)) continue;
        const auto winding = oracle::exact_winding(mesh, p);
        if (!winding) continue;
        PROXIMA_CHECK_EQ(found->distance < 0, *winding >= 1);
        PROXIMA_CHECK_EQ(encloses(enclosure, {}, p), *winding != 0);
    }
    return 0;
}
