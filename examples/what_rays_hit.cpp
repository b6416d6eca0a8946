#include <algorithm>
#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto index = sample_mesh("sphere:100x100").and_then([](const TriangleMesh& mesh) {
        return build_mesh_index(mesh);
    });
    if (!index) return std::cerr << describe(index.error()) << '\n', 1;

    // A picture of a million rays, on all cores: neighbours side by side, as a camera sends them.
    std::vector<Ray> rays;
    for (int pixel = 0; pixel < 1'000'000; ++pixel) {
        const double x = pixel % 1000 / 500.0 - 0.999;
        const double z = pixel / 1000 / 500.0 - 0.999;
        rays.push_back({.origin = {x, -5, z}, .direction = {0, 1, 0}});
    }
    std::vector<std::optional<RayHit>> hits(rays.size());
    const Status done = closest_hits(*index, rays, hits);
    if (!done) return std::cerr << describe(done.error()) << '\n', 1;
    std::cout << std::ranges::count_if(hits, [](const auto& hit) { return hit.has_value(); })
              << " rays hit\n";
}
