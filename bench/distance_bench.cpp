// The distance of a mesh from itself in other poses, ours beside FCL 0.7: passes in turn, medians
// and ratios.
//
//     distance_bench [--poses N] [--rounds N] [--seed N] [--mesh NAME]...
//
//     gap G     turned at random, then moved together from a random side until the distance is G
//               diagonals, up to a hundredth of that
//     random    turned at random, its center anywhere within a diagonal: many touch
//     coherent  along a path at the gap 1e-2, each pose a step of 1e-3 diagonals and radians on;
//     ours
//               starts from its last answer
//
// Every distance is compared with ours. Prints tables; one thread.
#include "bench_program.h"
#include "fcl_distance_peer.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <random>

namespace proxima::bench {
namespace {

struct BenchOptions : CommonOptions {
    int poses = 30;
};

class ProximaDistance final : public DistancePeer {
public:
    explicit ProximaDistance(const TriangleMesh& mesh)
    {
        const auto start = std::chrono::steady_clock::now();
        const auto triangles = build_mesh_index(mesh, {.execution = {.threads = {1}}});
        index_ = with_slabs(triangles.value(), {.execution = {.threads = {1}}}).value();
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    [[nodiscard]] std::string name() const override { return "proxima"; }
    [[nodiscard]] double build_seconds() const override { return seconds_; }
    [[nodiscard]] double distance(const RigidTransform& pose_b) override
    {
        return mesh_distance(index_, index_, pose_b)->distance;
    }
    [[nodiscard]] const MeshIndex& index() const { return index_; }

private:
    MeshIndex index_;
    double seconds_ = 0;
};

/// Like ProximaDistance, started from the last answer.
class WarmProximaDistance final : public DistancePeer {
public:
    explicit WarmProximaDistance(const MeshIndex& index) : index_(index) {}
    [[nodiscard]] std::string name() const override { return "proxima, from last"; }
    [[nodiscard]] double build_seconds() const override { return 0; }
    [[nodiscard]] double distance(const RigidTransform& pose_b) override
    {
        last_ = *mesh_distance(index_, index_, pose_b, {.start_from = &last_});
        return last_.distance;
    }

private:
    const MeshIndex& index_;
    MeshDistance last_;
};

class PoseMaker {
public:
    PoseMaker(const MeshIndex& index, const Box& box, std::uint64_t seed)
        : index_(index), center_(box.center()), diagonal_(box.extent().norm()), random_(seed)
    {}

    RigidTransform at_gap(double gap)
    {
        RigidTransform pose = turned();
        const Vec3 from = direction();
        const double wanted = gap * diagonal_;
        double along = 2 * diagonal_ + wanted;
        for (int step = 0; step < 1000; ++step) {
            place(pose, along * from);
            // No step takes it nearer than wanted.
            const double surplus = mesh_distance(index_, index_, pose)->distance - wanted;
            if (surplus <= 0.01 * wanted) break;
            along -= surplus;
        }
        return pose;
    }
    RigidTransform anywhere()
    {
        RigidTransform pose = turned();
        const double x = signed_unit();
        const double y = signed_unit();
        place(pose, diagonal_ * Vec3(x, y, signed_unit()));
        return pose;
    }
    /// The pose moved and turned about its center by a little.
    RigidTransform next(const RigidTransform& pose)
    {
        const Vec3 center = pose(center_) - center_;
        RigidTransform moved = pose;
        moved.rotation = Eigen::AngleAxisd(1e-3, direction()).toRotationMatrix() * pose.rotation;
        place(moved, center + 1e-3 * diagonal_ * direction());
        return moved;
    }

private:
    double signed_unit() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    Vec3 direction()
    {
        for (;;) {
            const double x = signed_unit();
            const double y = signed_unit();
            const Vec3 v(x, y, signed_unit());
            if (v.squaredNorm() <= 1 && v.squaredNorm() > 0.01) return v.normalized();
        }
    }
    RigidTransform turned()
    {
        const Vec3 axis = direction();
        RigidTransform pose;
        pose.rotation =
            Eigen::AngleAxisd(3.141592653589793 * signed_unit(), axis).toRotationMatrix();
        return pose;
    }
    /// With its center moved by that much.
    void place(RigidTransform& pose, const Vec3& by) const
    {
        pose.translation = center_ + by - pose.rotation * center_;
    }

