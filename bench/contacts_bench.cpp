// Times of contact of scans and penetration depths of convex bodies, ours beside FCL 0.7. In each round every
// case is given to all methods in turn; medians of rounds, then of cases.
//
//     contacts_bench [--cases N] [--rounds N] [--seed N] [--mesh NAME]...
//
// Motions take B from beside A towards it or past it, turning by less than half a revolution. Besides, two fine
// sheets meet, and slide along each other. Every time of ours is checked with the exact test of intersection, and a wrong
// one makes the exit status 1; FCL's times are compared with ours, and its depths with our intervals. A method that
// finds none of the contacts gets "-" for a ratio. Processor time of one thread.
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

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <set>
#include <span>

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

/// One method, to be timed on numbered cases.
struct Method {
    std::string name;
    std::function<void(std::size_t)> run;
    std::function<void(std::size_t)> prepare = [](std::size_t) {}; ///< before each run, not timed
};

/// For each method, the median over cases of the medians over rounds, in seconds.
std::vector<double> time_methods(std::span<const Method> methods, std::size_t cases, int rounds)
{
    std::vector<std::vector<std::vector<double>>> seconds(methods.size(),
                                                          std::vector<std::vector<double>>(cases));
    for (std::size_t round = 0; round < static_cast<std::size_t>(rounds); ++round) {
        for (std::size_t i = 0; i < cases; ++i) {
            for (std::size_t turn = 0; turn < methods.size(); ++turn) {
                const std::size_t m = (turn + round + i) % methods.size();
                methods[m].prepare(i);
                const double start = processor_seconds();
                methods[m].run(i);
                seconds[m][i].push_back(processor_seconds() - start);
            }
        }
    }
    std::vector<double> medians;
    for (const auto& cases_of_method : seconds) {
        std::vector<double> of_cases;
        of_cases.reserve(cases);
        for (const auto& rounds_of_case : cases_of_method)
            of_cases.push_back(median(rounds_of_case));
        medians.push_back(median(of_cases));
    }
    return medians;
}

/// Without a ratio where times cannot be compared.
void print_row(const char* what, const std::string& who, double seconds,
               std::optional<double> ratio, const std::string& says)
{
    char times[20] = "       - ";
    if (ratio) std::snprintf(times, sizeof(times), "%8.2f x", *ratio);
    std::printf("  %-18s %-20s %10.1f us %-10s   %s\n", what, who.c_str(), 1e6 * seconds, times,
                says.c_str());
    std::fflush(stdout);
}

/// Whether the exact test agrees: the meshes do not meet at free_until and do at touches_at, which is infinite
/// where no contact was shown. Where there is no contact, they do not meet at any of 65 times.
bool is_right(const MeshIndex& index, const RigidMotion& motion,
              const std::optional<TimeOfContact>& answer)
{
    const auto meet = [&](double time) {
        return meshes_intersect(index, index, pose_at(motion, time));
    };
    constexpr int last = 64;
    if (!answer) {
        int step = 0;
        while (step <= last && !meet(static_cast<double>(step) / last)) ++step;
        return step > last;
    }
    if (answer->free_until > answer->touches_at) return false;
    if (answer->evidence == ContactEvidence::intersection && !meet(answer->touches_at))
        return false;
    return !meet(answer->free_until) || (answer->free_until == 0 && answer->touches_at == 0);
}

using ContactTimes = std::vector<std::optional<double>>;

/// How a peer's times differ from ours. Motions whose contact ours could not decide do not count.
struct TimeErrors {
    int missed = 0;   ///< contacts that ours finds and the peer does not
    int invented = 0; ///< the reverse
    double late = 0;  ///< the most that a time is behind our interval
    double early = 0; ///< or before it
};

TimeErrors errors_of(const ContactTimes& times, std::span<const std::optional<TimeOfContact>> found)
{
    TimeErrors errors;
    for (std::size_t i = 0; i < times.size(); ++i) {
        const bool meets = found[i] && found[i]->evidence == ContactEvidence::intersection;
        errors.missed += meets && !times[i] ? 1 : 0;
        errors.invented += !found[i] && times[i] ? 1 : 0;
        if (!meets || !times[i]) continue;
        errors.late = std::max(errors.late, *times[i] - found[i]->touches_at);
        errors.early = std::max(errors.early, found[i]->free_until - *times[i]);
    }
    return errors;
}

