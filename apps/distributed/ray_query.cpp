#include "distributed/ray_query.h"

#include "cli/row_text.h"
#include "distributed/oracle.h"

#include <array>

namespace proxima {

namespace {

std::vector<Ray> rays_of(const TableRows& rows)
{
    std::vector<Ray> rays;
    rays.reserve(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rays.push_back(ray_of_row(rows[i]));
    return rays;
}

/// What of an answer differs from the library's; empty where nothing does.
std::string_view difference(const HitOfWhole& answer, const std::optional<RayHit>& expected)
{
    if (answer.is_hit() != expected.has_value()) return "whether there is a hit";
    if (!expected) return {};
    if (!is_same(answer.t, expected->t)) return "t";
    if (answer.triangle != to_index(expected->triangle)) return "the triangle";
    if (!is_same(answer.u, expected->u) || !is_same(answer.v, expected->v)) return "u or v";
    return {};
}

} // namespace

Result<std::vector<HitOfWhole>> RayQuery::answer(const MeshPart& part, const TableRows& rows,
                                                 World& world)
{
    return hits_over_ranks(part, rays_of(rows), world);
}

void RayQuery::append(const MeshPart& /*part*/, std::uint64_t index, const Answer& answer,
                      AnswerFormat format, fmt::memory_buffer& text)
{
    const double triangle = answer.is_hit() ? static_cast<double>(answer.triangle) : -1;
    append_row(
        text, format,
        std::array<double, 5>{static_cast<double>(index), answer.t, triangle, answer.u, answer.v});
}

Status RayQuery::verify(const MeshIndex& oracle, const MeshPart& /*part*/, const TableRows& rows,
                        std::span<const Answer> answers)
{
    const std::vector<Ray> rays = rays_of(rows);
    std::vector<std::optional<RayHit>> expected(rays.size());
    Status status = closest_hits(oracle, rays, expected, {.execution = {.threads = {1}}});
    if (!status) return status;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::string_view found = difference(answers[i], expected[i]);
        if (!found.empty()) return answer_differs(found, "ray", rows.first + i);
    }
    return {};
}

} // namespace proxima
