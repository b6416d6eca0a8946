// proxima-mpi: octrees of meshes, and questions to meshes, that are spread over the processes of a run. Run it by mpirun.
// This program links p4est, which is under the GPL.
#include "distributed/octree_command.h"
#include "distributed/query_command.h"

#include "proxima/octree.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <p4est_base.h>

namespace proxima {

namespace {

/// The arguments' options, or the exit status where there is nothing to do. Only rank 0 prints.
int run(int argc, char** argv, World& world)
{
    CLI::App app("Octrees of triangle meshes, and queries, over several processes");
    app.set_version_flag("--version", "proxima-mpi " PROXIMA_VERSION);
    app.require_subcommand(1);
    OctreeRunOptions options;
    CLI::App* const octree =
        app.add_subcommand("octree", "Build the octree of a mesh, each process a part of it");
    octree->add_option("MODEL", options.model, "A binary little-endian .ply file, or torus:NxM")
        ->required();
    octree->add_option("--depth", options.depth, "Deepest level, 0 to 18 (default 5)")
        ->check(CLI::Range(0, max_octree_depth - 1));
    octree
        ->add_option("--threshold", options.threshold,
                     "Split cells with more triangles than this (default 1)")
        ->check(CLI::Range(0U, 1U << 30U));
    octree
        ->add_option("--routing-depth", options.routing_depth,
                     "Deepest level whose cells are shared out, 0 to 6 (default 5)")
        ->check(CLI::Range(0, 6));
    octree->add_flag("--verify", options.is_verified,
                     "Build the whole octree on the first process, too, and compare");
    const QueryCommands queries(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (world.rank() != 0) return error.get_exit_code() == 0 ? 0 : 2;
        return app.exit(error) == 0 ? 0 : 2;
    }
    const Status status = queries.is_given() ? queries.run(world) : run_octree(options, world);
    if (status) return 0;
    if (world.rank() == 0) {
        std::fprintf(stderr, "proxima-mpi: %s\n", describe(status.error()).c_str());
    }
    return 1;
}

} // namespace

} // namespace proxima

int main(int argc, char** argv)
{
    MPI_Init(&argc, &argv);
    sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_ERROR);
    p4est_init(nullptr, SC_LP_ERROR);
    int exit_status = 1;
    try {
        proxima::World world;
        exit_status = proxima::run(argc, argv, world);
    } catch (const std::exception& error) {
        // One rank alone cannot tell the others, which wait for it.
        std::fprintf(stderr, "proxima-mpi: stopped: %s\n", error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    sc_finalize();
    MPI_Finalize();
    return exit_status;
}
