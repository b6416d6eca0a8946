#include "query/closest/check_answers.h"

#include "base/progress.h"
#include "base/text.h"
#include "geometry/length.h"
#include "index/check_work.h"
#include "query/closest/brute_force.h"

#include <array>
#include <cmath>

namespace proxima {

namespace {

/// What rounding may make of a distance from a point.
class Rounding {
public:
    explicit Rounding(const TriangleMesh& mesh) noexcept
    {
        const Box box = bounding_box(mesh);
        middle_ = box.center();
        size_ = length_of(box.extent()) +
                1e-3 * box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
    }
    [[nodiscard]] double of(const Vec3& p) const noexcept
    {
        return 1e-12 * (size_ + length_of(p - middle_));
    }

private:
    Vec3 middle_;
    double size_;
};

/// How far the answer is, also where no double holds the square.
double distance_of(const ClosestFeature& answer, const Vec3& p) noexcept
{
    const bool holds_square = answer.squared_distance > 1e-280 && answer.squared_distance < 1e300;
    return holds_square ? std::sqrt(answer.squared_distance) : length_of(p - answer.point);
}

bool is_right(const ClosestFeature& found, const ClosestFeature& right, const Vec3& p,
              double rounding)
{
    return std::abs(distance_of(found, p) - distance_of(right, p)) <= rounding &&
           (found.feature != right.feature || found.triangle == right.triangle);
}

} // namespace

std::string text_of(const ClosestFeature& answer)
{
    constexpr std::array names = {"vertex ", "edge ", "face "};
    return concat(names[static_cast<std::size_t>(answer.feature.kind)], answer.feature.id,
                  " of triangle ", to_index(answer.triangle), " at ",
                  std::sqrt(answer.squared_distance));
}

Status check_answers(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology,
                     std::span<const Vec3> points, const CheckAnswersOptions& options)
{
    begin_stage(options.execution.progress, "asking every triangle", points.size());
    const Rounding rounding(mesh);
    const CheckWork work(options.execution);
    return work.run(points.size(), [&](std::size_t i) -> Status {
        const Vec3& p = points[i];
        const ClosestFeature found = closest_feature(index, p).value_or(no_closest_feature());
        const ClosestFeature right = closest_feature_by_brute_force(mesh, topology, p);
        advance_stage(options.execution.progress, 1);
        if (is_right(found, right, p, rounding.of(p))) return {};
        return fail(
            ErrorCode::broken_invariant,
            concat("the index answers ", text_of(found), ", the closest is ", text_of(right)),
            concat("point ", p.x(), " ", p.y(), " ", p.z()));
    });
}

} // namespace proxima
