#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto index = sample_mesh("torus:200x100").and_then([](const TriangleMesh& mesh) {
        return build_mesh_index(mesh);
    });
    if (!index) return std::cerr << describe(index.error()) << '\n', 1;
    // Ranges of rows, as an index buffer in the order of index->ids() is drawn: no allocation.
    std::vector<TriangleRange> ranges(index->triangle_count() / 2 + 1);
    for (const double x : {0.0, 1.0, 5.0}) {
        const auto volume =
            make_perspective_volume({.eye = Vec3(x, 0, 3), .field_of_view = 0.4, .near = 0.1});
        if (!volume) return std::cerr << describe(volume.error()) << '\n', 1;
        const std::size_t count = visible_ranges(*index, *volume, ranges);
        std::uint32_t visible = 0;
        for (std::size_t i = 0; i < count; ++i) visible += ranges[i].count;
        std::cout << visible << " of " << index->triangle_count() << " triangles\n";
    }
}
