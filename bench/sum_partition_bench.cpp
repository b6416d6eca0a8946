// Is a point in a Minkowski sum? By all half-spaces in a fixed order, by the free accepts of the
// octree builder, and by a tree of planes (thesis 3.6.4's future work). Run by
// scripts/bench sum_partition, which prints the ratios of one interleaved run.
//
//     octree workloads   every (triangle, child cell) that building an octree asks about; the sum
//                        is of triangle and child, and a tree is built per triangle and depth
//     uniform            the same sums, asked about points spread over their bounding boxes, for
//                        which the trees are built
//     1000x1000          two round polytopes of 1,000 vertices each
//
// Labels give evaluations per query: comparisons of one coordinate, and products of a point and a
// normal; then the number of points found inside, by which the rows must agree. PROXIMA_BENCH_MESH
// names a further mesh, built to depth 9 with threshold 8.

#include "instruction_set.h"
#include "minkowski/operation_counts.h"
#include "partition_workload.h"
#include "proxima/convex_polyhedron.h"
#include "thesis/octree_generation/sum_partition.h"
#include "thesis/octree_generation/triangle_cube_descent.h"

#include <benchmark/benchmark.h>

#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <random>
#include <utility>

namespace proxima::bench {
namespace {

using DoublePoint = Triple<double>;

template <class T>
TriangleCubeSum<T> cube_sum(const WorkloadGroup& group)
{
    CornerCoordinates<T> corners;
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k)
            corners[j][k] = T(static_cast<double>(group.triangle[j][k]));
    }
    TriangleCubeSum<T> sum(corners);
    sum.set_half_size(T(static_cast<double>(group.child_half)));
    return sum;
}

MinkowskiSum general_sum(const WorkloadGroup& group)
{
    std::vector<Vec3> corners;
    std::vector<Vec3> cube;
    cube.reserve(8);
    for (const WholePoint& v : group.triangle) {
        corners.emplace_back(static_cast<double>(v[0]), static_cast<double>(v[1]),
                             static_cast<double>(v[2]));
    }
    const auto half = static_cast<double>(group.child_half);
    for (int i = 0; i < 8; ++i) {
        cube.emplace_back((i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half,
                          (i & 4) != 0 ? half : -half);
    }
    return *minkowski_sum(*convex_hull(corners), *convex_hull(cube));
}

/// A sum in all its forms, and what is asked about it.
struct Case {
    TriangleCubeSum<double> ordered;
    SumPartition tree;
    std::vector<Vec3> points;
    std::vector<CellPlanes<double>> cells; ///< eight points each; none if the points are uniform
    CornerCoordinates<double> corners;
};

struct Suite {
    std::string name;
    std::vector<Case> cases;
    std::size_t queries = 0;
    double build_seconds = 0; ///< of all trees, their sums not included
};

DoublePoint plain(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

enum class Questions { children, uniform };

Suite make_suite(const PartitionWorkload& load, Questions questions)
{
    Suite suite{load.name, {}, 0, 0};
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const WorkloadGroup& group : load.groups) {
        const MinkowskiSum sum = general_sum(group);
        const auto start = std::chrono::steady_clock::now();
        SumPartition tree = *partition_sum(sum);
        suite.build_seconds +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        Case entry{cube_sum<double>(group), std::move(tree), {}, {}, {}};
        entry.corners = entry.ordered.vertices();
        const auto half = static_cast<double>(group.child_half);
        for (const WholePoint& lower : group.cells) {
            const Vec3 corner(static_cast<double>(lower[0]), static_cast<double>(lower[1]),
                              static_cast<double>(lower[2]));
            if (questions == Questions::children) {
                const Vec3 middle = corner + Vec3::Constant(2 * half);
                entry.cells.push_back(
                    {plain(corner), plain(middle), plain(corner + Vec3::Constant(4 * half))});
                for (int octant = 0; octant < 8; ++octant) {
                    entry.points.emplace_back(middle + half * Vec3((octant & 1) != 0 ? 1 : -1,
                                                                   (octant & 2) != 0 ? 1 : -1,
                                                                   (octant & 4) != 0 ? 1 : -1));
                }
            } else {
                const Box& box = entry.tree.bounds();
                for (int i = 0; i < 8; ++i) {
                    entry.points.emplace_back(
                        box.lower +
                        Vec3(unit(random), unit(random), unit(random)).cwiseProduct(box.extent()));
                }
            }
        }
        suite.queries += entry.points.size();
        suite.cases.push_back(std::move(entry));
    }
    return suite;
}

/// Evaluations of TriangleCubeSum::contains, told from its comparisons: six with the box, two that
/// share a product, one per product after that.
void count_ordered(const Case& entry, const Vec3& point, PartitionEvaluations& evaluations,
                   std::size_t& inside)
{
    // A sum of counting numbers, made anew per case, would cost too much; the order is the same.
    thread_local const Case* last = nullptr;
    thread_local std::unique_ptr<TriangleCubeSum<Counted>> counting;
    if (last != &entry) {
        CornerCoordinates<Counted> corners;
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) corners[j][k] = Counted(entry.corners[j][k]);
        counting = std::make_unique<TriangleCubeSum<Counted>>(corners);
        const double half = entry.ordered.lowest()[0] - entry.tree.bounds().lower.x();
        counting->set_half_size(Counted(half));
        last = &entry;
    }
    reset_operation_counts();
    inside += counting->contains({point.x(), point.y(), point.z()}) ? 1 : 0;
    const std::int64_t comparisons = operation_counts().comparisons;
    evaluations.comparisons += std::min<std::int64_t>(comparisons, 6);
    if (comparisons > 6) evaluations.dot_products += 1 + std::max<std::int64_t>(comparisons - 8, 0);
}

