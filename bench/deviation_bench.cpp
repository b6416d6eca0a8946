// CGAL's Hausdorff distance with a bounded error, for bench/deviation_bench.py, which runs it beside other peers.
//
//     deviation_bench A.off B.off ERROR      prints the distance of both ways, and the processor time in s
#include "bench_program.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/IO/polygon_mesh_io.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) // NOLINT(bugprone-exception-escape): of CGAL, which end the program
{
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    CGAL::Surface_mesh<Kernel::Point_3> a;
    CGAL::Surface_mesh<Kernel::Point_3> b;
    if (argc != 4 || !CGAL::IO::read_polygon_mesh(argv[1], a) ||
        !CGAL::IO::read_polygon_mesh(argv[2], b)) {
        std::fputs("deviation_bench: give two meshes that CGAL reads, and an error\n", stderr);
        return 1;
    }
    const double before = proxima::bench::processor_seconds();
    const double distance =
        CGAL::Polygon_mesh_processing::bounded_error_symmetric_Hausdorff_distance<
            CGAL::Sequential_tag>(a, b, std::atof(argv[3]));
    std::printf("%.17g %.6f\n", distance, proxima::bench::processor_seconds() - before);
}
