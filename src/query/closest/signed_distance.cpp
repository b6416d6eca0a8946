#include "proxima/signed_distance.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "index/crossings.h"
#include "index/index_parts.h"
#include "index/signs/sign_geometry.h"
#include "index/signs/sign_parts.h"
#include "proxima/mesh_index.h"
#include "query/batch_size.h"
#include "query/closest/find_closest.h"
#include "query/closest/on_feature.h"
#include "query/closest/winding_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t least_signs_per_task = 4096;
constexpr std::size_t most_signs_per_task = 65536;
constexpr std::size_t signs_per_report = 64; // winding numbers may take milliseconds

/// A pseudonormal as the sum of unit normals may be off by this, in length.
constexpr double normal_error = 1e-10;
/// Distances are right to less than 2^-50 of themselves. A feature whose triangles are no flatter
/// than 2^-30 of the distance may be named for one so near to it that the direction to the point is
/// off by less than this.
constexpr double least_part = 0x1p-30;
constexpr double tie_error = 0x1p-18;
/// Nor does a face's foot tell that is nearer to its border than this: the face beyond it may be
/// as near.
constexpr double least_inset = 0x1p-40;

std::optional<bool> by_height(double height, double doubt) noexcept
{
    if (!(std::abs(height) > doubt)) return std::nullopt;
    return height < 0;
}

/// The sign at one point, told by its closest feature and the rows of its triangles.
template <class Scalar>
class SignQuery {
public:
    SignQuery(const IndexParts& index, std::span<const TriangleRow<Scalar>> rows,
              const ClosestFeature& closest, const Vec3& p) noexcept
        : index_(index), signs_(index.signs()->arrays()), rows_(rows), closest_(closest), p_(p),
          distance_(std::sqrt(closest.squared_distance)),
          row_(signs_.rows[to_index(closest.triangle)])
    {}

    [[nodiscard]] SignedDistance answer() const noexcept
    {
        SignedDistance result{distance_, SignMethod::on_surface, closest_};
        if (is_on_feature(rows_[row_], closest_.feature, distance_, p_)) {
            result.distance = 0;
            return result;
        }
        const auto inside = is_inside_locally();
        const bool beyond = !signs_.bounds.contains(p_);
        result.method =
            inside && !(beyond && *inside) ? SignMethod::pseudonormal : SignMethod::winding_number;
        if (beyond) return result;
        // Where squares overflow, whatever mesh there is is a dot.
        if (inside ? *inside : std::isfinite(distance_) && is_inside_by_winding(index_, p_))
            result.distance = -distance_;
        return result;
    }

private:
    [[nodiscard]] Triangle triangle(std::uint32_t row) const noexcept
    {
        return rows_[row].corners();
    }

    /// On which side of the closest triangle's plane p is, exactly.
    [[nodiscard]] int side_of_face() const noexcept
    {
        const Triangle face = triangle(row_);
        return orient3d(face[0], face[1], face[2], p_);
    }

    /// Calls visit(row) for the proper triangles of the closest edge, by ascending id.
    template <class Visit>
    void visit_edge(const Visit& visit) const noexcept
    {
        const std::uint32_t word = signs_.edges[closest_.feature.id];
        if ((word & edge_list_bit) == 0) {
            visit(row_);
            visit(word);
            return;
        }
        const std::uint32_t first = word & ~edge_list_bit;
        for (const std::uint32_t row :
             signs_.edge_lists.subspan(first + 1, signs_.edge_lists[first]))
            visit(row);
    }

    // Whether p is inside, told by a feature whose triangles separate; nothing in doubt.

    [[nodiscard]] std::optional<bool> is_behind_face() const noexcept
    {
        const int side = side_of_face();
        return side == 0 ? std::nullopt : std::optional(side < 0);
    }

    [[nodiscard]] std::optional<bool> is_behind_edge() const noexcept
    {
        Vec3 normal = Vec3::Zero();
        visit_edge([&](std::uint32_t row) { normal += unit_normal_of(triangle(row)); });
        // The normal is across the edge, so any of its points will do: the nearer end rounds less.
        const EdgeEnds ends = edge_ends(rows_[row_], closest_.feature.id);
        const Vec3 from_low = p_ - ends.low;
        const Vec3 from_high = p_ - ends.high;
        const Vec3& from = from_low.squaredNorm() < from_high.squaredNorm() ? from_low : from_high;
        constexpr double rounding = 0x1p-48;
        return by_height(normal.dot(from), (normal_error + tie_error * normal.norm()) * distance_ +
                                               rounding * from.norm());
    }

    [[nodiscard]] std::optional<bool> is_behind_vertex() const noexcept
    {
        const std::uint32_t vertex = closest_.feature.id;
        const Vec3 normal(signs_.vertices[vertex].normal.data());
        const TriangleRow<Scalar>& row = rows_[row_];
        const Vec3 position = row.corner(static_cast<int>(corner_of(row, vertex)));
        return by_height(normal.dot(p_ - position), (normal_error + tie_error) * distance_);
    }

    [[nodiscard]] SurfaceSides sides() const noexcept
    {
        if (!signs_.is_closed()) return SurfaceSides::doubtful;
        if (closest_.feature.kind == FeatureKind::vertex)
            return signs_.vertex_sides[closest_.feature.id];
        if (closest_.feature.kind == FeatureKind::face) return signs_.sides[row_];
        CommonSides common;
        visit_edge([&](std::uint32_t row) { common.add(signs_.sides[row]); });
        return common.result();
    }