    const MeshIndex& index_;
    Vec3 center_;
    double diagonal_;
    std::mt19937_64 random_;
};

void race(const char* name, std::span<const RigidTransform> poses,
          std::span<const std::unique_ptr<DistancePeer>> peers, int rounds, double diagonal)
{
    std::vector<std::vector<double>> seconds(peers.size() * poses.size());
    std::vector<double> distances(peers.size() * poses.size());
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t turn = 0; turn < peers.size(); ++turn) {
            const std::size_t i = (turn + static_cast<std::size_t>(round)) % peers.size();
            for (std::size_t k = 0; k < poses.size(); ++k) {
                const double start = processor_seconds();
                distances[i * poses.size() + k] = peers[i]->distance(poses[k]);
                seconds[i * poses.size() + k].push_back(processor_seconds() - start);
            }
        }
    }
    double own = 0;
    for (std::size_t i = 0; i < peers.size(); ++i) {
        std::vector<double> medians;
        double sum = 0;
        double worst = 0; // difference from ours
        for (std::size_t k = 0; k < poses.size(); ++k) {
            medians.push_back(median(seconds[i * poses.size() + k]));
            sum += medians.back();
            worst = std::max(
                worst, std::abs(std::max(distances[i * poses.size() + k], 0.0) - distances[k]));
        }
        const double middle = median(medians);
        if (i == 0) own = middle;
        std::printf(
            "  %-10s %-20s %10.1f us %8.2f x   mean %10.1f   greatest %10.1f   off by %.1e\n",
            i == 0 ? name : "", peers[i]->name().c_str(), 1e6 * middle, middle / own,
            1e6 * sum / static_cast<double>(poses.size()), 1e6 * *std::ranges::max_element(medians),
            worst / diagonal);
    }
    std::fflush(stdout);
}

int run_mesh(const std::string& name, const BenchOptions& options)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    std::vector<std::unique_ptr<DistancePeer>> peers;
    auto own = std::make_unique<ProximaDistance>(*mesh);
    const MeshIndex& index = own->index();
    peers.push_back(std::move(own));
    peers.push_back(std::make_unique<WarmProximaDistance>(index));
#ifdef PROXIMA_BENCH_FCL
    peers.push_back(make_fcl_distance_peer(*mesh, *mesh, FclVolume::rss));
    peers.push_back(make_fcl_distance_peer(*mesh, *mesh, FclVolume::obb_rss));
#endif
    std::printf("%s: %zu triangles\n", std::filesystem::path(name).filename().string().c_str(),
                mesh->triangle_count());
    for (const auto& peer : peers)
        std::printf("    %-20s built in %.3f s\n", peer->name().c_str(), peer->build_seconds());
    const Box box = bounding_box(*mesh);
    const double diagonal = box.extent().norm();
    PoseMaker maker(index, box, options.seed);
    std::vector<RigidTransform> poses(static_cast<std::size_t>(options.poses));
    for (const auto& [title, gap] :
         {std::pair("gap 1e-3", 1e-3), {"gap 1e-2", 1e-2}, {"gap 0.1", 0.1}, {"gap 1", 1.0}}) {
        for (RigidTransform& pose : poses) pose = maker.at_gap(gap);
        race(title, poses, peers, options.rounds, diagonal);
    }
    for (RigidTransform& pose : poses) pose = maker.anywhere();
    race("random", poses, peers, options.rounds, diagonal);
    poses[0] = maker.at_gap(1e-2);
    for (std::size_t i = 1; i < poses.size(); ++i) poses[i] = maker.next(poses[i - 1]);
    race("coherent", poses, peers, options.rounds, diagonal);
    return 0;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, %d poses a row from seed %llu, medians of %d interleaved rounds, then "
                "of poses\n",
                options.poses, static_cast<unsigned long long>(options.seed), options.rounds);
    for (const std::string& name : meshes_of(options))
        if (const int status = run_mesh(name, options); status != 0) return status;
    return 0;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "Distances between meshes, ours beside FCL",
        [&](CLI::App& app) {
            app.add_option("--poses", options.poses, "Poses of each row")
                ->check(CLI::Range(1, 1000000));
            add_common_options(app, options);
        },
        [&] { return proxima::bench::run(options); });
}
