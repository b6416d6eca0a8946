#include <index/build_mesh_index.h>
#include <iostream>
#include <mesh/sample_meshes.h>
#include <mesh/topology.h>
#include <query/closest/closest_feature.h>
#include <query/closest/signed_distance.h>

namespace {

int failed(const proxima::Error& error)
{
    std::cerr << describe(error) << '\n';
    return 1;
}

} // namespace

int main()
{
    using namespace proxima;
    const auto mesh = sample_mesh("torus:60x40");
    if (!mesh) return failed(mesh.error());
    const auto topology = build_topology(*mesh);
    if (!topology) return failed(topology.error());

    // Once for a mesh: by what closest features are found, and what tells inside from outside.
    const auto built = build_mesh_index(*mesh);
    if (!built) return failed(built.error());
    const auto sign = build_surface_sign(*mesh, *topology);
    if (!sign) return failed(sign.error());

    // From any thread, in about a microsecond: no lock, no allocation.
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0.8, 0, 0), Vec3(2, 1, 0)}) {
        const SignedDistance found = sign_of(*sign, closest_feature(*built, p).value(), p);
        std::cout << (found.distance < 0 ? "inside" : "outside") << ", " << found.distance
                  << " from triangle " << index(found.closest.triangle) << " at "
                  << found.closest.point.transpose() << '\n';
    }
}
