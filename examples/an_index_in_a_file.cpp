#include <filesystem>
#include <index/build_mesh_index.h>
#include <index/file/index_file.h>
#include <index/lists/build_lists.h>
#include <iostream>
#include <mesh/sample_meshes.h>
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
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "an_index.pxi";
    const auto mesh = sample_mesh("sphere:50x50");
    if (!mesh) return failed(mesh.error());
    const auto plain = build_mesh_index(*mesh);
    if (!plain) return failed(plain.error());
    // Lists bound the slowest query; without them the answers are the same.
    const auto index = with_lists(*plain, {.budget_bytes = 500 * mesh->triangle_count()});
    if (!index) return failed(index.error());
    if (const Status saved = save_index(*index, path); !saved) return failed(saved.error());

    // Another program maps the file and builds nothing. The lists know the worst case of a query.
    const auto again = load_index(path);
    if (!again) return failed(again.error());
    const ClosestFeature found = closest_feature(*again, Vec3(0.1, 0.2, 3)).value();
    std::cout << "triangle " << proxima::index(found.triangle) << ", squared distance "
              << found.squared_distance << ", at most "
              << again->lists()->statistics().worst_case_steps << " steps\n";
    std::filesystem::remove(path);
}
