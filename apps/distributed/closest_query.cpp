#include "distributed/closest_query.h"

#include "distributed/oracle.h"

namespace proxima {

std::string_view difference(const ClosestOfWhole& answer, const ClosestFeature& expected,
                            double scale)
{
    if (!is_same(answer.distance(scale), std::sqrt(expected.squared_distance)))
        return "the distance";
    if (answer.kind != static_cast<std::uint32_t>(expected.feature.kind)) return "the kind";
    if (answer.feature != expected.feature.id) return "the feature";
    if (answer.triangle != to_index(expected.triangle)) return "the triangle";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!is_same(answer.point[axis], expected.point[static_cast<Eigen::Index>(axis)]))
            return "the closest point";
    }
    return {};
}

std::vector<Vec3> points_of(const TableRows& rows)
{
    std::vector<Vec3> points;
    points.reserve(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) points.emplace_back(rows[i].data());
    return points;
}

Result<std::vector<ClosestOfWhole>> ClosestQuery::answer(const MeshPart& part,
                                                         const TableRows& rows, World& world)
{
    return closest_over_ranks(part, points_of(rows), world);
}

AnswerRow row_of(const MeshPart& part, std::uint64_t index, const ClosestOfWhole& answer)
{
    return {index,           answer.distance(part.scale),           Vec3(answer.point.data()),
            answer.triangle, static_cast<FeatureKind>(answer.kind), answer.feature};
}

void ClosestQuery::append(const MeshPart& part, std::uint64_t index, const Answer& answer,
                          AnswerFormat format, fmt::memory_buffer& text)
{
    append_answer(text, format, row_of(part, index, answer));
}

Status ClosestQuery::verify(const MeshIndex& oracle, const MeshPart& part, const TableRows& rows,
                            std::span<const Answer> answers)
{
    const std::vector<Vec3> points = points_of(rows);
    std::vector<ClosestFeature> expected(points.size());
    Status status =
        closest_features(oracle, points, {.answers = expected}, {.execution = {.threads = {1}}});
    if (!status) return status;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string_view found = difference(answers[i], expected[i], part.scale);
        if (!found.empty()) return answer_differs(found, "point", rows.first + i);
    }
    return {};
}

} // namespace proxima
