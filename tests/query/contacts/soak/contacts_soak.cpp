// Times of contact of random motions against fine stepping: scripts/soak contacts.
//
//     contacts_soak A B [--motions N] [--steps N] [--seed N]
//
// Each motion is also gone through in equal steps, with an exact test of intersection at each. Wrong is an
// answer that lets B go past a contact that the steps find, one that misses a contact, and one that
// says there is a contact where the meshes do not meet. Prints counts and times. The same for the same
// seed. Exit status 1 if anything was wrong.

#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/time_of_contact.h"
#include "query/contacts/random_motions.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

namespace proxima::soak {
namespace {

struct ContactsSoakOptions {
    std::string a;
    std::string b;
    int motions = 1000;
    int steps = 1000;
    std::uint64_t seed = 1;
};

double processor_seconds()
{
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Result<TriangleMesh> mesh_named(const std::string& name)
{
    return is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
}

struct SoakCounts {
    int contacts = 0;
    int at_start = 0; ///< of these
    int undecided = 0;
    int passed = 0; ///< beyond a contact of the steps
    int missed = 0; ///< free, and the steps find a contact
    int untrue = 0; ///< contact, and the meshes do not meet
    double widest = 0;
    std::vector<double> seconds;
    std::vector<double> steps;
    double stepping = 0;
};

void check_motion_of(const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion, int steps,
                     SoakCounts& counts)
{
    const double start = processor_seconds();
    const auto found = time_of_contact(a, b, motion);
    const double end = processor_seconds();
    counts.seconds.push_back(end - start);
    if (found) counts.steps.push_back(found->steps);
    double first = HUGE_VAL;
    for (int i = 0; i <= steps && first == HUGE_VAL; ++i) {
        const double time = static_cast<double>(i) / steps;
        if (meshes_intersect(a, b, pose_at(motion, time))) first = time;
    }
    counts.stepping += processor_seconds() - end;
    if (!found) {
        counts.missed += first < HUGE_VAL ? 1 : 0;
        return;
    }
    ++counts.contacts;
    counts.at_start += found->touches_at == 0 ? 1 : 0;
    counts.passed += found->free_until > first ? 1 : 0;
    if (found->evidence != ContactEvidence::intersection) {
        ++counts.undecided;
        return;
    }
    counts.untrue += meshes_intersect(a, b, pose_at(motion, found->touches_at)) ? 0 : 1;
    counts.widest = std::max(counts.widest, found->touches_at - found->free_until);
}

int run_soak(const ContactsSoakOptions& options)
{
    std::vector<MeshIndex> indexes;
    std::vector<TriangleMesh> meshes;
    for (const std::string& name : {options.a, options.b}) {
        auto mesh = mesh_named(name);
        if (!mesh) {
            std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
            return 1;
        }
        const auto index = build_mesh_index(*mesh).and_then(
            [](const MeshIndex& plain) { return with_slabs(plain); });
        if (!index) {
            std::fprintf(stderr, "%s\n", describe(index.error()).c_str());
            return 1;
        }
        std::printf("%s: %zu triangles\n", name.c_str(), mesh->triangle_count());
        meshes.push_back(std::move(*mesh));
        indexes.push_back(*index);
    }
    testing::MotionGenerator motions(meshes[0], meshes[1], options.seed);
    SoakCounts counts;
    for (int i = 0; i < options.motions; ++i)
        check_motion_of(indexes[0], indexes[1], motions(), options.steps, counts);
    const auto middle = [](std::vector<double> values) {
        if (values.empty()) return 0.0;
        std::ranges::sort(values);
        return values[values.size() / 2];
    };
    const double most = *std::ranges::max_element(counts.seconds);
    std::printf("%d motions from seed %llu against %d steps each: %d contacts, %d of them at the "
                "start, %d undecided\n"
                "past a contact %d, missed %d, untrue %d; widest interval %.3g\n"
                "%.3f ms a motion, median, %.3f ms at most; %.0f steps, median; stepping %.3f ms a "
                "motion\n",
                options.motions, static_cast<unsigned long long>(options.seed), options.steps,
                counts.contacts, counts.at_start, counts.undecided, counts.passed, counts.missed,
                counts.untrue, counts.widest, 1e3 * middle(counts.seconds), 1e3 * most,
                middle(counts.steps), 1e3 * counts.stepping / options.motions);
    return counts.passed + counts.missed + counts.untrue == 0 ? 0 : 1;
}

} // namespace
} // namespace proxima::soak

int main(int argc, char** argv) // NOLINT(bugprone-exception-escape): one ends it, and says so
{
    proxima::soak::ContactsSoakOptions options;
    CLI::App app("Times of contact against fine stepping");
    app.add_option("A", options.a, "The mesh that stands still")->required();
    app.add_option("B", options.b, "The mesh that moves")->required();
    app.add_option("--motions", options.motions)->check(CLI::Range(1, 100000000));
    app.add_option("--steps", options.steps)->check(CLI::Range(1, 100000000));
    app.add_option("--seed", options.seed);
    CLI11_PARSE(app, argc, argv);
    return proxima::soak::run_soak(options);
}
