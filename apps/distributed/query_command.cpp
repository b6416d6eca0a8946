#include "distributed/query_command.h"

#include "distributed/closest_query.h"
#include "distributed/query_run.h"
#include "distributed/ray_query.h"
#include "distributed/route_triangles.h"
#include "distributed/sign_query.h"

#include <CLI/CLI.hpp>

namespace proxima {

namespace {

CLI::App* add_command(CLI::App& app, const char* name, const char* description,
                      QueryOptions& options)
{
    CLI::App* const command = app.add_subcommand(name, description);
    command->add_option("MODEL", options.model, "A binary little-endian .ply file, or torus:NxM")
        ->required();
    command
        ->add_option("--out", options.out,
                     "Write the answers: .csv, .npy, or - for CSV to stdout (default)")
        ->capture_default_str()
        ->type_name("FILE");
    command
        ->add_option("--routing-depth", options.routing_depth,
                     "Deepest level whose cells are shared out, 0 to 6 (default 5)")
        ->check(CLI::Range(0, max_routing_depth));
    command->add_flag("--verify", options.is_verified,
                      "Answer all on the first process, too, and compare");
    return command;
}

/// --points FILE or --point X,Y,Z, of which one must be given.
void add_table_options(CLI::App& command, TableSource& table, const std::string& singular,
                       const std::string& layout, const std::string& form)
{
    const std::string option = "--" + singular;
    const std::string file_option = option + "s";
    CLI::Option* const file =
        command
            .add_option(file_option, table.file,
                        "The " + singular + "s: .npy, or text, of " + layout + "; - for stdin")
            ->type_name("FILE");
    CLI::Option* const rows =
        command.add_option(option, table.rows, "Instead: a " + singular + "; again for more")
            ->allow_extra_args(false)
            ->excludes(file)
            ->type_name(form);
    command.callback([&table, option, file_option, form, rows, file] {
        if (rows->count() == 0 && file->count() == 0)
            throw CLI::RequiredError(file_option + " FILE or " + option + " " + form);
        table.option = option;
    });
}

} // namespace

QueryCommands::QueryCommands(CLI::App& app)
{
    options_.out = "-";
    closest_ = add_command(
        app, "closest", "Find the closest vertex, edge or face of a mesh for each point", options_);
    add_table_options(*closest_, options_.table, "point", "x,y,z", "X,Y,Z");
    rays_ = add_command(app, "rays", "Find what each ray hits first", options_);
    add_table_options(*rays_, options_.table, "ray", "ox,oy,oz,dx,dy,dz[,tmin,tmax]",
                      "OX,OY,OZ,DX,DY,DZ[,TMIN,TMAX]");
    sign_ = add_command(app, "sign", "Find which points are inside of a mesh, and how far from it",
                        options_);
    add_table_options(*sign_, options_.table, "point", "x,y,z", "X,Y,Z");
}

bool QueryCommands::is_given() const
{
    return closest_->parsed() || rays_->parsed() || sign_->parsed();
}

Status QueryCommands::run(World& world) const
{
    if (rays_->parsed()) return QueryRun<RayQuery>(options_, world).run();
    if (sign_->parsed()) return QueryRun<SignQuery>(options_, world).run();
    return QueryRun<ClosestQuery>(options_, world).run();
}

} // namespace proxima
