#include "cli/point_options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <string_view>

namespace proxima {

namespace {

constexpr std::array<std::string_view, 1> point_layouts = {"x,y,z"};

} // namespace

void add_point_options(CLI::App& parser, PointOptions& options)
{
    CLI::Option* const file =
        parser
            .add_option("--points", options.file,
                        "The points: .npy, or text of x,y,z (commas, semicolons or spaces; header "
                        "optional), - for stdin")
            ->type_name("FILE");
    parser.add_option("--point", options.points, "A point; again for more")
        ->allow_extra_args(false)
        ->excludes(file)
        ->type_name("X,Y,Z");
}

void check_points_given(const PointOptions& options)
{
    if (options.file.empty() && options.points.empty())
        throw CLI::RequiredError("--points FILE or --point X,Y,Z");
}

Result<NumberTable> read_points(const PointOptions& options, Session& session)
{
    const TableForm form = {point_layouts};
    if (options.file.empty()) return parse_number_rows(options.points, form, "--point");
    const ProgressBar shown(session.progress(), session.bar());
    return session.load_table(options.file, form);
}

} // namespace proxima
