#include "query/closest/soak/closest_check.h"

#include "base/text.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "oracles/quad_distance.h"
#include "query/closest/brute_force.h"
#include "query/closest/check_answers.h"
#include "query/closest/feature_distance.h"
#include "query/closest/find_closest.h"

#include <algorithm>
#include <cmath>

namespace proxima::soak {
namespace {

/// Brute force answers for meshes up to this many triangles, and for each so manieth point of
/// others.
constexpr std::size_t brute_triangles = 200;
constexpr std::size_t brute_stride = 1024;

bool same_bits(const ClosestFeature& a, const ClosestFeature& b)
{
    return a.feature == b.feature && a.triangle == b.triangle && a.point == b.point &&
           a.barycentric == b.barycentric && a.squared_distance == b.squared_distance;
}

} // namespace

void ClosestTally::add(const ClosestTally& other)
{
    points += other.points;
    wrong += other.wrong;
    ties += other.ties;
    brute += other.brute;
    worst = std::max(worst, other.worst);
    worst_steps = std::max(worst_steps, other.worst_steps);
    worst_blocks = std::max(worst_blocks, other.worst_blocks);
    if (first_wrong.empty()) first_wrong = other.first_wrong;
}

ClosestCheck::ClosestCheck(const SoakSearch& search, std::span<const MeshIndex> indexes)
    : search_(search), indexes_(indexes)
{
    const Box box = bounding_box(search.mesh);
    center_ = box.center();
    diagonal_ = box.extent().norm();
    largest_ = box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
}

ClosestFeature ClosestCheck::truth_at(const Vec3& p, std::size_t place, ClosestTally& tally) const
{
    const bool is_small = search_.mesh.triangle_count() <= brute_triangles;
    if (!is_small && place % brute_stride != 0) return closest_feature(search_.index, p).value();
    ++tally.brute;
    return closest_feature_by_brute_force(search_.mesh, search_.topology, p);
}

/// From the whole feature, its borders included.
double ClosestCheck::exact_distance(const Feature& feature, const Vec3& p) const
{
    const TriangleMesh& mesh = search_.mesh;
    oracle::Quad squared = 0;
    switch (feature.kind) {
    case FeatureKind::vertex: {
        const oracle::QuadPoint gap =
            oracle::QuadPoint(p) - oracle::QuadPoint(mesh.position(VertexId{feature.id}));
        squared = dot(gap, gap);
        break;
    }
    case FeatureKind::edge: {
        const auto [from, to] = search_.topology.vertices(EdgeId{feature.id});
        squared =
            oracle::squared_distance(oracle::QuadPoint(p), mesh.position(from), mesh.position(to));
        break;
    }
    case FeatureKind::face:
        squared =
            oracle::squared_distance(oracle::QuadPoint(p), mesh.triangle(TriangleId{feature.id}));
        break;
    }
    return static_cast<double>(oracle::root(squared));
}

std::string ClosestCheck::problem(const ClosestFeature& found, const ClosestFeature& truth,
                                  const Vec3& p, ClosestTally& tally) const
{
    const double distance = std::sqrt(found.squared_distance);
    const double true_distance = std::sqrt(truth.squared_distance);
    const double size = std::max(diagonal_, true_distance);
    const double error = std::abs(distance - true_distance) / size;
    tally.worst = std::max(tally.worst, error);
    if (!(error <= 1e-12)) return "distance";

    if (found.feature != truth.feature) {
        // Each search may be a few roundings of the largest coordinate off.
        const double rounding = 0x1p-50 * (size + largest_);
        const double gap = exact_distance(found.feature, p) - exact_distance(truth.feature, p);
        if (!(std::abs(gap) <= rounding)) return "feature";
        ++tally.ties;
    }
    if (found.triangle != lowest_triangle(search_.topology, found.feature)) return "triangle";

    const Triangle triangle = search_.mesh.triangle(found.triangle);
    Vec3 point = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
        const double weight = found.barycentric[static_cast<std::size_t>(i)];
        if (!(weight >= 0 && weight <= 1)) return "barycentric";
        point += weight * triangle[i];
    }
    if (!((point - found.point).norm() <= 1e-12 * (size + largest_))) return "barycentric";
    if (!(std::abs((found.point - p).norm() - distance) <= 1e-12 * (size + largest_)))
        return "point";
    return {};
}

ClosestTally ClosestCheck::check(std::span<const Vec3> points) const
{
    ClosestTally tally;
    std::vector<ClosestFeature> batch(points.size());
    std::vector<ClosestFeature> first(points.size());
    for (const MeshIndex& listed : indexes_) {
        const ProximityStatistics& worst = listed.parts().lists()->statistics();
        const bool is_first = &listed == indexes_.data();
        const bool batch_ended = closest_features(listed, points, {.answers = batch}).has_value();
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3& p = points[i];
            QuerySteps steps;
            const ClosestFeature found = closest_feature(listed, p, {}, steps).value();
            std::string wrong;
            if (is_first) {
                first[i] = found;
                ++tally.points;
                const ClosestFeature truth = truth_at(p, i, tally);
                wrong = problem(found, truth, p, tally);
                if (!wrong.empty())
                    wrong = concat(wrong, ": ", text_of(found), ", not ", text_of(truth));
            } else if (!same_bits(found, first[i])) {
                wrong = concat("budget: ", text_of(found), ", not ", text_of(first[i]));
            }
            if (!batch_ended || !same_bits(found, batch[i])) {
                wrong = concat("batch: ", text_of(batch[i]), ", not ", text_of(found));
            }
            std::array<std::uint32_t, 3> at{};
            if (listed.parts().lists()->locate(listed.parts().lists()->frame().to_frame(p), at)) {
                const double step_part = static_cast<double>(steps.steps) / worst.worst_case_steps;
                // Where no leaf has a list, no block is scanned, and none may be.
                const double block_part =
                    steps.blocks == 0 ? 0.0
                                      : static_cast<double>(steps.blocks) / worst.worst_case_blocks;
                const std::uint32_t most_searches = worst.searched_leaves == 0 ? 0 : 1;
                tally.worst_steps = std::max(tally.worst_steps, step_part);
                tally.worst_blocks = std::max(tally.worst_blocks, block_part);
                if (!(step_part <= 1 && block_part <= 1 && steps.searches <= most_searches)) {
                    wrong = concat("worst case: ", steps.steps, " steps, ", steps.blocks,
                                   " blocks, ", steps.searches, " searches");
                }
            }
            if (wrong.empty()) continue;
            ++tally.wrong;
            if (!tally.first_wrong.empty()) continue;
            tally.first_wrong = concat(wrong, " (point ", p.x(), " ", p.y(), " ", p.z(), ")");
        }
    }
    return tally;
}

} // namespace proxima::soak
