#include "cli/thesis_models.h"

#include "base/text.h"

#include <system_error>

namespace proxima {

std::string usual_model_folder()
{
    std::error_code error;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
    for (auto folder = program.parent_path(); folder.has_relative_path();
         folder = folder.parent_path()) {
        const bool is_checkout = std::filesystem::exists(folder / "CMakePresets.json", error);
        const auto meshes = folder.parent_path() / "shared" / "meshes";
        if (is_checkout && std::filesystem::is_directory(meshes, error)) return meshes.string();
    }
    return {};
}

std::optional<std::filesystem::path> file_of(const thesis::Model& model, const std::string& folder)
{
    if (folder.empty()) return std::nullopt;
    std::filesystem::path file = std::filesystem::path(folder) / model.file;
    std::error_code error;
    if (!std::filesystem::exists(file, error)) return std::nullopt;
    return file;
}

std::string how_to_get(const thesis::Model& model, const std::string& folder)
{
    const std::string missing =
        folder.empty()
            ? concat("no folder is known that may hold ", model.file)
            : concat("there is no ", (std::filesystem::path(folder) / model.file).string());
    return concat(missing, "; it is in ", model.archive,
                  " of the Stanford 3D Scanning Repository "
                  "(https://graphics.stanford.edu/data/3Dscanrep). Put it into a folder under this "
                  "name, and name the folder: --meshes DIR.");
}

} // namespace proxima
