// Times of contact of scans and penetration depths of convex bodies, ours beside FCL 0.7: passes in turn, medians of
// rounds, then of cases.
//
//     contacts_bench [--cases N] [--rounds N] [--seed N] [--mesh NAME]...
//
// Motions take B from beside A towards it or past it, turning by less than half a revolution. Besides, two fine
// sheets slide along each other. Every time of FCL's is compared with the exact test of intersection, and every depth with our interval. Processor time of one
// thread.
#include "bench_program.h"
#include "proxima/contacts.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/time_of_contact.h"
#ifdef PROXIMA_BENCH_FCL
#include "fcl_contacts_peer.h"
#endif

#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>

namespace proxima::bench {
namespace {

struct BenchOptions : CommonOptions {
    int cases = 40;
};

class CaseMaker {
public:
    CaseMaker(const Box& box, std::uint64_t seed)
        : center_(box.center()), size_(box.extent().norm()), random_(seed)
    {}

    RigidTransform pose(double apart)
    {
        RigidTransform pose;
        const Vec3 axis = direction();
        pose.rotation = Eigen::AngleAxisd(3 * unit(), axis).toRotationMatrix();
        pose.translation = center_ + apart * size_ * direction() - pose.rotation * center_;
        return pose;
    }
    RigidMotion motion() { return motion_between(pose(1.1), pose(0.4 * (1 + unit())), center_); }

private:
    double unit() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    Vec3 direction()
    {
        std::normal_distribution<double> normal;
        const double x = normal(random_);
        const double y = normal(random_);
        return Vec3(x, y, normal(random_)).normalized();
    }

