// A mesh in thousands of poses: rays, closest points and pairs in contact, ours beside Embree's instances and
// FCL's DynamicAABBTreeCollisionManager. Passes in turn, medians, processor time of one thread.
//
// Embree's traversal is fast or robust; its top level is static and built with high quality, for rays, or
// dynamic and built with low quality, for moves. Its triangles are in floats, ours and FCL's in doubles.
//
//     scene_bench [--instances N] [--spread S] [--rays N] [--rounds N] [--seed N] [--mesh NAME]...
//
// Instances are turned at random; their origins are anywhere in a cube whose edge is S times the mesh's
// longest extent times the cube root of N. Rays begin anywhere in it and go anywhere. Every hit and pair is
// compared with ours, and a hash of ours is printed.
#include "bench_program.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/scene.h"
#include "scene_peers.h"

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <random>

namespace proxima::bench {
namespace {

struct BenchOptions : CommonOptions {
    std::size_t instances = 10'000;
    double spread = 2;
    std::size_t rays = 100'000;
};

class ProximaScenePeer final : public ScenePeer {
public:
    explicit ProximaScenePeer(const TriangleMesh& mesh)
        : index_(build_mesh_index(mesh, {.execution = one_thread}).value())
    {}
    [[nodiscard]] std::string name() const override { return "proxima"; }
    void prepare_build(std::span<const RigidTransform> /*poses*/) override { scene_ = Scene(); }
    void build(std::span<const RigidTransform> poses) override
    {
        std::vector<Instance> instances(poses.size());
        for (std::size_t i = 0; i < poses.size(); ++i) instances[i].pose = poses[i];
        scene_ = build_scene({&index_, 1}, instances, {one_thread}).value();
    }
    void move(std::span<const RigidTransform> poses) override
    {
        scene_ = move_instances(scene_, poses, {one_thread}).value();
    }
    /// Gives one instance in `every` the pose that it has in the list.
    void move_some(std::span<const RigidTransform> poses, std::size_t every)
    {
        ids_.clear();
        poses_.clear();
        for (std::size_t i = 0; i < poses.size(); i += every) {
            ids_.push_back(InstanceId{static_cast<std::uint32_t>(i)});
            poses_.push_back(poses[i]);
        }
        const Status moved = move_in_place(scene_, ids_, poses_, {one_thread});
        if (!moved) throw std::runtime_error(describe(moved.error()));
    }
    [[nodiscard]] bool casts_rays() const override { return true; }
    void prepare_rays(std::span<const Ray> rays) override
    {
        rays_.assign(rays.begin(), rays.end());
        hits_.assign(rays.size(), std::nullopt);
    }
    void cast_rays() override
    {
        for (std::size_t i = 0; i < rays_.size(); ++i) hits_[i] = closest_hit(scene_, rays_[i]);
    }
    [[nodiscard]] SceneRayAnswer answer(std::size_t ray) const override
    {
        if (!hits_[ray]) return {};
        return {to_index(hits_[ray]->instance), to_index(hits_[ray]->hit.triangle),
                hits_[ray]->hit.t};
    }
    [[nodiscard]] bool finds_pairs() const override { return true; }
    ScenePairs find_pairs() override
    {
        ScenePairs pairs;
        const auto found = pairs_in_contact(scene_, {.execution = one_thread}).value();
        for (const InstancePair& pair : found)
            pairs.emplace_back(to_index(pair.a), to_index(pair.b));
        return pairs;
    }
    std::size_t count_overlaps() override
    {
        return overlapping_bounds(scene_, 0, {.execution = one_thread}).value().size();
    }
    [[nodiscard]] const Scene& scene() const { return scene_; }

private:
    static constexpr Execution one_thread = {.threads = {1}};

