#include <index/build_mesh_index.h>
#include <iostream>
#include <mesh/sample_meshes.h>
#include <query/culling/cull_volume.h>
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
    const auto mesh = sample_mesh("torus:200x100");
    if (!mesh) return failed(mesh.error());
    const auto index = build_mesh_index(*mesh);
    if (!index) return failed(index.error());

    // Ranges of the index's own order of triangles, as an index buffer laid out like that is drawn:
    // no allocation, some microseconds.
    std::vector<TriangleRange> ranges(index->triangle_count() / 2 + 1);
    for (const double x : {0.0, 1.0, 5.0}) {
        const auto volume =
            make_perspective_volume({.eye = Vec3(x, 0, 3), .field_of_view = 0.4, .near = 0.1});
        if (!volume) return failed(volume.error());
        const std::size_t count = visible_ranges(*index, *volume, ranges);
        std::uint32_t visible = 0;
        for (std::size_t i = 0; i < count; ++i) visible += ranges[i].count;
        std::cout << visible << " of " << index->triangle_count() << " triangles\n";
    }
}
