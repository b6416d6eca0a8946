// Every operation on every nasty mesh, among them one with very many triangles round one vertex:
// scripts/soak nasty.
//
//     nasty_soak [--queries N] [--ticks N] [--round-one-vertex N]
//
// Prints a Markdown table, a row for each operation: on how many meshes, how often it was compared with
// its oracle, how many meshes it refused in words, how many were left out because its time grows with the
// square of the triangles round a vertex (docs/limitations.md), how many it was wrong on, and how long all took, oracles
// included. Exit status 1 if anything was wrong.
#include "lab/nasty_check.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace proxima::soak {
namespace {

using namespace testing;

struct Row {
    std::uint64_t meshes = 0;
    std::uint64_t comparisons = 0;
    std::uint64_t refused = 0;
    std::uint64_t left_out = 0;
    std::uint64_t wrong = 0;
    double seconds = 0;
    double longest = 0; ///< of a mesh
};

class NastySoak {
public:
    explicit NastySoak(NastyEffort effort) : effort_(std::move(effort)) {}

    void run(const oracle::NastyMesh& nasty)
    {
        const auto begin = std::chrono::steady_clock::now();
        const std::vector<NastyOutcome> outcomes = check_nasty(nasty, effort_);
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const NastyOutcome& outcome = outcomes[i];
            ++rows_[i].meshes;
            rows_[i].comparisons += outcome.comparisons;
            rows_[i].refused += outcome.refusal.empty() ? 0 : 1;
            rows_[i].left_out += outcome.left_out ? 1 : 0;
            rows_[i].wrong += outcome.wrong.empty() ? 0 : 1;
            rows_[i].seconds += outcome.seconds;
            rows_[i].longest = std::max(rows_[i].longest, outcome.seconds);
            if (!outcome.wrong.empty()) {
                std::printf("wrong: %s: %s: %s\n", nasty.name.c_str(), names_[i].c_str(),
                            outcome.wrong.c_str());
            }
        }
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
        std::fprintf(stderr, "%7.1f s  %zu triangles: %s\n", passed.count(),
                     nasty.mesh.triangle_count(), nasty.name.c_str());
    }

    void limit_queries(int most) { effort_.queries = std::min(effort_.queries, most); }

    /// Returns whether nothing was wrong.
    [[nodiscard]] bool print() const
    {
        std::printf("| Operation | Meshes | Comparisons | Refused in words | Left out | Wrong | "
                    "Seconds | Of one "
                    "mesh at most |\n|---|---:|---:|---:|---:|---:|---:|---:|\n");
        std::uint64_t wrong = 0;
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            std::printf("| %s |", names_[i].c_str());
            for (const std::uint64_t number : {rows_[i].meshes, rows_[i].comparisons,
                                               rows_[i].refused, rows_[i].left_out, rows_[i].wrong})
                std::printf(" %llu |", static_cast<unsigned long long>(number));
            std::printf(" %.1f | %.1f |\n", rows_[i].seconds, rows_[i].longest);
            wrong += rows_[i].wrong;
        }
        return wrong == 0;
    }

private:
    NastyEffort effort_;
    std::vector<std::string> names_ = nasty_operations();
    std::vector<Row> rows_ = std::vector<Row>(names_.size());
};

int run(int argc, char** argv)
{
    CLI::App app("Every operation on every nasty mesh.");
    NastyEffort effort{.queries = 400, .ticks = 2000, .folder = {}};
    std::uint32_t most = 1'000'000;
    app.add_option("--queries", effort.queries, "Points, rays and so on, of each mesh");
    app.add_option("--ticks", effort.ticks, "Of touch, of each mesh");
    app.add_option("--round-one-vertex", most, "Triangles round one vertex, of the largest mesh");
    CLI11_PARSE(app, argc, argv);
    std::string name = (std::filesystem::temp_directory_path() / "nasty_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) return 1;
    effort.folder = name;
    NastySoak soak(effort);
    for (const oracle::NastyMesh& nasty : oracle::nasty_corpus(400)) soak.run(nasty);
    soak.limit_queries(24); // brute force looks at all triangles for each
    const oracle::NamedShape last = oracle::nasty_shapes(most).back();
    soak.run({last.name + ", the largest", last.shape.mesh(1, Vec3::Zero()), last.is_closed});
    std::filesystem::remove_all(effort.folder);
    return soak.print() ? 0 : 1;
}

} // namespace
} // namespace proxima::soak

int main(int argc, char** argv) // NOLINT(bugprone-exception-escape): one ends it, and says so
{
    return proxima::soak::run(argc, argv);
}
