#include <index/build_mesh_index.h>
#include <iostream>
#include <mesh/sample_meshes.h>
#include <optional>
#include <query/rays/cast_ray.h>
#include <vector>

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
    const auto mesh = sample_mesh("sphere:100x100");
    if (!mesh) return failed(mesh.error());
    const auto index = build_mesh_index(*mesh);
    if (!index) return failed(index.error());

    // One ray, real-time safe. Between neighbouring triangles none is lost: this one goes straight
    // through the pole, where a hundred of them meet.
    const Ray down{.origin = {0, 0, 5}, .direction = {0, 0, -1}};
    if (const auto hit = closest_hit(*index, down)) {
        std::cout << "t " << hit->t << " at " << down.at(hit->t).transpose() << '\n';
    }

    // Many rays, on all cores: a picture of 40 by 20 letters.
    std::vector<Ray> rays;
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 40; ++x) {
            rays.push_back(
                {.origin = {(x - 19.5) / 16, -5, (9.5 - y) / 8}, .direction = {0, 1, 0}});
        }
    }
    std::vector<std::optional<RayHit>> hits(rays.size());
    if (const Status cast = closest_hits(*index, rays, hits); !cast) return failed(cast.error());
    for (std::size_t i = 0; i < hits.size(); ++i) {
        std::cout << (hits[i] ? '#' : '.') << (i % 40 == 39 ? "\n" : "");
    }
}
