#include "cli/only_option.h"

#include "base/text.h"
#include "cli/names.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace proxima {

void OnlyOption::add_to(CLI::App& parser)
{
    std::string all;
    for (const std::string_view number : numbers_) all += concat(all.empty() ? "" : ", ", number);
    parser
        .add_option_function<std::string>(
            "--only",
            [this, all](const std::string& text) {
                wanted_ = split_list(text);
                for (const std::string& number : wanted_) {
                    if (std::ranges::find(numbers_, number) != numbers_.end()) continue;
                    throw CLI::ValidationError(
                        "--only", concat('"', number, "\" is no ", what_, " here: they are ", all));
                }
            },
            concat("Only these, of ", all))
        ->type_name("LIST");
}

bool OnlyOption::wants(std::string_view number) const
{
    return wanted_.empty() || std::ranges::find(wanted_, number) != wanted_.end();
}

} // namespace proxima