    MeshIndex index_;
    Scene scene_;
    std::vector<InstanceId> ids_; ///< that move, to these
    std::vector<RigidTransform> poses_;
    std::vector<Ray> rays_;
    std::vector<std::optional<SceneHit>> hits_;
};

/// What one row of the table measures.
struct Row {
    const char* what;
    double per_second; ///< times in `unit` are seconds times this
    const char* unit;
    std::function<bool(const ScenePeer&)> can; ///< peers that cannot are left out
    std::function<void(ScenePeer&)> prepare;   ///< before each pass, not timed
    std::function<void(ScenePeer&, int round)> pass;
};

/// Times a row: all peers in each round, a different one first. Prints medians, and ratios to the first
/// peer's.
void print_row(std::span<const std::unique_ptr<ScenePeer>> peers, int rounds, const Row& row)
{
    std::vector<std::vector<double>> seconds(peers.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t turn = 0; turn < peers.size(); ++turn) {
            const std::size_t i = (turn + static_cast<std::size_t>(round)) % peers.size();
            if (!row.can(*peers[i])) continue;
            row.prepare(*peers[i]);
            const double start = processor_seconds();
            row.pass(*peers[i], round);
            seconds[i].push_back(processor_seconds() - start);
        }
    }
    for (std::size_t i = 0; i < peers.size(); ++i) {
        if (seconds[i].empty()) continue;
        std::printf("  %-22s  %-26s %10.4g %s", i == 0 ? row.what : "", peers[i]->name().c_str(),
                    row.per_second * median(seconds[i]), row.unit);
        if (i > 0) std::printf("  (x%.2f)", median(seconds[i]) / median(seconds[0]));
        std::puts("");
    }
    std::fflush(stdout);
}

struct Workload {
    std::vector<RigidTransform> poses;
    std::vector<RigidTransform> moved; ///< each by a hundredth of the mesh's extent
    std::vector<Ray> rays;
    std::vector<Vec3> points;
};

Workload make_workload(const TriangleMesh& mesh, const BenchOptions& options)
{
    std::mt19937_64 random(options.seed);
    const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    const auto vector = [&] {
        const double x = unit();
        const double y = unit();
        return Vec3(x, y, unit());
    };
    const Box box = bounding_box(mesh);
    const double extent = box.extent().maxCoeff();
    const double half =
        0.5 * options.spread * extent * std::cbrt(static_cast<double>(options.instances));
    Workload work;
    for (std::size_t i = 0; i < options.instances; ++i) {
        RigidTransform pose;
        const Eigen::Quaterniond q(unit(), unit(), unit(), unit());
        pose.rotation = q.normalized().toRotationMatrix();
        pose.translation = half * vector() - pose.rotation * box.center();
        work.poses.push_back(pose);
        pose.translation += 0.01 * extent * vector();
        work.moved.push_back(pose);
    }
    for (std::size_t i = 0; i < options.rays; ++i) {
        work.rays.push_back({.origin = half * vector(), .direction = vector()});
        work.points.emplace_back(half * vector());
    }
    return work;
}

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value)
{
    return (hash ^ value) * 0x9E3779B97F4A7C15U;
}

void compare(std::span<const std::unique_ptr<ScenePeer>> peers, std::size_t rays)
{
    std::uint64_t hash = 0;
    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays; ++i) {
        const SceneRayAnswer own = peers[0]->answer(i);
        hits += own.instance != SceneRayAnswer::none ? 1U : 0U;
        hash = mixed(hash, own.instance);
        hash = mixed(hash, own.triangle);
        hash = mixed(hash, std::bit_cast<std::uint64_t>(own.t));
    }
    ScenePairs pairs = peers[0]->find_pairs();
    for (const auto& [a, b] : pairs) hash = mixed(hash, std::uint64_t{a} << 32U | b);
    std::printf("  hits %zu of %zu, pairs in contact %zu, boxes that overlap %zu, hash %016llx\n",
                hits, rays, pairs.size(), peers[0]->count_overlaps(),
                static_cast<unsigned long long>(hash));
    for (const auto& peer : peers.subspan(1)) {
        if (peer->casts_rays()) {
            std::size_t different = 0;
            for (std::size_t i = 0; i < rays; ++i) {
                const SceneRayAnswer own = peers[0]->answer(i);
                const SceneRayAnswer other = peer->answer(i);
                constexpr double float_noise = 1e-4;
                const bool same = own.instance == other.instance &&
                                  (own.triangle == other.triangle ||
                                   std::abs(own.t - other.t) <= float_noise * std::abs(own.t));
                different += same ? 0U : 1U;
            }
            std::printf("  %s: %zu rays have another answer\n", peer->name().c_str(), different);
        }
        if (!peer->finds_pairs()) continue;
        ScenePairs others = peer->find_pairs();
        for (auto& [a, b] : others)
            if (a > b) std::swap(a, b);
        std::ranges::sort(others);
        ScenePairs different;
        std::ranges::set_symmetric_difference(pairs, others, std::back_inserter(different));
        std::printf("  %s: %zu pairs, %zu in one list alone; %zu boxes overlap\n",
                    peer->name().c_str(), others.size(), different.size(), peer->count_overlaps());
    }
}

void race(const std::string& name, const BenchOptions& options)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) throw std::runtime_error(describe(mesh.error()));
    const Workload work = make_workload(*mesh, options);
    std::vector<std::unique_ptr<ScenePeer>> peers;
    auto own = std::make_unique<ProximaScenePeer>(*mesh);
    ProximaScenePeer& proxima = *own;
    peers.push_back(std::move(own));
