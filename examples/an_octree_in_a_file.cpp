#include <filesystem>
#include <index/file/proximity_file.h>
#include <index/lists/build_proximity_octree.h>
#include <iostream>
#include <proxima/sample_meshes.h>
#include <query/closest/closest_feature.h>

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
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "an_octree.pxp";
    const auto mesh = sample_mesh("sphere:50x50");
    if (!mesh) return failed(mesh.error());
    const auto octree =
        build_proximity_octree(*mesh, {.budget_bytes = 600 * mesh->triangle_count()});
    if (!octree) return failed(octree.error());
    if (const Status saved = save_proximity_octree(*octree, path); !saved)
        return failed(saved.error());

    // Another program, another day: mapped, not built. What a query takes at most, the octree
    // knows.
    const auto again = load_proximity_octree(path);
    if (!again) return failed(again.error());
    const ClosestFeature found = closest_feature(*again, Vec3(0.1, 0.2, 3));
    std::cout << "triangle " << index(found.triangle) << ", squared distance "
              << found.squared_distance << ", at most " << again->statistics().worst_case_steps
              << " steps\n";
    std::filesystem::remove(path);
}
