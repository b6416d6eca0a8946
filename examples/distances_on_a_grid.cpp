#include <algorithm>
#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto torus = sample_mesh("torus:60x40");
    const auto index =
        torus.and_then([](const TriangleMesh& mesh) { return build_mesh_index(mesh); })
            .and_then([](const MeshIndex& plain) { return with_signs(plain); });
    if (!index) return std::cerr << describe(index.error()) << '\n', 1;

    const auto grid = grid_around(bounding_box(*torus), {.resolution = 100});
    if (!grid) return std::cerr << describe(grid.error()) << '\n', 1;
    std::vector<double> distances(grid->point_count());
    const Status done = distance_field(*index, *grid, {.distances = distances});
    if (!done) return std::cerr << describe(done.error()) << '\n', 1;
    const auto inside = std::ranges::count_if(distances, [](double d) { return d < 0; });
    const double cell = grid->spacing * grid->spacing * grid->spacing;
    std::cout << grid->size[0] << " x " << grid->size[1] << " x " << grid->size[2]
              << " points, about " << cell * static_cast<double>(inside) << " inside, deepest "
              << std::ranges::min(distances) << '\n';
}