#ifdef PROXIMA_BENCH_EMBREE
    for (const auto top :
         {EmbreeTopLevel::static_high_quality, EmbreeTopLevel::dynamic_low_quality}) {
        for (const auto traversal : {EmbreeTraversal::fast, EmbreeTraversal::robust})
            peers.push_back(make_embree_scene_peer(*mesh, traversal, top));
    }
#endif
#ifdef PROXIMA_BENCH_FCL
    peers.push_back(make_fcl_scene_peer(*mesh));
#endif
    std::printf("%s: %zu triangles, %zu instances, spread %g, seed %llu\n", name.c_str(),
                mesh->triangle_count(), options.instances, options.spread,
                static_cast<unsigned long long>(options.seed));
    const auto all = [](const ScenePeer&) { return true; };
    const auto rays = [](const ScenePeer& peer) { return peer.casts_rays(); };
    const auto pairs = [](const ScenePeer& peer) { return peer.finds_pairs(); };
    const auto nothing = [](ScenePeer&) {};
    const auto prepare_build = [&](ScenePeer& peer) { peer.prepare_build(work.poses); };
    const auto prepare_rays = [&](ScenePeer& peer) { peer.prepare_rays(work.rays); };
    const auto cast_rays = [](ScenePeer& peer, int /*round*/) { peer.cast_rays(); };
    const double per_ray = 1e6 / static_cast<double>(work.rays.size());
    const int rounds = options.rounds;
    // Instances are at `poses` after building and after an odd round, so that every round moves them.
    const auto poses_of_round = [&](int round) -> std::span<const RigidTransform> {
        return round % 2 == 0 ? work.moved : work.poses;
    };
    print_row(peers, rounds,
              {"building", 1e3, "ms", all, prepare_build,
               [&](ScenePeer& peer, int /*round*/) { peer.build(work.poses); }});
    print_row(peers, rounds,
              {"moving all", 1e3, "ms", all, nothing,
               [&](ScenePeer& peer, int round) { peer.move(poses_of_round(round)); }});
    for (const auto& peer : peers) peer->move(work.moved);
    print_row(peers, rounds, {"closest hit, moved", per_ray, "us", rays, prepare_rays, cast_rays});
    for (const std::size_t every : {100, 1000}) {
        proxima.build(work.poses);
        std::vector<double> moving;
        for (int round = 0; round < rounds; ++round) {
            const double start = processor_seconds();
            proxima.move_some(poses_of_round(round), every);
            moving.push_back(processor_seconds() - start);
        }
        const std::string what = "moving one in " + std::to_string(every);
        std::printf("  %-22s  %-26s %10.4g ms\n", what.c_str(), "proxima", 1e3 * median(moving));
    }
    for (const auto& peer : peers) {
        peer->prepare_build(work.poses);
        peer->build(work.poses);
    }
    print_row(peers, rounds, {"closest hit", per_ray, "us", rays, prepare_rays, cast_rays});
    print_row(peers, rounds,
              {"all pairs in contact", 1e3, "ms", pairs, nothing,
               [](ScenePeer& peer, int /*round*/) { (void)peer.find_pairs(); }});
    print_row(peers, rounds,
              {"boxes that overlap", 1e3, "ms", pairs, nothing,
               [](ScenePeer& peer, int /*round*/) { (void)peer.count_overlaps(); }});
    std::vector<double> nearest;
    double sum = 0;
    for (int round = 0; round < rounds; ++round) {
        const double start = processor_seconds();
        for (const Vec3& p : work.points) sum += closest_feature(proxima.scene(), p)->distance;
        nearest.push_back(processor_seconds() - start);
    }
    std::printf("  %-22s  %-26s %10.4g us\n", "closest feature", "proxima",
                per_ray * median(nearest));
    compare(peers, work.rays.size());
    if (!(sum > 0)) std::puts("  no point is off the surfaces");
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "Scenes of placed meshes beside Embree's and FCL's",
        [&](CLI::App& app) {
            proxima::bench::add_common_options(app, options);
            app.add_option("--instances", options.instances, "How many")
                ->check(CLI::Range(1, 2'000'000));
            app.add_option("--spread", options.spread, "How far apart")->check(CLI::PositiveNumber);
            app.add_option("--rays", options.rays, "How many")->check(CLI::Range(1, 10'000'000));
        },
        [&] {
            for (const std::string& name : proxima::bench::meshes_of(options))
                proxima::bench::race(name, options);
            return 0;
        });
}