/// Races times of contact, row by row, and remembers what was wrong.
class TimeRace {
public:
    explicit TimeRace(int rounds) : rounds_(rounds) {}

    void race(const char* what, const TriangleMesh& mesh, const MeshIndex& index,
              const std::vector<RigidMotion>& motions);

    /// How many answers of ours were wrong. Prints this, and how many were checked.
    [[nodiscard]] int report_wrong() const
    {
        std::printf("times of ours checked with the exact test: %d, wrong: %d\n", checked_, wrong_);
        return wrong_;
    }

private:
    int rounds_;
    int checked_ = 0;
    int wrong_ = 0;
    std::set<std::string> blind_; ///< methods that found none of the contacts of some row
};

void TimeRace::race(const char* what, [[maybe_unused]] const TriangleMesh& mesh,
                    const MeshIndex& index, const std::vector<RigidMotion>& motions)
{
    const std::size_t cases = motions.size();
    std::vector<std::optional<TimeOfContact>> found(cases);
    std::vector<Method> methods = {
        {"proxima", [&](std::size_t i) { found[i] = time_of_contact(index, index, motions[i]); }}};
    std::vector<ContactTimes> times(1); // of the methods; the first one's are in `found`
#ifdef PROXIMA_BENCH_FCL
    const FclTimeOfContact fcl(mesh, mesh);
    FclTranslation translation(mesh, mesh);
    times.resize(4, ContactTimes(cases));
    const auto advance = [&](const char* name, FclAdvance how) {
        const std::size_t m = methods.size();
        methods.push_back(
            {name, [&, m, how](std::size_t i) { times[m][i] = fcl.time(motions[i], how); }});
    };
    advance("fcl, steps", FclAdvance::steps);
    advance("fcl, conservative", FclAdvance::conservative);
    const auto turns = [](const RigidMotion& motion) { return motion.turn != Vec3::Zero(); };
    if (std::ranges::none_of(motions, turns)) {
        methods.push_back({"fcl, polynomial",
                           [&](std::size_t i) { times[3][i] = translation.time(motions[i]); },
                           [&](std::size_t i) { translation.prepare(motions[i]); }});
    }
#endif
    const std::vector<double> seconds = time_methods(methods, cases, rounds_);
    int contacts = 0;
    int undecided = 0;
    double sum = 0;
    for (std::size_t i = 0; i < cases; ++i) {
        const bool meets = found[i] && found[i]->evidence == ContactEvidence::intersection;
        contacts += meets ? 1 : 0;
        undecided += found[i] && !meets ? 1 : 0;
        sum += found[i] ? found[i]->free_until : 1;
        ++checked_;
        wrong_ += is_right(index, motions[i], found[i]) ? 0 : 1;
    }
    char says[200];
    std::snprintf(says, sizeof(says), "contacts %d, undecided %d, sum of times %.6f", contacts,
                  undecided, sum);
    print_row(what, methods[0].name, seconds[0], 1, says);
    for (std::size_t m = 1; m < methods.size(); ++m) {
        const TimeErrors errors = errors_of(times[m], found);
        if (contacts > 0 && errors.missed == contacts) blind_.insert(methods[m].name);
        std::snprintf(says, sizeof(says),
                      "contacts missed %d, invented %d, late by up to %.1e, early by %.1e",
                      errors.missed, errors.invented, errors.late, errors.early);
        const bool compares = !blind_.contains(methods[m].name);
        print_row("", methods[m].name, seconds[m],
                  compares ? std::optional(seconds[m] / seconds[0]) : std::nullopt, says);
    }
}

/// Of B at a mesh, from all sides.
std::vector<RigidMotion> motions_of(const TriangleMesh& mesh, const BenchOptions& options)
{
    CaseMaker maker(bounding_box(mesh), options.seed);
    std::vector<RigidMotion> motions(static_cast<std::size_t>(options.cases));
    for (RigidMotion& motion : motions) motion = maker.motion();
    return motions;
}