    Vec3 center_;
    double size_;
    std::mt19937_64 random_;
};

/// Median over cases of the medians over rounds, in seconds.
template <class Run>
double time_cases(std::size_t cases, int rounds, const Run& run)
{
    std::vector<double> medians;
    for (std::size_t i = 0; i < cases; ++i) {
        std::vector<double> seconds;
        for (int round = 0; round < rounds; ++round) {
            const double start = processor_seconds();
            run(i);
            seconds.push_back(processor_seconds() - start);
        }
        medians.push_back(median(seconds));
    }
    return median(medians);
}

void print_row(const char* what, const char* who, double seconds, double own,
               const std::string& says)
{
    std::printf("  %-18s %-10s %10.1f us %8.2f x   %s\n", what, who, 1e6 * seconds, seconds / own,
                says.c_str());
    std::fflush(stdout);
}

void race_times(const char* what, const TriangleMesh& mesh, const MeshIndex& index,
                const std::vector<RigidMotion>& motions, int rounds)
{
    const std::size_t cases = motions.size();
    std::vector<std::optional<TimeOfContact>> found(cases);
    const double own = time_cases(cases, rounds, [&](std::size_t i) {
        found[i] = time_of_contact(index, index, motions[i]);
    });
    int contacts = 0;
    double sum = 0;
    for (const auto& answer : found) {
        contacts += answer ? 1 : 0;
        sum += answer ? answer->free_until : 1;
    }
    print_row(what, "proxima", own, own,
              "contacts " + std::to_string(contacts) + ", sum of times " + std::to_string(sum));
#ifdef PROXIMA_BENCH_FCL
    const FclTimeOfContact fcl(mesh, mesh);
    for (const FclAdvance how : {FclAdvance::steps, FclAdvance::conservative}) {
        std::vector<std::optional<double>> times(cases);
        const double theirs =
            time_cases(cases, rounds, [&](std::size_t i) { times[i] = fcl.time(motions[i], how); });
        int missed = 0;
        int invented = 0;
        double late = 0;
        double early = 0;
        for (std::size_t i = 0; i < cases; ++i) {
            missed += found[i] && !times[i] ? 1 : 0;
            invented += !found[i] && times[i] ? 1 : 0;
            if (!found[i] || !times[i]) continue;
            late = std::max(late, *times[i] - found[i]->touches_at);
            early = std::max(early, found[i]->free_until - *times[i]);
        }
        char says[200];
        std::snprintf(says, sizeof(says),
                      "contacts missed %d, invented %d, late by up to %.1e, early by %.1e", missed,
                      invented, late, early);
        print_row("", how == FclAdvance::steps ? "fcl, steps" : "fcl", theirs, own, says);
    }
#endif
}

/// Of B at a mesh, from all sides.
std::vector<RigidMotion> motions_of(const TriangleMesh& mesh, const BenchOptions& options)
{
    CaseMaker maker(bounding_box(mesh), options.seed);
    std::vector<RigidMotion> motions(static_cast<std::size_t>(options.cases));
    for (RigidMotion& motion : motions) motion = maker.motion();
    return motions;
}

/// Two sheets of 2 x 2 and 60 x 60 cells, askew, that slide along each other by a quarter of their side at a
/// gap of 1e-3.
void race_sheets(const BenchOptions& options)
{
    const Mat3 turned = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    constexpr std::uint32_t cells = 60;
    std::vector<Vec3> points;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i <= cells; ++i) {
        for (std::uint32_t k = 0; k <= cells; ++k)
            points.emplace_back(turned * Vec3(2.0 * i / cells - 1, 2.0 * k / cells - 1, 0));
    }
    for (std::uint32_t i = 0; i < cells; ++i) {
        for (std::uint32_t k = 0; k < cells; ++k) {
            const std::uint32_t at = i * (cells + 1) + k;
            triangles.push_back({at, at + cells + 1, at + 1});
            triangles.push_back({at + 1, at + cells + 1, at + cells + 2});
        }
    }
    const TriangleMesh sheet = make_triangle_mesh(std::move(points), std::move(triangles)).value();
    const MeshIndex index = with_slabs(build_mesh_index(sheet).value()).value();
    std::printf("sheets: %zu triangles each\n", sheet.triangle_count());
    RigidMotion motion = {.displacement = turned * Vec3(0.5, 0, 0)};
    motion.start.translation = 1e-3 * turned.col(2);
    race_times("sheets slide", sheet, index, {motion}, options.rounds);
}

void race_depths(const TriangleMesh& mesh, const BenchOptions& options)
{
    const auto hull = convex_hull(mesh.positions());
    if (!hull) return;
    std::vector<Vec3> points(hull->points().begin(), hull->points().end());
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t f = 0; f < hull->facet_count(); ++f) {
        const auto loop = hull->facet_loop(f);
        for (std::size_t i = 2; i < loop.size(); ++i)
            triangles.push_back({loop[0], loop[i - 1], loop[i]});
    }
    const auto surface = make_triangle_mesh(std::move(points), std::move(triangles));
    const auto solid = build_mesh_index(surface.value()).and_then([](const MeshIndex& index) {
        return build_solid(index);
    });
    if (!solid) {
        std::printf("  no hull: %s\n", describe(solid.error()).c_str());
        return;
    }
    const auto cases = static_cast<std::size_t>(options.cases);
    CaseMaker maker(bounding_box(mesh), options.seed);
    std::vector<RigidTransform> poses(cases);
    for (RigidTransform& pose : poses) pose = maker.pose(0.3);
    std::vector<PenetrationDepth> found(cases);
    const double own = time_cases(cases, options.rounds, [&](std::size_t i) {
        found[i] = penetration_depth(*solid, *solid, poses[i]).value();
    });
    double sum = 0;
    double widest = 0;
    for (const PenetrationDepth& depth : found) {
        sum += depth.upper;
        widest = std::max(widest, depth.upper - depth.lower);
    }
    const double size = bounding_box(mesh).extent().norm();
    char says[200];
    std::snprintf(says, sizeof(says), "%zu corners; sum %.9g, intervals up to %.1e diagonals wide",
                  hull->points().size(), sum, widest / size);
    print_row("depth of hulls", "proxima", own, own, says);
#ifdef PROXIMA_BENCH_FCL
    const FclConvexDepth fcl(*hull, *hull);
    std::vector<double> depths(cases);
    const double theirs =
        time_cases(cases, options.rounds, [&](std::size_t i) { depths[i] = fcl.depth(poses[i]); });
    double above = 0;
    double below = 0;
    for (std::size_t i = 0; i < cases; ++i) {
        above = std::max(above, depths[i] - found[i].upper);
        below = std::max(below, found[i].lower - depths[i]);
    }
    std::snprintf(says, sizeof(says), "too large by up to %.1e diagonals, too small by %.1e",
                  above / size, below / size);
    print_row("", "fcl", theirs, own, says);
#endif
}

int run_mesh(const std::string& name, const BenchOptions& options)
{
    const auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    const auto index =
        build_mesh_index(*mesh).and_then([](const MeshIndex& plain) { return with_slabs(plain); });
    if (!index) {
        std::fprintf(stderr, "%s\n", describe(index.error()).c_str());
        return 1;
    }
    std::printf("%s: %zu triangles\n", std::filesystem::path(name).filename().string().c_str(),
                mesh->triangle_count());
    race_times("time of contact", *mesh, *index, motions_of(*mesh, options), options.rounds);
    race_depths(*mesh, options);
    return 0;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, %d cases a row from seed %llu, medians of %d rounds, then of cases\n",
                options.cases, static_cast<unsigned long long>(options.seed), options.rounds);
    for (const std::string& name : meshes_of(options))
        if (const int status = run_mesh(name, options); status != 0) return status;
    race_sheets(options);
    return 0;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "Times of contact and penetration depths, ours beside FCL",
        [&](CLI::App& app) {
            app.add_option("--cases", options.cases, "Motions and poses of each row")
                ->check(CLI::Range(1, 1000000));
            add_common_options(app, options);
        },
        [&] { return proxima::bench::run(options); });
}
