#include "cli/read_model.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/names.h"
#include "proxima/index_io.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

namespace proxima {

namespace {

/// "sphere:10x10" of "spher:10x10"; empty where no built-in has a name like it.
std::string similar_sample_mesh(const std::string& model)
{
    std::vector<std::string> names;
    for (const std::string& form : split_list(sample_mesh_names())) {
        names.push_back(
            form.substr(form.find_first_not_of(' '), form.find(':') - form.find_first_not_of(' ')));
    }
    const std::size_t colon = std::min(model.find(':'), model.size());
    const std::string name = similar_word(std::string_view(model).substr(0, colon), names);
    return name.empty() ? name : name + model.substr(colon);
}

} // namespace

Result<TriangleMesh> read_model(const std::string& model, Primitives primitives,
                                const Execution& execution)
{
    if (is_sample_mesh_name(model)) return sample_mesh(model, {.execution = execution});
    if (lower_case_extension(model) == ".pxi") {
        const auto index = load_index(model, {.execution = execution});
        if (!index) return tl::unexpected(index.error());
        auto mesh = mesh_of(*index);
        if (!mesh) return fail(ErrorCode::malformed_file, describe(mesh.error()), model);
        return mesh;
    }
    auto mesh = read_mesh(model, {.primitives = primitives, .execution = execution});
    std::error_code error;
    if (mesh || std::filesystem::exists(model, error)) return mesh;
    const std::string built_in = similar_sample_mesh(model);
    if (built_in.empty()) return mesh;
    return fail(mesh.error().code,
                concat(mesh.error().message, "; did you mean the built-in ", built_in, "?"),
                mesh.error().where);
}

bool may_be_of_points(const std::string& model, Primitives primitives, const TriangleMesh& mesh)
{
    const std::string extension = lower_case_extension(model);
    return primitives == Primitives::triangles && mesh.triangle_count() == 0 &&
           mesh.vertex_count() > 0 &&
           (extension == ".obj" || extension == ".ply" || extension == ".off");
}

} // namespace proxima