/// Children that the triangle touches: one box, a vertex inside, else half-spaces. `ask` answers
/// for the ith child.
template <class Ask>
unsigned touched_children(const Case& entry, const CellPlanes<double>& planes, Ask ask)
{
    const unsigned boxed = octants_touched(entry.ordered.lowest(), entry.ordered.highest(), planes);
    if (std::has_single_bit(boxed)) return boxed;
    unsigned touched = 0;
    for (const DoublePoint& vertex : entry.corners)
        touched |= octants_touched(vertex, vertex, planes);
    for (unsigned open = boxed & ~touched; open != 0; open &= open - 1) {
        const int octant = std::countr_zero(open);
        if (ask(octant)) touched |= 1U << static_cast<unsigned>(octant);
    }
    return touched;
}

std::string label(const PartitionEvaluations& evaluations, std::size_t queries, std::size_t inside)
{
    const auto each = [&](std::int64_t n) {
        return static_cast<double>(n) / static_cast<double>(queries);
    };
    char text[160];
    (void)std::snprintf(
        text, sizeof text, "per query %.2f comparisons + %.2f products; %zu queries, inside %zu",
        each(evaluations.comparisons), each(evaluations.dot_products), queries, inside);
    return text;
}

void by_fixed_order(benchmark::State& state, const Suite& suite)
{
    std::size_t inside = 0;
    for ([[maybe_unused]] auto iteration : state) {
        inside = 0;
        for (const Case& entry : suite.cases) {
            for (const Vec3& point : entry.points)
                inside += entry.ordered.contains(plain(point)) ? 1 : 0;
        }
        benchmark::DoNotOptimize(inside);
    }
    PartitionEvaluations evaluations;
    std::size_t counted = 0;
    for (const Case& entry : suite.cases)
        for (const Vec3& point : entry.points) count_ordered(entry, point, evaluations, counted);
    if (counted != inside) state.SkipWithError("counting and plain numbers differ");
    state.SetLabel(label(evaluations, suite.queries, inside));
}

void by_free_accepts(benchmark::State& state, const Suite& suite)
{
    std::size_t inside = 0;
    for ([[maybe_unused]] auto iteration : state) {
        inside = 0;
        for (const Case& entry : suite.cases) {
            for (std::size_t i = 0; i < entry.cells.size(); ++i) {
                const Vec3* children = &entry.points[8 * i];
                inside += static_cast<std::size_t>(
                    std::popcount(touched_children(entry, entry.cells[i], [&](int octant) {
                        return entry.ordered.contains(plain(children[octant]));
                    })));
            }
        }
        benchmark::DoNotOptimize(inside);
    }
    PartitionEvaluations evaluations;
    for (const Case& entry : suite.cases) {
        for (std::size_t i = 0; i < entry.cells.size(); ++i) {
            const Vec3* children = &entry.points[8 * i];
            bool asked_vertices = !std::has_single_bit(
                octants_touched(entry.ordered.lowest(), entry.ordered.highest(), entry.cells[i]));
            // Twelve comparisons sort a box into eight children.
            evaluations.comparisons += asked_vertices ? 12 + 3 * 12 : 12;
            static_cast<void>(touched_children(entry, entry.cells[i], [&](int octant) {
                std::size_t found = 0;
                PartitionEvaluations half_spaces;
                count_ordered(entry, children[octant], half_spaces, found);
                evaluations.comparisons += half_spaces.comparisons;
                evaluations.dot_products += half_spaces.dot_products;
                return found == 1;
            }));
        }
    }
    state.SetLabel(label(evaluations, suite.queries, inside));
}

void by_tree(benchmark::State& state, const Suite& suite)
{
    std::size_t inside = 0;
    for ([[maybe_unused]] auto iteration : state) {
        inside = 0;
        for (const Case& entry : suite.cases)
            for (const Vec3& point : entry.points) inside += entry.tree.contains(point) ? 1 : 0;
        benchmark::DoNotOptimize(inside);
    }
    PartitionEvaluations evaluations;
    std::size_t splits = 0;
    std::size_t references = 0;
    for (const Case& entry : suite.cases) {
        splits += entry.tree.split_count();
        references += entry.tree.reference_count();
        for (const Vec3& point : entry.points)
            static_cast<void>(entry.tree.contains(point, evaluations));
    }
    const auto trees = static_cast<double>(suite.cases.size());
    char text[160];
    (void)std::snprintf(
        text, sizeof text,
        "; a tree: %.1f splits, %.1f references, built in %.0f us, asked %.1f times",
        static_cast<double>(splits) / trees, static_cast<double>(references) / trees,
        1e6 * suite.build_seconds / trees, static_cast<double>(suite.queries) / trees);
    state.SetLabel(label(evaluations, suite.queries, inside) + text);
}