    /// The least height of the triangles about the feature. \pre its sides are known
    [[nodiscard]] double height() const noexcept
    {
        if (closest_.feature.kind == FeatureKind::vertex)
            return signs_.vertices[closest_.feature.id].least_height;
        double height = std::numeric_limits<double>::infinity();
        const auto add = [&](std::uint32_t row) {
            height = std::min(height, height_of(triangle(row), signs_.winding.unit));
        };
        if (closest_.feature.kind == FeatureKind::edge) {
            visit_edge(add);
        } else {
            add(row_);
        }
        return height;
    }

    /// Whether the feature is large enough, seen from its distance, to be told from its neighbours
    /// and they from what lies behind them.
    [[nodiscard]] bool is_told_apart() const noexcept
    {
        const auto large = [&](double height) {
            if (!(height > least_part * distance_)) return false;
            return closest_.feature.kind != FeatureKind::face ||
                   *std::ranges::min_element(closest_.barycentric) * height >
                       least_inset * distance_;
        };
        return large(signs_.least_height) || large(height());
    }

    /// Whether p is inside by what the feature is known of; nothing in doubt.
    [[nodiscard]] std::optional<bool> is_inside_locally() const noexcept
    {
        const SurfaceSides known = sides();
        if (known == SurfaceSides::doubtful || !is_told_apart()) return std::nullopt;
        if (known != SurfaceSides::separates) return known == SurfaceSides::inside_both;
        switch (closest_.feature.kind) {
        case FeatureKind::vertex:
            return is_behind_vertex();
        case FeatureKind::edge:
            return is_behind_edge();
        case FeatureKind::face:
            break;
        }
        return is_behind_face();
    }

    const IndexParts& index_;
    const SignArrays& signs_;
    std::span<const TriangleRow<Scalar>> rows_;
    const ClosestFeature& closest_;
    const Vec3& p_;
    double distance_;
    std::uint32_t row_; ///< of the closest triangle
};

/// \pre the index has signs, closest was found
SignedDistance answer_of(const IndexParts& index, const ClosestFeature& closest,
                         const Vec3& p) noexcept
{
    return index.double_rows().empty() ? SignQuery(index, index.float_rows(), closest, p).answer()
                                       : SignQuery(index, index.double_rows(), closest, p).answer();
}

} // namespace

bool is_inside_by_winding(const IndexParts& index, const Vec3& p) noexcept
{
    const SignArrays& signs = index.signs()->arrays();
    if (!signs.bounds.contains(p)) return false;
    if (signs.is_closed()) {
        int windings = 0;
        visit_crossings(index, signs.bounds, {}, p,
                        [&](std::uint32_t, int crossing) { windings += crossing; });
        return windings > 0;
    }
    return is_inside(
        signs.winding, [&](std::uint32_t row) { return index.triangle(row); }, p);
}

bool has_local_signs(const MeshIndex& index) noexcept
{
    return index.has_signs() && index.parts().signs()->is_local();
}

std::optional<SignedDistance> sign_of(const MeshIndex& index, const ClosestFeature& closest,
                                      const Vec3& p) noexcept
{
    if (!index.has_signs() || !is_found(closest)) return std::nullopt;
    return answer_of(index.parts(), closest, p);
}

std::optional<SignedDistance> signed_distance(const MeshIndex& index, const Vec3& p) noexcept
{
    if (!index.has_signs()) return std::nullopt;
    const auto closest = closest_feature(index, p);
    if (!closest) return std::nullopt;
    return answer_of(index.parts(), *closest, p);
}

Status signed_distances(const MeshIndex& index, std::span<const Vec3> points,
                        const SignedOutputs& outputs, const BatchOptions& options)
{
    if (!index.has_signs()) {
        return fail(ErrorCode::invalid_argument, "the index has no signs: call with_signs first",
                    "index");
    }
    for (const std::size_t size :
         {outputs.distances.size(), outputs.methods.size(), outputs.answers.size()}) {
        if (size == 0) continue;
        if (Status status = check_batch_size(size, points.size(), "points"); !status) return status;
    }
    const auto bad =
        std::ranges::find_if(points, [](const Vec3& point) { return !point.allFinite(); });
    if (bad != points.end()) {
        return fail(ErrorCode::invalid_argument,
                    concat("point ", bad - points.begin(), " is not finite: leave it out"),
                    "points");
    }
    const std::size_t share =
        points.size() / static_cast<std::size_t>(thread_count(options.execution.threads)) + 1;
    const std::size_t chunk = std::clamp(share, least_signs_per_task, most_signs_per_task);
    Progress* const progress = options.execution.progress;
    begin_stage(progress, "signed distances", 2 * points.size());
    parallel_chunks(
        points.size(), chunk, options.execution.threads, [&](std::size_t first, std::size_t end) {
            if (is_cancelled(progress)) return;
            const auto own = points.subspan(first, end - first);
            std::vector<ClosestFeature> closest(own.size());
            find_closest_features(index, own, closest, options.order, progress);
            if (is_cancelled(progress)) return;
            StageSteps steps(progress, signs_per_report);
            for (std::size_t k = 0; k < own.size(); ++k) {
                if (!steps.done(1)) return;
                const SignedDistance answer = answer_of(index.parts(), closest[k], own[k]);
                if (!outputs.distances.empty()) outputs.distances[first + k] = answer.distance;
                if (!outputs.methods.empty()) outputs.methods[first + k] = answer.method;
                if (!outputs.answers.empty()) outputs.answers[first + k] = answer;
            }
            steps.finish();
        });
    if (is_cancelled(progress)) return cancelled("computing signed distances");
    return {};
}

std::string_view name_of(SignMethod method) noexcept
{
    switch (method) {
    case SignMethod::on_surface:
        return "on_surface";
    case SignMethod::pseudonormal:
        return "pseudonormal";
    case SignMethod::winding_number:
        break;
    }
    return "winding_number";
}

} // namespace proxima
