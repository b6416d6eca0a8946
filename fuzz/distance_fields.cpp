// Signed distances on grids, and closest features after vertices moved, against single queries and
// brute force.
#include "base/check.h"
#include "decoded_mesh.h"
#include "proxima/closest_feature.h"
#include "proxima/distance_field.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"
#include "proxima/topology.h"
#include "query/closest/brute_force.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace proxima;

void expect_field(const MeshIndex& index, const PointGrid& grid, double band)
{
    std::vector<double> distances(grid.point_count());
    std::vector<SignMethod> methods(grid.point_count());
    const Status done = distance_field(index, grid, {.distances = distances, .methods = methods},
                                       {.band = band, .execution = {.threads = {1}}});
    if (!done) {
        PROXIMA_CHECK(!(grid.spacing > 0) || !(band > 0));
        return;
    }
    for (std::uint32_t k = 0; k < grid.size[2]; ++k) {
        for (std::uint32_t j = 0; j < grid.size[1]; ++j) {
            for (std::uint32_t i = 0; i < grid.size[0]; ++i) {
                const auto single = signed_distance(index, grid.point(i, j, k));
                PROXIMA_CHECK(single.has_value());
                const bool is_far = !(std::abs(single->distance) <= band);
                const double truth =
                    is_far ? std::copysign(band, single->distance) : single->distance;
                PROXIMA_CHECK_EQ(distances[grid.position(i, j, k)], truth);
                if (!is_far) PROXIMA_CHECK(methods[grid.position(i, j, k)] == single->method);
            }
        }
    }
}

/// The index, refitted to vertices elsewhere.
void expect_refit(const MeshIndex& index, const TriangleMesh& mesh, fuzz::Bytes& bytes,
                  const fuzz::PositionCode& code)
{
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    for (int i = 0; i < 8; ++i)
        positions[bytes.next() % positions.size()] = fuzz::decode_point(bytes, code, mesh);
    const TriangleMesh moved = *make_triangle_mesh(
        std::move(positions), {mesh.triangles().begin(), mesh.triangles().end()});
    const Topology topology = build_topology(moved).value();
    const MeshIndex refitted =
        refit_index(index, moved, topology, {.execution = {.threads = {1}}}).value();
    for (int i = 0; i < 4; ++i) {
        const Vec3 p = fuzz::decode_point(bytes, code, moved);
        const ClosestFeature truth = closest_feature_by_brute_force(moved, topology, p);
        const auto found = closest_feature(refitted, p);
        PROXIMA_CHECK(found.has_value());
        PROXIMA_CHECK(found->feature == truth.feature);
        PROXIMA_CHECK(found->triangle == truth.triangle);
        PROXIMA_CHECK(found->squared_distance == truth.squared_distance);
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const auto shape = bytes.next() % 2 == 0 ? fuzz::Shape::closed : fuzz::Shape::soup;
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code, shape);
    const Execution alone{.threads = {1}};
    const MeshIndex plain = build_mesh_index(mesh, {.execution = alone}).value();
    const MeshIndex index = with_signs(plain, {.execution = alone}).value();
    expect_refit(plain, mesh, bytes, code);
    PointGrid grid;
    grid.origin = fuzz::decode_point(bytes, code, mesh);
    const double reach =
        (fuzz::decode_point(bytes, code, mesh) - grid.origin).cwiseAbs().maxCoeff();
    for (std::uint32_t& n : grid.size) n = 1 + bytes.next() % 9U;
    // In whole steps to a point of the mesh, perhaps.
    grid.spacing = reach / (1 + bytes.next() % 8U);
    const std::uint8_t band = bytes.next();
    expect_field(index, grid, band < 128 ? HUGE_VAL : band / 64.0 * grid.spacing);
    return 0;
}