/// Points on a sphere, in no order.
ConvexPolyhedron round_polytope(std::mt19937& random, int vertices)
{
    std::normal_distribution<double> normal;
    std::vector<Vec3> points(static_cast<std::size_t>(vertices));
    for (Vec3& point : points)
        point = Vec3(normal(random), normal(random), normal(random)).normalized();
    return *convex_hull(points);
}

struct LargeSuite {
    SumPartition list;
    SumPartition tree;
    std::vector<Vec3> points;
};

LargeSuite large_suite()
{
    std::mt19937 random(1);
    const MinkowskiSum sum =
        *minkowski_sum(round_polytope(random, 1000), round_polytope(random, 1000));
    LargeSuite suite{*partition_sum(sum, {.max_depth = 0}), *partition_sum(sum), {}};
    std::uniform_real_distribution<double> unit(0, 1);
    const Box& box = suite.tree.bounds();
    for (int i = 0; i < 10000; ++i) {
        suite.points.emplace_back(
            box.lower + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(box.extent()));
    }
    return suite;
}

void large(benchmark::State& state, const SumPartition& partition, const std::vector<Vec3>& points)
{
    std::size_t inside = 0;
    for ([[maybe_unused]] auto iteration : state) {
        inside = 0;
        for (const Vec3& point : points) inside += partition.contains(point) ? 1 : 0;
        benchmark::DoNotOptimize(inside);
    }
    PartitionEvaluations evaluations;
    for (const Vec3& point : points) static_cast<void>(partition.contains(point, evaluations));
    char text[160];
    (void)std::snprintf(text, sizeof text, "; %zu facets, %zu splits, %zu references, depth %d",
                        partition.facet_count(), partition.split_count(),
                        partition.reference_count(), partition.depth());
    state.SetLabel(label(evaluations, points.size(), inside) + text);
}

void build_large(benchmark::State& state)
{
    std::mt19937 random(1);
    const MinkowskiSum sum =
        *minkowski_sum(round_polytope(random, 1000), round_polytope(random, 1000));
    for ([[maybe_unused]] auto iteration : state)
        benchmark::DoNotOptimize(partition_sum(sum)->split_count());
}

void register_suite(const std::shared_ptr<const Suite>& suite, Questions questions)
{
    const auto add = [&](const char* method, void (*run)(benchmark::State&, const Suite&)) {
        benchmark::RegisterBenchmark((suite->name + "/" + method).c_str(),
                                     [suite, run](benchmark::State& state) { run(state, *suite); })
            ->Unit(benchmark::kMillisecond);
    };
    add("fixed_order", by_fixed_order);
    if (questions == Questions::children) add("free_accepts", by_free_accepts);
    add("tree", by_tree);
}

void register_workload(const std::string& name, const std::string& mesh, int depth,
                       std::size_t threshold, std::size_t every_nth)
{
    PartitionWorkload load = partition_workload(name, mesh, depth, threshold, every_nth);
    if (load.groups.empty()) return;
    register_suite(std::make_shared<const Suite>(make_suite(load, Questions::children)),
                   Questions::children);
    load.name += "_uniform";
    register_suite(std::make_shared<const Suite>(make_suite(load, Questions::uniform)),
                   Questions::uniform);
}

void register_all()
{
    register_workload("sphere_100x100_depth_5", "sphere:100x100", 5, 1, 64);
    const char* bunny = "/usr/share/glmark2/models/bunny.obj";
    if (std::filesystem::exists(bunny)) register_workload("bunny_threshold_8", bunny, 9, 8, 64);
    if (const char* mesh = std::getenv("PROXIMA_BENCH_MESH")) {
        register_workload(std::filesystem::path(mesh).stem().string() + "_threshold_8", mesh, 9, 8,
                          64);
    }
    const auto suite = std::make_shared<const LargeSuite>(large_suite());
    const auto add = [&](const char* name, const SumPartition& partition) {
        benchmark::RegisterBenchmark(name, [suite, &partition](benchmark::State& state) {
            large(state, partition, suite->points);
        })->Unit(benchmark::kMillisecond);
    };
    add("1000x1000/fixed_order", suite->list);
    add("1000x1000/tree", suite->tree);
    benchmark::RegisterBenchmark("1000x1000_build/tree", build_large)
        ->Unit(benchmark::kMillisecond);
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    benchmark::Initialize(&argc, argv);
    if (!proxima::bench::use_instruction_set_asked_for()) return 2;
    proxima::bench::register_all();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
