// Builds octrees: ours on one and two threads, the usual recursive builder, and the thesis's
// methods. Run by scripts/bench octree, which prints the ratios of one interleaved run.
//
// PROXIMA_BENCH_MESH names a further mesh, built to depth 9 with threshold 8. Every row's label is
// cells, references and a hash of the lists: a faster wrong answer would show.

#include "akenine_moller.h"
#include "instruction_set.h"
#include "proxima/mesh_io.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "proxima/thesis.h"

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <latch>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace proxima::bench {
namespace {

struct Workload {
    std::string name;
    std::shared_ptr<const TriangleMesh> mesh;
    int depth = 5;
    std::uint32_t threshold = 1;
};

/// A sum over the ids that does not depend on their order in the array.
std::uint64_t hash_of_lists(const std::uint32_t* ids, std::size_t count)
{
    std::uint64_t hash = 0;
    for (std::size_t i = 0; i < count; ++i) {
        std::uint64_t value = ids[i] + 0x9E3779B97F4A7C15U;
        value = (value ^ value >> 30U) * 0xBF58476D1CE4E5B9U;
        hash += value ^ value >> 31U;
    }
    return hash;
}

std::string label(std::uint64_t cells, std::uint64_t references, std::uint64_t hash)
{
    char text[128];
    (void)std::snprintf(text, sizeof text, "cells %llu references %llu hash %016llx",
                        static_cast<unsigned long long>(cells),
                        static_cast<unsigned long long>(references),
                        static_cast<unsigned long long>(hash));
    return text;
}

/// A figure in kilobytes of this process from the kernel, for example "VmHWM:".
double kilobytes(const std::string& key)
{
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        double value = 0;
        if (word == key && status >> value) return value;
    }
    return 0;
}

/// How one of ours builds.
struct Way {
    OverlapMethod method = OverlapMethod::fast;
    int threads = 1;
    Classification classification = Classification::none;
};

void build_ours(benchmark::State& state, const Workload& load, const Way& way)
{
    const OctreeOptions options{.max_depth = load.depth,
                                .threshold = load.threshold,
                                .classification = way.classification,
                                .execution = {.threads = {way.threads}}};
    std::string text;
    double bytes = 0;
    while (state.KeepRunning()) {
        auto octree = build_octree_by(*load.mesh, {.method = way.method}, options);
        state.PauseTiming();
        if (!octree) {
            state.SkipWithError(describe(octree.error()).c_str());
            return;
        }
        const auto references = octree->references();
        text = label(octree_statistics(*octree).total, references.size(),
                     hash_of_lists(reinterpret_cast<const std::uint32_t*>(references.data()),
                                   references.size()));
        bytes = static_cast<double>(octree->bytes());
        octree = Octree{};
        state.ResumeTiming();
    }
    // Peak memory of one more build, beyond what the process held before.
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;
    const double before = kilobytes("VmRSS:");
    const auto octree = build_octree_by(*load.mesh, {.method = way.method}, options);
    const double peak = (kilobytes("VmHWM:") - before) * 1024;
    state.SetLabel(text);
    state.counters["bytes"] = bytes;
    state.counters["peak_over_octree"] = peak / bytes;
    state.counters["triangles"] = static_cast<double>(load.mesh->triangle_count());
    state.counters["references"] = static_cast<double>(octree->references().size());
}

/// What two cores of this machine give at best: two builds at once, each on one thread, timed as
/// one.
void build_two_at_once(benchmark::State& state, const Workload& load)
{
    const OctreeOptions options{.max_depth = load.depth,
                                .threshold = load.threshold,
                                .classification = Classification::none,
                                .execution = {.threads = {1}}};
    while (state.KeepRunning()) {
        std::array<Result<Octree>, 2> octrees{Octree{}, Octree{}};
        std::latch start(3);
        const auto build = [&](std::size_t i) {
            start.arrive_and_wait();
            octrees[i] = build_octree(*load.mesh, options);
        };
        std::jthread one(build, 0);
        std::jthread other(build, 1);
        const auto begin = std::chrono::steady_clock::now();
        start.arrive_and_wait();
        one.join();
        other.join();
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        state.SetIterationTime(took.count() / 2);
    }
    state.SetLabel("two builds at once on a thread each, half their time: the most that two "
                   "threads could gain");
}

void build_akenine_moller(benchmark::State& state, const Workload& load)
{
    const OctreeFrame frame = tight_root(bounding_box(*load.mesh), RootShape::cube);
    std::string text;
    double pairs = 0;
    std::optional<AkenineMollerOctree> octree; // freed while the clock is paused, like ours
    while (state.KeepRunning()) {
        octree.emplace(*load.mesh, frame, load.depth, load.threshold);
        state.PauseTiming();
        pairs = static_cast<double>(octree->pair_count());
        text = label(octree->cell_count(), octree->references().size(),
                     hash_of_lists(octree->references().data(), octree->references().size()));
        octree.reset();
        state.ResumeTiming();
    }
    state.SetLabel(text);
    state.counters["seconds_per_pair"] = benchmark::Counter(
        pairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void add(const Workload& load, bool with_thesis_methods)
{
    const auto name = [&](const char* method) { return load.name + "/" + method; };
    const auto register_ours = [&](const char* label_of, const Way& way) {
        benchmark::RegisterBenchmark(
            name(label_of).c_str(),
            [load, way](benchmark::State& state) { build_ours(state, load, way); })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
    };
    register_ours("fast", {});
    register_ours("fast-2-threads", {.threads = 2});
    register_ours("inner-outer", {.classification = Classification::inner_outer});
    benchmark::RegisterBenchmark(
        name("two-builds-2-threads").c_str(),
        [load](benchmark::State& state) { build_two_at_once(state, load); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(
        name("akenine-moller").c_str(),
        [load](benchmark::State& state) { build_akenine_moller(state, load); })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
    if (!with_thesis_methods) return;
    register_ours("separating-axis", {.method = OverlapMethod::separating_axis});
    register_ours("index-tracking", {.method = OverlapMethod::index_tracking});
    register_ours("minkowski", {.method = OverlapMethod::minkowski});
    register_ours("pairwise", {.method = OverlapMethod::pairwise});
}

std::shared_ptr<const TriangleMesh> load(const std::string& name)
{
    auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        (void)std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return nullptr;
    }
    return std::make_shared<const TriangleMesh>(std::move(*mesh));
}

void add_all()
{
    const char* const bunny = "/usr/share/glmark2/models/bunny.obj";
    add({"spaceship-33000-d5-t1", load("spaceship:33000"), 5, 1}, true);
    add({"sphere-19800-d5-t1", load("sphere:100x100"), 5, 1}, false);
    if (std::filesystem::exists(bunny)) {
        add({"bunny-d8-t8", load(bunny), 8, 8}, false);
        add({"bunny-d9-t1", load(bunny), 9, 1}, false);
    }
    if (const char* const file = std::getenv("PROXIMA_BENCH_MESH"); file != nullptr) {
        if (auto mesh = load(file)) add({"file-d9-t8", std::move(mesh), 9, 8}, false);
    }
    for (const char* const count : {"10000", "100000", "1000000"}) {
        const Workload growth{std::string("growth-") + count,
                              load(std::string("spaceship:") + count), 9, 8};
        benchmark::RegisterBenchmark(
            (growth.name + "/fast").c_str(),
            [growth](benchmark::State& state) { build_ours(state, growth, {}); })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
    }
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    benchmark::Initialize(&argc, argv);
    if (!proxima::bench::use_instruction_set_asked_for()) return 2;
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    proxima::bench::add_all();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
