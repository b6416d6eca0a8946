#include "cli/model_options.h"

#include "base/text.h"
#include "cli/names.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <CLI/CLI.hpp>
#include <array>
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
            concat("Overlap test: ", method_names()))
        ->type_name("NAME");
}

CLI::Option* add_budget_option(CLI::App& parser, std::uint64_t& megabytes,
                               const std::string& description)
{
    return parser.add_option("--budget-mb", megabytes, description)
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40U))
        ->type_name("N");
}

UpAxis up_axis_of_model(const std::string& model)
{
    return is_sample_mesh_name(model) ? UpAxis::z : UpAxis::y;
}

tl::unexpected<Error> at_model(Error error, const std::string& model)
{
    error.where = error.where.empty() ? model : concat(model, ": ", error.where);
    return tl::unexpected(std::move(error));
}

} // namespace proxima
