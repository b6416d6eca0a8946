#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "an_index.pxi";
    const Status saved =
        sample_mesh("sphere:50x50")
            .and_then([](const TriangleMesh& mesh) { return build_mesh_index(mesh); })
            .and_then([](const MeshIndex& plain) { return with_lists(plain); })
            .and_then([&](const MeshIndex& index) { return save_index(index, path); });
    if (!saved) return std::cerr << describe(saved.error()) << '\n', 1;

    // Another program maps the file and builds nothing. The mesh is in it, too.
    const auto index = load_index(path);
    if (!index) return std::cerr << describe(index.error()) << '\n', 1;
    if (const auto found = closest_feature(*index, Vec3(0.1, 0.2, 3))) {
        std::cout << "triangle " << to_index(found->triangle) << " of " << index->triangle_count()
                  << ", squared distance " << found->squared_distance << '\n';
    }
    std::filesystem::remove(path);
}
