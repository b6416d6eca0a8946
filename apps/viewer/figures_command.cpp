// proxima figures: the figures of the thesis, as pictures with captions.
#include "base/output_file.h"
#include "base/text.h"
#include "cli/figure.h"
#include "cli/only_option.h"
#include "cli/thesis_models.h"
#include "proxima/execution.h"
#include "viewer/commands.h"
#include "viewer/figures/figure_pages.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {
namespace {

std::vector<std::string_view> figure_numbers()
{
    std::vector<std::string_view> numbers;
    for (const ThesisFigure& figure : thesis_figures()) numbers.emplace_back(figure.number);
    return numbers;
}

struct FiguresOptions {
    std::string out;
    OnlyOption only{"figure", figure_numbers()};
    std::string meshes;
    bool opengl = false;
};

Status write_text(const std::string& text, const std::filesystem::path& path, Progress* progress)
{
    auto output = OutputFile::create(path, {progress, text.size()});
    if (!output) return tl::unexpected(output.error());
    if (Status status = output->write(text); !status) return status;
    return output->commit();
}

Result<std::unique_ptr<Renderer>> make_renderer(const FiguresOptions& options,
                                                const Progress* progress)
{
    if (options.opengl) return make_opengl_renderer();
    return make_software_renderer(progress);
}

Status run_figures(const FiguresOptions& options, Session& session)
{
    if (Status status = check_drawing(); !status) return status;
    const std::filesystem::path folder = options.out;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (!std::filesystem::is_directory(folder, error)) {
        return fail(ErrorCode::file_not_writable, "this folder is not there and cannot be made",
                    options.out);
    }
    Progress* const progress = &session.progress();
    const auto renderer = make_renderer(options, progress);
    if (!renderer) return tl::unexpected(renderer.error());
    const Execution context = {session.threads(), progress};
    const std::string models = options.meshes.empty() ? usual_model_folder() : options.meshes;
    std::vector<FigurePage> pages;
    nlohmann::ordered_json made = nlohmann::ordered_json::array();
    for (const ThesisFigure& figure : thesis_figures()) {
        if (!options.only.wants(figure.number)) continue;
        auto page = [&] {
            const ProgressBar shown(session.progress(), session.bar());
            return write_figure_page(figure, folder, **renderer, context, models);
        }();
        if (!page) return tl::unexpected(page.error());
        session.print(
            fmt::format("Figure {:<5} {:6.2f} s  {}\n", page->number, page->seconds, page->title));
        made.push_back({{"figure", page->number},
                        {"title", page->title},
                        {"caption", page->caption},
                        {"files", page->files},
                        {"seconds", page->seconds}});
        pages.push_back(std::move(*page));
    }
    nlohmann::ordered_json missing = nlohmann::ordered_json::array();
    for (const MissingFigure& figure : missing_figures()) {
        missing.push_back(
            {{"figure", figure.number}, {"title", figure.title}, {"reason", figure.reason}});
    }
    const std::filesystem::path sheet = folder / "figures.html";
    if (Status status = write_text(figure_sheet(pages, missing_figures()), sheet, progress);
        !status) {
        return status;
    }
    session.print(fmt::format("wrote {}\n", sheet.string()));
    return session.write_json({{"figures", made}, {"missing", missing}});
}

} // namespace

Command add_figures_command(CLI::App& app)
{
    CLI::App* const parser =
        app.add_subcommand("figures", "Draw the figures of the thesis, with captions and a page "
                                      "that shows them");
    const auto options = std::make_shared<FiguresOptions>();
    parser
        ->add_option("--out", options->out, "Folder for pictures and figures.html; made if need be")
        ->required()
        ->type_name("DIR");
    options->only.add_to(*parser);
    parser
        ->add_option("--meshes", options->meshes,
                     "Folder with the scans of figure 2.7, which others stand in for without it "
                     "(default: shared/meshes beside the checkout that the program was built in)")
        ->check(CLI::ExistingDirectory)
        ->type_name("DIR");
    parser->add_flag("--opengl", options->opengl,
                     "Draw scenes by OpenGL, without a display; by software otherwise");
    return {parser, [options](Session& session) { return run_figures(*options, session); }};
}

} // namespace proxima
