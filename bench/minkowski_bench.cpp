// Minkowski sums: triangle and cube in closed form against the thesis's geometric method and an
// incremental hull, and two polytopes by arcs against the convex hull of all pair sums by CGAL.
// Run by scripts/bench minkowski, which prints the ratios of one interleaved run.

#include "instruction_set.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/minkowski_sum.h"
#include "thesis/minkowski_sums/geometric_method.h"
#include "thesis/minkowski_sums/incremental_hull.h"
#include "thesis/octree_generation/triangle_cube_sum.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>
#include <benchmark/benchmark.h>

#include <cstdio>
#include <random>
#include <string>
#include <vector>

namespace proxima::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

std::vector<Vec3> points_on_sphere(unsigned seed, int count)
{
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Vec3> points(static_cast<std::size_t>(count));
    for (Vec3& point : points) {
        const double x = normal(random);
        const double y = normal(random);
        point = Vec3(x, y, normal(random)).normalized();
    }
    return points;
}

ConvexPolyhedron polytope(unsigned seed, int count)
{
    return convex_hull(points_on_sphere(seed, count)).value();
}

std::vector<Triangle> random_triangles()
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    std::vector<Triangle> triangles(1000);
    for (Triangle& triangle : triangles) {
        for (Vec3& vertex : triangle.vertices) {
            for (double& c : vertex) c = coordinate(random);
        }
    }
    return triangles;
}

constexpr double half_size = 0.25;

/// Runs one way of summing over all triangles; `sum` returns how many planes bound the sum.
template <class Sum>
void sum_triangles(benchmark::State& state, Sum sum)
{
    const std::vector<Triangle> triangles = random_triangles();
    std::uint64_t planes = 0;
    for ([[maybe_unused]] auto iteration : state) {
        planes = 0;
        for (const Triangle& triangle : triangles)
            planes += static_cast<std::uint64_t>(sum(triangle));
    }
    state.SetLabel("planes " + std::to_string(planes) + " of 1000 sums");
}

int closed_form(const Triangle& triangle)
{
    proxima::TriangleCubeSum<double> sum({{{triangle[0].x(), triangle[0].y(), triangle[0].z()},
                                           {triangle[1].x(), triangle[1].y(), triangle[1].z()},
                                           {triangle[2].x(), triangle[2].y(), triangle[2].z()}}});
    sum.set_half_size(half_size);
    benchmark::DoNotOptimize(sum);
    return triangle_cube_half_spaces;
}

int geometric(const Triangle& triangle)
{
    const auto sum =
        geometric_sum<double>(triangle_features<double>(triangle), Vec3::Constant(half_size));
    benchmark::DoNotOptimize(sum);
    return sum.count;
}

int hull(const Triangle& triangle)
{
    std::array<Vec3, 24> sums;
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 8; ++i) {
            sums[i + 8 * j] = triangle.vertices[j] +
                              cube_vertex<double>(static_cast<int>(i), Vec3::Constant(half_size));
        }
    }
    const auto faces = incremental_hull<double>(sums);
    benchmark::DoNotOptimize(faces);
    return faces ? static_cast<int>(faces->size()) : 0;
}

void by_arcs(benchmark::State& state, int count)
{
    const ConvexPolyhedron a = polytope(1, count);
    const ConvexPolyhedron b = polytope(2, count);
    std::size_t facets = 0;
    for ([[maybe_unused]] auto iteration : state) {
        const auto sum = minkowski_sum(a, b);
        facets = sum->facet_count();
        benchmark::DoNotOptimize(sum);
    }
    state.SetLabel(std::to_string(a.facet_count()) + " + " + std::to_string(b.facet_count()) +
                   " facets make " + std::to_string(facets));
    state.counters["facets"] = static_cast<double>(facets);
}

void hulls_of_both(benchmark::State& state, int count)
{
    const auto p = points_on_sphere(1, count);
    const auto q = points_on_sphere(2, count);
    for ([[maybe_unused]] auto iteration : state) {
        benchmark::DoNotOptimize(convex_hull(p));
        benchmark::DoNotOptimize(convex_hull(q));
    }
}

void by_cgal(benchmark::State& state, int count)
{
    std::size_t faces = 0;
    for ([[maybe_unused]] auto iteration : state) {
        std::vector<Kernel::Point_3> sums;
        sums.reserve(static_cast<std::size_t>(count) * static_cast<std::size_t>(count));
        const auto p = points_on_sphere(1, count);
        for (const Vec3& b : points_on_sphere(2, count)) {
            for (const Vec3& a : p) {
                const Vec3 s = a + b;
                sums.emplace_back(s.x(), s.y(), s.z());
            }
        }
        CGAL::Surface_mesh<Kernel::Point_3> result;
        CGAL::convex_hull_3(sums.begin(), sums.end(), result);
        faces = result.number_of_faces();
    }
    state.SetLabel(std::to_string(faces) + " triangles");
}

template <class Function, class... Arguments>
void add(const std::string& name, Function function, Arguments... arguments)
{
    benchmark::RegisterBenchmark(name.c_str(), function, arguments...)
        ->Unit(benchmark::kMicrosecond);
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    using namespace proxima::bench;
    benchmark::Initialize(&argc, argv);
    if (!use_instruction_set_asked_for()) return 2;
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    const auto over_triangles = [](auto sum) {
        return [sum](benchmark::State& state) { sum_triangles(state, sum); };
    };
    add("triangle_cube_x1000/closed_form", over_triangles(closed_form));
    add("triangle_cube_x1000/geometric", over_triangles(geometric));
    add("triangle_cube_x1000/hull", over_triangles(hull));
    for (const int count : {10, 30, 100, 300, 1000}) {
        const std::string group = "polytopes_of_" + std::to_string(count) + '/';
        add(group + "arcs", by_arcs, count);
        add(group + "hulls_of_both_operands", hulls_of_both, count);
        add(group + "CGAL_hull_of_pair_sums", by_cgal, count);
    }
    for (const int count : {3000, 10000}) {
        const std::string group = "polytopes_of_" + std::to_string(count) + '/';
        add(group + "arcs", by_arcs, count);
        add(group + "hulls_of_both_operands", hulls_of_both, count);
    }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