/// Two sheets of 2 x 2 and 60 x 60 cells, askew. First one comes down on the other, tilted by 5e-4, so that there
/// is a contact to find; then they slide along each other by a quarter of their side at a gap of 1e-3.
void race_sheets(TimeRace& times)
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
    RigidMotion down = {.displacement = -2e-3 * turned.col(2)};
    down.start.rotation =
        Eigen::AngleAxisd(5e-4, turned * Vec3(1, 2, 0).normalized()).toRotationMatrix();
    down.start.translation = 1e-3 * turned.col(2);
    times.race("sheets meet", sheet, index, {down});
    RigidMotion slide = {.displacement = turned * Vec3(0.5, 0, 0)};
    slide.start.translation = 1e-3 * turned.col(2);
    times.race("sheets slide", sheet, index, {slide});
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
    std::vector<Method> methods = {{"proxima", [&](std::size_t i) {
                                        found[i] =
                                            penetration_depth(*solid, *solid, poses[i]).value();
                                    }}};
    std::vector<std::vector<double>> depths(1); // of the methods; the first one's are in `found`
#ifdef PROXIMA_BENCH_FCL
    const FclConvexDepth fcl(*hull, *hull);
    depths.resize(4, std::vector<double>(cases));
    const auto add = [&](const char* name, FclDepthMethod method) {
        const std::size_t m = methods.size();
        methods.push_back(
            {name, [&, m, method](std::size_t i) { depths[m][i] = fcl.depth(poses[i], method); }});
    };
    add("fcl, MPR", FclDepthMethod::mpr);
    add("fcl, GJK and EPA", FclDepthMethod::gjk_epa);
    add("fcl, signed distance", FclDepthMethod::signed_distance);
#endif
    const std::vector<double> seconds = time_methods(methods, cases, options.rounds);
    double sum = 0;
    double widest = 0;
    std::size_t overlaps = 0;
    for (const PenetrationDepth& depth : found) {
        sum += depth.upper;
        widest = std::max(widest, depth.upper - depth.lower);
        overlaps += depth.lower > 0 ? 1 : 0;
    }
    const double size = bounding_box(mesh).extent().norm();
    char says[200];
    std::snprintf(says, sizeof(says),
                  "%zu corners, %zu of %zu overlap; sum %.9g, intervals up to %.1e diagonals wide",
                  hull->points().size(), overlaps, cases, sum, widest / size);
    print_row("depth of hulls", methods[0].name, seconds[0], 1, says);
    for (std::size_t m = 1; m < methods.size(); ++m) {
        double above = 0;
        double below = 0;
        std::size_t missed = 0;
        for (std::size_t i = 0; i < cases; ++i) {
            above = std::max(above, depths[m][i] - found[i].upper);
            below = std::max(below, found[i].lower - depths[m][i]);
            missed += found[i].lower > 0 && depths[m][i] == 0 ? 1 : 0;
        }
        std::snprintf(says, sizeof(says),
                      "too large by up to %.1e diagonals, too small by %.1e, overlaps missed %zu",
                      above / size, below / size, missed);
        const bool compares = overlaps == 0 || missed < overlaps;
        print_row("", methods[m].name, seconds[m],
                  compares ? std::optional(seconds[m] / seconds[0]) : std::nullopt, says);
    }
}

int run_mesh(const std::string& name, const BenchOptions& options, TimeRace& times)
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
    times.race("time of contact", *mesh, *index, motions_of(*mesh, options));
    race_depths(*mesh, options);
    return 0;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, %d cases a row from seed %llu, medians of %d rounds, then of cases\n",
                options.cases, static_cast<unsigned long long>(options.seed), options.rounds);
    TimeRace times(options.rounds);
    for (const std::string& name : meshes_of(options))
        if (const int status = run_mesh(name, options, times); status != 0) return status;
    race_sheets(times);
    return times.report_wrong() > 0 ? 1 : 0;
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
