// proxima tables: every table of the thesis, ours beside its values, and why they differ.
#include "base/text.h"
#include "cli/commands.h"
#include "cli/only_option.h"
#include "cli/thesis_comparison.h"
#include "cli/thesis_models.h"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

std::vector<std::string_view> table_numbers()
{
    std::vector<std::string_view> numbers;
    for (const ThesisTable& table : thesis_tables()) numbers.emplace_back(table.number);
    return numbers;
}

struct TablesOptions {
    OnlyOption only{"table", table_numbers()};
    ThesisComparisonOptions comparison;
};

Status run_tables(const TablesOptions& options, Session& session)
{
    ThesisComparisonOptions comparison = options.comparison;
    if (comparison.meshes.empty()) comparison.meshes = usual_model_folder();
    comparison.execution = session.execution();
    comparison.threads_to_measure = session.threads_to_measure();
    nlohmann::ordered_json tables = nlohmann::ordered_json::array();
    for (const ThesisTable& table : thesis_tables()) {
        if (!options.only.wants(table.number)) continue;
        const auto result = [&] {
            const ProgressBar shown(session.progress(), session.bar());
            return table.compare(comparison);
        }();
        if (!result) return tl::unexpected(result.error());
        session.print(fmt::format("Table {}. {}\n\n{}", table.number, table.title, result->text));
        nlohmann::ordered_json notes = nlohmann::ordered_json::array();
        for (const std::string& note : result->notes) {
            session.print(fmt::format("  * {}\n", note));
            notes.push_back(note);
        }
        session.print("\n");
        tables.push_back({{"table", table.number},
                          {"title", table.title},
                          {"rows", result->rows},
                          {"notes", notes}});
    }
    return session.write_json({{"tables", tables}});
}

} // namespace

Command add_tables_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "tables", "Print tables of the thesis, its values beside those of Proxima");
    const auto options = std::make_shared<TablesOptions>();
    options->only.add_to(*parser);
    parser
        ->add_option("--meshes", options->comparison.meshes,
                     "Folder with the Stanford models of Table 2.3 (default: shared/meshes beside "
                     "the checkout that the program was built in)")
        ->check(CLI::ExistingDirectory)
        ->type_name("DIR");
    parser->add_flag("--as-printed", options->comparison.as_printed,
                     "In Table 2.1 also what the pseudocode of the thesis gives as printed, with "
                     "its errors put right one by one");
    return {parser, [options](Session& session) { return run_tables(*options, session); }};
}

} // namespace proxima
