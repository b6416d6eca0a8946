// A mesh against itself in a hundred poses, ours beside FCL: passes in turn, medians and ratios.
//
//     contact_bench [--rounds N] [--seed N] [--mesh NAME]...
//
// Every answer and every list of pairs is compared with ours, and what differs is counted. One
// thread.
#include "bench_program.h"
#include "contact_peers.h"
#include "contact_poses.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iterator>

namespace proxima::bench {
namespace {

using BenchOptions = CommonOptions;

enum class Question : std::uint8_t { boolean, pairs };
constexpr std::array questions = {Question::boolean, Question::pairs};

/// What a peer did on one set of poses.
struct SetResult {
    std::array<std::vector<double>, 2> seconds; ///< of a pass over all poses, by question
    std::size_t meeting = 0;
    std::size_t pairs = 0;
    std::size_t wrong_answers = 0;
    std::size_t missing_pairs = 0; ///< that ours has
    std::size_t added_pairs = 0;   ///< that ours has not
};

void pass(ContactPeer& peer, Question question, const PoseSet& set, SetResult& result)
{
    std::size_t sum = 0;
    const double start = processor_seconds();
    for (const RigidTransform& pose : set.poses) {
        sum +=
            question == Question::boolean ? (peer.intersects(pose) ? 1 : 0) : peer.find_pairs(pose);
    }
    const double seconds = processor_seconds() - start;
    result.seconds[static_cast<std::size_t>(question)].push_back(seconds);
    (question == Question::boolean ? result.meeting : result.pairs) = sum;
}

void compare(std::span<const std::unique_ptr<ContactPeer>> peers, const PoseSet& set,
             std::vector<SetResult>& results)
{
    for (const RigidTransform& pose : set.poses) {
        (void)peers[0]->find_pairs(pose);
        const std::vector<TrianglePair> ours = peers[0]->sorted_pairs();
        for (std::size_t i = 0; i < peers.size(); ++i) {
            results[i].wrong_answers += peers[i]->intersects(pose) == ours.empty() ? 1 : 0;
            (void)peers[i]->find_pairs(pose);
            const std::vector<TrianglePair> other = peers[i]->sorted_pairs();
            std::vector<TrianglePair> difference;
            std::ranges::set_difference(ours, other, std::back_inserter(difference));
            results[i].missing_pairs += difference.size();
            difference.clear();
            std::ranges::set_difference(other, ours, std::back_inserter(difference));
            results[i].added_pairs += difference.size();
        }
    }
}

void race(std::span<const std::unique_ptr<ContactPeer>> peers, const PoseSet& set, int rounds,
          std::vector<SetResult>& results)
{
    results.resize(peers.size());
    compare(peers, set, results);
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t turn = 0; turn < peers.size(); ++turn) {
            const std::size_t i = (turn + static_cast<std::size_t>(round)) % peers.size();
            for (const Question question : questions) pass(*peers[i], question, set, results[i]);
        }
    }
}

double microseconds(const SetResult& result, Question question, const PoseSet& set)
{
    return 1e6 * median(result.seconds[static_cast<std::size_t>(question)]) /
           static_cast<double>(set.poses.size());
}

int run_mesh(const std::string& name, const BenchOptions& options)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    std::vector<std::unique_ptr<ContactPeer>> peers;
    peers.push_back(make_proxima_contact_peer(*mesh));
#ifdef PROXIMA_BENCH_FCL
    peers.push_back(make_fcl_contact_peer(*mesh, FclVolume::obb_rss));
    peers.push_back(make_fcl_contact_peer(*mesh, FclVolume::obb));
#endif
    std::printf("%s: %zu triangles\n", std::filesystem::path(name).filename().string().c_str(),
                mesh->triangle_count());
    for (const auto& peer : peers)
        std::printf("    %-10s built in %.3f s\n", peer->name().c_str(), peer->build_seconds());
    const MeshIndex index = build_mesh_index(*mesh).value();
    const std::vector<PoseSet> sets = contact_poses(*mesh, index, options.seed);
    std::printf("    %-8s %-10s %22s %22s   (us a pose, over ours)\n", "", "", "boolean",
                "all pairs");
    std::vector<std::vector<SetResult>> results(sets.size());
    for (std::size_t k = 0; k < sets.size(); ++k) {
        race(peers, sets[k], options.rounds, results[k]);
        for (std::size_t i = 0; i < peers.size(); ++i) {
            const SetResult& own = results[k][i];
            std::printf("    %-8s %-10s", sets[k].name, peers[i]->name().c_str());
            for (const Question question : questions) {
                const double time = microseconds(own, question, sets[k]);
                std::printf("%13.2f (%6.2f x)", time,
                            time / microseconds(results[k][0], question, sets[k]));
            }
            std::printf("   %zu of %zu meet, %zu pairs", own.meeting, sets[k].poses.size(),
                        own.pairs);
            if (i > 0) {
                std::printf("; %zu answers differ, %zu pairs missing, %zu added", own.wrong_answers,
                            own.missing_pairs, own.added_pairs);
            }
            std::printf("\n");
        }
    }
    for (std::size_t i = 0; i < peers.size(); ++i) {
        std::printf("    %-8s %-10s", "all", peers[i]->name().c_str());
        for (const Question question : questions) {
            double time = 0;
            double ours = 0;
            double poses = 0;
            for (std::size_t k = 0; k < sets.size(); ++k) {
                const auto count = static_cast<double>(sets[k].poses.size());
                time += count * microseconds(results[k][i], question, sets[k]);
                ours += count * microseconds(results[k][0], question, sets[k]);
                poses += count;
            }
            std::printf("%13.2f (%6.2f x)", time / poses, time / ours);
        }
        std::printf("\n");
    }
    std::fflush(stdout);
    return 0;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, poses from seed %llu, medians of %d interleaved rounds\n",
                static_cast<unsigned long long>(options.seed), options.rounds);
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
        argc, argv, "Meshes against themselves in many poses, ours beside FCL",
        [&](CLI::App& app) { add_common_options(app, options); },
        [&] { return proxima::bench::run(options); });
}
