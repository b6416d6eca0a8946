// Minkowski sums: triangle and cube in closed form against the thesis's geometric method and an
// incremental hull, and two polytopes against the convex hull of all pairwise sums by CGAL.
// Run by scripts/bench minkowski, which prints the ratios of one interleaved run.
//
//     hulls_and_sum           from two sets of points: our convex hulls of both, then their sum
//     CGAL_hull_of_pair_sums  from all pairwise sums of the same points: CGAL's convex hull
//     hulls_alone, sum_alone  the two parts of hulls_and_sum
//
// All points, and CGAL's pairwise sums, exist before the clock starts.

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

#include <array>
#include <optional>
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

/// Beyond so many points of a set, all pairwise sums take CGAL seconds and gigabytes.
constexpr int most_points_of_cgal = 1000;

/// Times one method over all triangles. The label tells what the sums of all triangles consist of,
/// counted once, outside of the timed part.
template <class Method>
void sum_triangles(benchmark::State& state)
{
    const std::vector<Triangle> triangles = random_triangles();
    for ([[maybe_unused]] auto iteration : state) {
        for (const Triangle& triangle : triangles)
            benchmark::DoNotOptimize(Method::sum_of(triangle));
    }
    std::size_t count = 0;
    for (const Triangle& triangle : triangles) count += Method::count(Method::sum_of(triangle));
    state.SetLabel(std::to_string(count) + ' ' + Method::counted + " of " +
                   std::to_string(triangles.size()) + " sums");
}

struct ClosedForm {
    static constexpr const char* counted = "half-spaces whose normal is not zero";

    static TriangleCubeSum<double> sum_of(const Triangle& triangle)
    {
        TriangleCubeSum<double> sum({{{triangle[0].x(), triangle[0].y(), triangle[0].z()},
                                      {triangle[1].x(), triangle[1].y(), triangle[1].z()},
                                      {triangle[2].x(), triangle[2].y(), triangle[2].z()}}});
        sum.set_half_size(half_size);
        return sum;
    }
    static std::size_t count(const TriangleCubeSum<double>& sum)
    {
        std::size_t facets = 0;
        for (int i = 0; i < triangle_cube_half_spaces; ++i)
            facets += sum.normal(i) != Triple<double>{} ? 1 : 0;
        return facets;
    }
};

struct Geometric {
    static constexpr const char* counted = "planes";

    static auto sum_of(const Triangle& triangle)
    {
        return geometric_sum<double>(triangle_features<double>(triangle),
                                     Vec3::Constant(half_size));
    }
    template <class Sum>
    static std::size_t count(const Sum& sum)
    {
        return static_cast<std::size_t>(sum.count);
    }
};

struct Hull {
    static constexpr const char* counted = "triangles";

    static std::optional<std::vector<HullFace<double>>> sum_of(const Triangle& triangle)
    {
        std::array<Vec3, 24> sums;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 8; ++i) {
                sums[i + 8 * j] =
                    triangle.vertices[j] +
                    cube_vertex<double>(static_cast<int>(i), Vec3::Constant(half_size));
            }
        }
        return incremental_hull<double>(sums);
    }
    static std::size_t count(const std::optional<std::vector<HullFace<double>>>& faces)
    {
        return faces ? faces->size() : 0;
    }
};

std::string sum_label(const ConvexPolyhedron& a, const ConvexPolyhedron& b, std::size_t facets)
{
    return std::to_string(a.facet_count()) + " + " + std::to_string(b.facet_count()) +
           " facets make " + std::to_string(facets);
}

void hulls_and_sum(benchmark::State& state, int count)
{
    const auto p = points_on_sphere(1, count);
    const auto q = points_on_sphere(2, count);
    std::size_t facets = 0;
    for ([[maybe_unused]] auto iteration : state) {
        const auto a = convex_hull(p);
        const auto b = convex_hull(q);
        const auto sum = minkowski_sum(*a, *b);
        facets = sum->facet_count();
        benchmark::DoNotOptimize(sum);
    }
    state.SetLabel(sum_label(*convex_hull(p), *convex_hull(q), facets));
    state.counters["facets"] = static_cast<double>(facets);
}

void hulls_alone(benchmark::State& state, int count)
{
    const auto p = points_on_sphere(1, count);
    const auto q = points_on_sphere(2, count);
    for ([[maybe_unused]] auto iteration : state) {
        benchmark::DoNotOptimize(convex_hull(p));
        benchmark::DoNotOptimize(convex_hull(q));
    }
}

void sum_alone(benchmark::State& state, int count)
{
    const ConvexPolyhedron a = convex_hull(points_on_sphere(1, count)).value();
    const ConvexPolyhedron b = convex_hull(points_on_sphere(2, count)).value();
    std::size_t facets = 0;
    for ([[maybe_unused]] auto iteration : state) {
        const auto sum = minkowski_sum(a, b);
        facets = sum->facet_count();
        benchmark::DoNotOptimize(sum);
    }
    state.SetLabel(sum_label(a, b, facets));
    state.counters["facets"] = static_cast<double>(facets);
}

void cgal_hull_of_pair_sums(benchmark::State& state, int count)
{
    const auto p = points_on_sphere(1, count);
    std::vector<Kernel::Point_3> sums;
    sums.reserve(p.size() * p.size());
    for (const Vec3& b : points_on_sphere(2, count)) {
        for (const Vec3& a : p) {
            const Vec3 s = a + b;
            sums.emplace_back(s.x(), s.y(), s.z());
        }
    }
    std::size_t faces = 0;
    for ([[maybe_unused]] auto iteration : state) {
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
    add("triangle_cube_x1000/closed_form", sum_triangles<ClosedForm>);
    add("triangle_cube_x1000/geometric", sum_triangles<Geometric>);
    add("triangle_cube_x1000/hull", sum_triangles<Hull>);
    for (const int count : {10, 30, 100, 300, 1000, 3000, 10000}) {
        const std::string group = "polytopes_of_" + std::to_string(count) + '/';
        // The first row of a group is what the others are compared with.
        add(group + "hulls_and_sum", hulls_and_sum, count);
        add(group + "hulls_alone", hulls_alone, count);
        add(group + "sum_alone", sum_alone, count);
        if (count <= most_points_of_cgal)
            add(group + "CGAL_hull_of_pair_sums", cgal_hull_of_pair_sums, count);
    }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
