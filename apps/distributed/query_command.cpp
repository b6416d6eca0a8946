#include "distributed/query_command.h"

#include "distributed/closest_query.h"
#include "distributed/query_run.h"
#include "distributed/ray_query.h"
#include "distributed/route_triangles.h"
#include "distributed/sign_query.h"

#include <CLI/CLI.hpp>
#include <memory>

namespace proxima {

namespace {

/// What the rows of a table are.
struct TableColumns {
    std::string singular; ///< "point": the option of one, that of a file has an s
    std::string layout;
    std::string form; ///< of a row on the command line
};
const TableColumns point_columns{"point", "x,y,z", "X,Y,Z"};
const TableColumns ray_columns{"ray", "ox,oy,oz,dx,dy,dz[,tmin,tmax]",
                               "OX,OY,OZ,DX,DY,DZ[,TMIN,TMAX]"};

/// --points FILE or --point X,Y,Z, of which one must be given.
void add_table_options(CLI::App& command, const TableColumns& columns, TableSource& table)
{
    const std::string option = "--" + columns.singular;
    const std::string file_option = option + "s";
    CLI::Option* const file =
        command
            .add_option(file_option, table.file,
                        concat("The ", columns.singular, "s: .npy, or text, of ", columns.layout,
                               "; - for stdin"))
            ->type_name("FILE");
    CLI::Option* const rows =
        command
            .add_option(option, table.rows,
                        concat("Instead: a ", columns.singular, "; again for more"))
            ->allow_extra_args(false)
            ->excludes(file)
            ->type_name(columns.form);
    table.option = option;
    command.callback([option, file_option, form = columns.form, rows, file] {
        if (rows->count() == 0 && file->count() == 0)
            throw CLI::RequiredError(concat(file_option, " FILE or ", option, " ", form));
    });
}

template <class Query>
std::function<Status(World&)> add_command(CLI::App& app, const char* name, const char* description,
                                          const TableColumns& columns)
{
    const auto options = std::make_shared<QueryOptions>();
    CLI::App* const command = app.add_subcommand(name, description);
    command
        ->add_option("MODEL", options->model,
                     "A binary little-endian .ply file, torus:NxM, or vertices as a .npy file")
        ->required();
    command->add_option("--triangles", options->triangles,
                        "A .npy file: three numbers of vertices, from 0, for each triangle");
    add_table_options(*command, columns, options->table);
    command
        ->add_option("--out", options->out, "Write the answers: .csv, .npy, or - for CSV to stdout")
        ->capture_default_str()
        ->type_name("FILE");
    command
        ->add_option("--routing-depth", options->routing_depth,
                     "Deepest level whose cells are shared out, 0 to 7 (default 5)")
        ->check(CLI::Range(0, max_routing_depth));
    command->add_flag("--verify", options->is_verified,
                      "Answer all on the first process, too, and compare");
    return [options](World& world) -> Status {
        if (options->is_verified && !options->triangles.empty()) {
            return fail(ErrorCode::invalid_argument,
                        "--verify is for meshes that one process reads: write a .ply file",
                        options->triangles);
        }
        return QueryRun<Query>(*options, world).run();
    };
}

} // namespace

std::function<Status(World&)> add_closest_command(CLI::App& app)
{
    return add_command<ClosestQuery>(
        app, "closest", "Find the closest vertex, edge or face of a mesh for each point",
        point_columns);
}

std::function<Status(World&)> add_rays_command(CLI::App& app)
{
    return add_command<RayQuery>(app, "rays", "Find what each ray hits first", ray_columns);
}

std::function<Status(World&)> add_sign_command(CLI::App& app)
{
    return add_command<SignQuery>(
        app, "sign", "Find which points are inside of a mesh, and how far from it", point_columns);
}

} // namespace proxima
