#include "cli/model_options.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/names.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <CLI/CLI.hpp>
#include <array>
#include <limits>
#include <utility>

namespace proxima {

void add_model_option(CLI::App& parser, std::string& model, ModelKinds kinds)
{
    constexpr std::array saved_kinds = {"", "; .pxo for a saved octree", "; .pxi for a saved index",
                                        "; .pxo and .pxi for saved octrees and indexes"};
    const char* const saved = saved_kinds[static_cast<std::size_t>(kinds)];
    parser
        .add_option("MODEL", model,
                    concat("A file (", known_mesh_extensions(), saved,
                           ") or a built-in mesh: ", sample_mesh_names()))
        ->required()
        ->type_name("");
}

void add_method_option(CLI::App& parser, OverlapMethod& method)
{
    parser
        .add_option_function<std::string>(
            "--method",
            [&method](const std::string& name) {
                const auto found = find_method(name);
                if (!found) {
                    throw CLI::ValidationError(
                        "--method", concat(name, " is no method: they are ", method_names()));
                }
                method = *found;
            },
            concat("Overlap test: ", method_names(), " (default fast)"))
        ->type_name("NAME");
}

CLI::Option* add_budget_option(CLI::App& parser, std::uint64_t& megabytes,
                               const std::string& description)
{
    return parser.add_option("--budget-mb", megabytes, description)
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40U))
        ->type_name("N");
}

CLI::Option* add_list_budget_option(CLI::App& parser, std::uint64_t& megabytes)
{
    return parser
        .add_option("--lists-mb", megabytes,
                    "Build closest-feature lists of so many 10^6 bytes at most (default: 520 bytes "
                    "per triangle, more for small meshes)")
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40U))
        ->type_name("N");
}

void add_cell_options(CLI::App& parser, int& depth, std::uint32_t& threshold)
{
    parser.add_option("--depth", depth, "Deepest level of the octree for cells, the root is 0")
        ->check(CLI::Range(0, max_octree_depth))
        ->capture_default_str()
        ->type_name("N");
    parser.add_option("--threshold", threshold, "Split cells of more triangles than this")
        ->check(CLI::Range(std::uint32_t{1}, std::numeric_limits<std::uint32_t>::max()))
        ->capture_default_str()
        ->type_name("N");
}

void refuse_cell_options(const CLI::App& parser, std::string_view what_they_go_with)
{
    for (const char* const name : {"--depth", "--threshold"}) {
        if (parser.count(name) > 0)
            throw CLI::ValidationError(name, concat("it goes with ", what_they_go_with));
    }
}

Vec3 up_axis_of_model(const std::string& model)
{
    const bool is_z = is_sample_mesh_name(model) || lower_case_extension(model) == ".3ds";
    return is_z ? Vec3::UnitZ() : Vec3::UnitY();
}

tl::unexpected<Error> at_model(Error error, const std::string& model)
{
    error.where = error.where.empty() ? model : concat(model, ": ", error.where);
    return tl::unexpected(std::move(error));
}

} // namespace proxima
