#include "distributed/closest_over_ranks.h"

#include "base/hilbert_code.h"
#include "distributed/ask_ranks.h"
#include "distributed/order_by_key.h"
#include "query/closest/describe_closest.h"
#include "query/closest/find_closest.h"
#include "query/closest/on_feature.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

struct PointQuestion {
    std::array<double, 3> point = {};
    double known = std::numeric_limits<double>::infinity(); ///< in the mesh's unit: nothing farther
};

/// How far a point is from a box, in units of the frame.
double box_distance(const Box& box, const Vec3& p, double scale) noexcept
{
    const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0) * scale;
    return gap.norm();
}

/// What a search for the best of all parts passes over beyond a distance in units of the frame: more
/// than distances are rounded by, as IndexQuery has it.
double reach_of(double squared) noexcept
{
    return (std::sqrt(squared) + 0x1p-38) * (1 + 0x1p-20);
}

ClosestOfWhole whole_answer(const MeshPart& part, const Vec3& p, const RowDistance& found)
{
    ClosestOfWhole answer;
    if (!found.found()) return answer;
    const IndexParts& index = part.index.parts();
    const ClosestFeature own = describe_closest(index, found);
    answer.squared = found.squared;
    answer.kind = static_cast<std::uint32_t>(found.kind());
    answer.point = {own.point[0], own.point[1], own.point[2]};
    const auto is_on = [&](const auto& rows) {
        return is_on_feature(rows[found.rank], own.feature, std::sqrt(own.squared_distance), p);
    };
    answer.is_on_feature =
        index.double_rows().empty() ? is_on(index.float_rows()) : is_on(index.double_rows());
    if (found.kind() == FeatureKind::face) {
        answer.feature = answer.triangle = part.triangles[found.id()];
    } else {
        const auto& features = found.kind() == FeatureKind::vertex ? part.vertices : part.edges;
        answer.feature = features[found.id()].id;
        answer.triangle = features[found.id()].triangle;
    }
    return answer;
}

/// The order of the points along a curve through the whole mesh's box. Throws std::bad_alloc.
std::vector<KeyedIndex> along_curve(const MeshPart& part, std::span<const PointQuestion> questions)
{
    constexpr int bits = 7; // of each coordinate
    constexpr double cells = 1U << static_cast<unsigned>(bits);
    const double edge = std::max(part.whole_box.extent().maxCoeff(), 1 / part.scale);
    return order_by_key(questions.size(), [&](std::uint32_t i) {
        std::array<std::uint32_t, 3> cell{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double at =
                questions[i].point[axis] - part.whole_box.lower[static_cast<Eigen::Index>(axis)];
            cell[axis] = static_cast<std::uint32_t>(std::clamp(at / edge * cells, 0.0, cells - 1));
        }
        return hilbert_code(cell, bits);
    });
}

/// Each point starts from the answer found last, which is near along the curve.
std::vector<ClosestOfWhole> answer_points(const MeshPart& part,
                                          std::span<const PointQuestion> questions)
{
    const IndexParts& index = part.index.parts();
    std::vector<ClosestOfWhole> answers(questions.size());
    Vec3 last_point = Vec3::Zero();
    double last_distance = std::numeric_limits<double>::infinity();
    for (const KeyedIndex& at : along_curve(part, questions)) {
        const PointQuestion& question = questions[at.index];
        const Vec3 p(question.point.data());
        // In the index's units: squares of very small numbers are zero.
        const double step = (index.scale() * (p - last_point)).norm();
        const double near_last = last_distance + index.unscale() * step;
        const RowDistance found = find_closest(index, p, std::min(question.known, near_last));
        answers[at.index] = whole_answer(part, p, found);
        if (!found.found()) continue;
        last_point = p;
        last_distance = std::sqrt(found.squared) * index.unscale();
    }
    return answers;
}

} // namespace

double ClosestOfWhole::distance(double scale) const noexcept
{
    return std::sqrt(RowScale{scale, 1 / scale}.unscale_squared(squared));
}

Result<std::vector<ClosestOfWhole>> closest_over_ranks(const MeshPart& part,
                                                       std::span<const Vec3> points, World& world)
{
    const auto ranks = static_cast<std::size_t>(world.size());
    std::vector<ClosestOfWhole> best;
    std::vector<std::uint32_t> first; // the rank that each point was asked of first
    AskedRanks asked(ranks);
    Status status = world.agree_on([&]() -> Status {
        best.resize(points.size());
        first.resize(points.size());
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            double least = std::numeric_limits<double>::infinity();
            for (std::uint32_t r = 0; r < ranks; ++r) {
                if (part.boxes[r].empty()) continue;
                // By middles where a point is in several boxes.
                const double distance =
                    box_distance(part.boxes[r], points[i], part.scale) +
                    0x1p-20 * ((part.boxes[r].center() - points[i]) * part.scale).norm();
                if (!(distance < least)) continue;
                least = distance;
                first[i] = r;
            }
            asked[first[i]].push_back(i);
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const auto ask = [&] {
        return ask_ranks(
            asked,
            [&](std::uint32_t i) -> PointQuestion {
                const Vec3& p = points[i];
                return {{p[0], p[1], p[2]}, std::sqrt(best[i].squared) / part.scale};
            },
            [&](std::span<const PointQuestion> questions) {
                return answer_points(part, questions);
            },
            [&](std::uint32_t i, const ClosestOfWhole& answer) {
                if (answer.before(best[i])) best[i] = answer;
            },
            world);
    };
    status = ask();
    if (!status) return tl::unexpected(status.error());
    status = world.agree_on([&]() -> Status {
        for (auto& list : asked) list.clear();
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            const double reach = reach_of(best[i].squared);
            for (std::uint32_t r = 0; r < ranks; ++r) {
                if (r == first[i] || part.boxes[r].empty()) continue;
                if (box_distance(part.boxes[r], points[i], part.scale) > reach) continue;
                asked[r].push_back(i);
            }
        }
        return {};
    });
    if (status) status = ask();
    if (!status) return tl::unexpected(status.error());
    return best;
}

} // namespace proxima
