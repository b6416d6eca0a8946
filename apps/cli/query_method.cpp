#include "cli/query_method.h"

#include "base/text.h"

#include <CLI/CLI.hpp>

namespace proxima {

std::string_view name_of(QueryMethod method) noexcept
{
    return method == QueryMethod::thesis ? "thesis" : "index";
}

void add_query_method_option(CLI::App& parser, QueryMethod& method, std::string_view how)
{
    parser
        .add_option_function<std::string>(
            "--method",
            [&method](const std::string& name) {
                if (name != "index" && name != "thesis") {
                    throw CLI::ValidationError(
                        "--method", concat(name, " is no method: they are index and thesis"));
                }
                method = name == "thesis" ? QueryMethod::thesis : QueryMethod::index;
            },
            concat("What to search: index (the fast one, default), or thesis: ", how))
        ->type_name("NAME");
}

} // namespace proxima
