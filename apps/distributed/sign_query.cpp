#include "distributed/sign_query.h"

namespace proxima {

void SignQuery::append(const MeshPart& part, std::uint64_t index, const Answer& answer,
                       AnswerFormat format, fmt::memory_buffer& text)
{
    AnswerRow row = row_of(part, index, answer.closest);
    row.sign = {answer.signed_distance(part.scale), answer.method()};
    append_answer(text, format, row);
}

Result<MeshIndex> SignQuery::oracle(const std::string& model)
{
    return index_of_whole(model).and_then(
        [](const MeshIndex& index) { return with_signs(index, {.execution = {.threads = {1}}}); });
}

Status SignQuery::verify(const MeshIndex& oracle, const MeshPart& part, const TableRows& rows,
                         std::span<const Answer> answers)
{
    const std::vector<Vec3> points = points_of(rows);
    std::vector<SignedDistance> expected(points.size());
    Status status =
        signed_distances(oracle, points, {.answers = expected}, {.execution = {.threads = {1}}});
    if (!status) return status;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SignedOfWhole& answer = answers[i];
        std::string_view found = difference(answer.closest, expected[i].closest, part.scale);
        if (!is_same(answer.signed_distance(part.scale), expected[i].distance))
            found = "the signed distance";
        if ((answer.method() == SignMethod::on_surface) !=
            (expected[i].method == SignMethod::on_surface))
            found = "whether it is on the surface";
        if (!found.empty()) return answer_differs(found, "point", rows.first + i);
    }
    return {};
}

} // namespace proxima
