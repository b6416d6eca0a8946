#include "proxima/distance_field.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "index/index_parts.h"
#include "index/signs/sign_geometry.h"
#include "index/signs/sign_parts.h"
#include "query/closest/describe_closest.h"
#include "query/closest/on_feature.h"
#include "query/closest/winding_side.h"
#include "query/field/open_sides.h"
#include "query/field/search_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace proxima {

namespace {

/// How far points are searched for: the band, or what distances of points on the surface may be wrong by.
double reach_of(const IndexParts& index, const PointGrid& grid, double band) noexcept
{
    return std::max(band, on_feature_rounding * largest_coordinate(index, grid));
}

/// Whether the sides of an open mesh's blocks are worth what OpenSides costs.
bool asks_open_sides(const IndexParts& index, const PointGrid& grid) noexcept
{
    constexpr std::uint64_t triangles_per_point = 8;
    return !index.signs()->arrays().is_closed() &&
           grid.point_count() > index.triangle_count() / triangles_per_point;
}

/// Writes what searches of blocks find.
class FieldWriter {
public:
    FieldWriter(const MeshIndex& index, const PointGrid& grid, const FieldOutputs& outputs,
                const FieldOptions& options)
        : index_(index), parts_(index.parts()), grid_(grid), to_(outputs), band_(options.band),
          reach_(reach_of(index.parts(), grid, options.band)), progress_(options.execution.progress)
    {
        if (asks_open_sides(parts_, grid)) open_.emplace(parts_);
    }

    void write(const GridAnswers& answers) const
    {
        const auto is_inside = [&](const Vec3& p) {
            return answers.inside ? *answers.inside : is_inside_by_winding(parts_, p);
        };
        const bool is_plain = answers.is_clear && to_.gradients.empty() && to_.methods.empty();
        const RowDistance* found = answers.found.data();
        for_each_point(answers.block, [&](std::size_t at, const Vec3& p) {
            const double distance = answers.found.empty() ? HUGE_VAL : distance_of(*found);
            if (!(distance <= (is_plain ? band_ : reach_))) {
                put_beyond(at, is_inside(p));
            } else if (is_plain && distance > 0) {
                to_.distances[at] = is_inside(p) ? -distance : distance;
            } else {
                // Not nothing: the index has signs and the point is finite.
                put_answer(at, p, *sign_of(index_, describe_closest(parts_, *found), p));
            }
            if (!answers.found.empty()) ++found;
        });
    }

    [[nodiscard]] bool has_open_sides() const noexcept { return open_.has_value(); }

    /// Whether a ball that the surface does not enter is inside: one point tells of a closed mesh.
    /// Nothing where that is not known.
    [[nodiscard]] std::optional<bool> side_of(const ClearBall& ball) const
    {
        if (open_) return open_->side_of(ball);
        if (!parts_.signs()->arrays().is_closed()) return std::nullopt;
        return is_inside_by_winding(parts_, ball.middle);
    }

    /// By single queries.
    void write_one_by_one(const GridBlock& block) const
    {
        for_each_point(block, [&](std::size_t at, const Vec3& p) {
            put_answer(at, p, *signed_distance(index_, p));
        });
    }

    /// Nothing farther need be searched for.
    [[nodiscard]] double reach() const noexcept { return reach_; }

private:
    /// Calls visit(position, point) with x running fastest. Ends where the work shall stop: a winding
    /// number may take milliseconds.
    template <class Visit>
    void for_each_point(const GridBlock& block, const Visit& visit) const
    {
        const auto [i, j, k] = block.first;
        for (std::uint32_t z = k; z < k + block.size[2]; ++z) {
            for (std::uint32_t y = j; y < j + block.size[1]; ++y) {
                if (is_cancelled(progress_)) return;
                const std::size_t row = grid_.position(i, y, z);
                for (std::uint32_t x = 0; x < block.size[0]; ++x)
                    visit(row + x, grid_.point(i + x, y, z));
            }
        }
    }

    [[nodiscard]] double distance_of(const RowDistance& found) const noexcept
    {
        return std::sqrt(row_scale_of(parts_).unscale_squared(found.squared));
    }

    void put_beyond(std::size_t at, bool inside) const
    {
        put(at, inside ? -band_ : band_, Vec3::Zero(), SignMethod::winding_number);
    }

    void put_answer(std::size_t at, const Vec3& p, const SignedDistance& answer) const
    {
        if (std::abs(answer.distance) > band_) return put_beyond(at, std::signbit(answer.distance));
        put(at, answer.distance,
            to_.gradients.empty() ? Vec3(Vec3::Zero()) : gradient_of(answer, p), answer.method);
    }

    [[nodiscard]] Vec3 gradient_of(const SignedDistance& answer, const Vec3& p) const
    {
        const ClosestFeature& closest = answer.closest;
        const Triangle triangle =
            parts_.triangle(parts_.signs()->arrays().rows[to_index(closest.triangle)]);
        if (answer.distance == 0) return unit_normal_of(triangle);
        const double sign = answer.distance > 0 ? 1 : -1;
        if (closest.feature.kind == FeatureKind::face) {
            const int side = orient3d(triangle[0], triangle[1], triangle[2], p);
            return (side < 0 ? -sign : sign) * unit_normal_of(triangle);
        }
        // Of differences alone: the closest point itself is rounded.
        Vec3 away = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k)
            away += closest.barycentric[k] * (p - triangle[static_cast<int>(k)]);
        return sign * unit_of(away);
    }

    void put(std::size_t at, double distance, const Vec3& gradient, SignMethod method) const
    {
        if (!to_.distances.empty()) to_.distances[at] = distance;
        if (!to_.gradients.empty()) to_.gradients[at] = gradient;
        if (!to_.methods.empty()) to_.methods[at] = method;
    }

    const MeshIndex& index_;
    const IndexParts& parts_;
    const PointGrid& grid_;
    const FieldOutputs& to_;
    double band_;
    double reach_;
    Progress* progress_;
    std::optional<OpenSides> open_;
};

/// Whether squares of the mesh's lengths, and of much smaller ones, are well within the doubles.
bool has_squares(const IndexParts& index) noexcept
{
    return index.scale() > 0x1p-400 && index.scale() < 0x1p400;
}

Status check_arguments(const MeshIndex& index, const PointGrid& grid, const FieldOutputs& outputs,
                       double band)
{
    const auto bad = [](std::string what, const char* where) {
        return fail(ErrorCode::invalid_argument, std::move(what), where);
    };
    if (!index.has_signs()) return bad("the index has no signs: call with_signs first", "index");
    if (std::ranges::find(grid.size, 0U) != grid.size.end())
        return bad("a grid without points", "grid");
    const double points = static_cast<double>(grid.size[0]) * grid.size[1] * grid.size[2];
    if (points > static_cast<double>(max_grid_points)) return bad("more than 2^40 points", "grid");
    if (!(grid.spacing > 0)) return bad("the spacing is no positive number", "grid");
    const Vec3 last = grid.point(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
    if (!grid.origin.allFinite() || !(last - grid.origin).allFinite())
        return bad("a point of the grid is not finite", "grid");
    if (!(band > 0)) return bad("the band is no positive number", "band");
    for (const std::size_t size :
         {outputs.distances.size(), outputs.gradients.size(), outputs.methods.size()}) {
        if (size != 0 && size != grid.point_count()) {
            return bad(concat("a list of ", size, " answers, but the grid has ", grid.point_count(),
                              " points"),
                       "outputs");
        }
    }
    return {};
}

Status check_field_budget(const IndexParts& index, const PointGrid& grid,
                          const Execution& execution)
{
    if (!asks_open_sides(index, grid)) return {};
    return check_budget(execution.budget, OpenSides::bytes(index), "the border of an open mesh",
                        "raise the budget");
}

} // namespace

Status distance_field(const MeshIndex& index, const PointGrid& grid, const FieldOutputs& outputs,
                      const FieldOptions& options)
{
    if (Status status = check_arguments(index, grid, outputs, options.band); !status) return status;
    if (outputs.distances.empty() && outputs.gradients.empty() && outputs.methods.empty())
        return {};
    if (Status status = check_field_budget(index.parts(), grid, options.execution); !status)
        return status;
    const FieldWriter writer(index, grid, outputs, options);
    std::array<std::size_t, 3> blocks{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        blocks[axis] = chunk_count(grid.size[axis], grid_block_side);
    Progress* const progress = options.execution.progress;
    begin_stage(progress, "distance field", grid.point_count());
    parallel_for(
        blocks[0] * blocks[1] * blocks[2], options.execution.threads, [&](std::size_t number) {
            if (is_cancelled(progress)) return;
            const std::array<std::size_t, 3> place = {
                number % blocks[0], number / blocks[0] % blocks[1], number / blocks[0] / blocks[1]};
            GridBlock block;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                block.first[axis] = static_cast<std::uint32_t>(place[axis]) * grid_block_side;
                block.size[axis] = std::min(grid_block_side, grid.size[axis] - block.first[axis]);
            }
            if (has_squares(index.parts())) {
                const auto side_of = [&](const ClearBall& ball) { return writer.side_of(ball); };
                const auto take = [&](const GridAnswers& answers) { writer.write(answers); };
                search_grid(index.parts(), grid, block,
                            {writer.reach(), writer.has_open_sides(), side_of, take, progress});
            } else {
                writer.write_one_by_one(block);
            }
            advance_stage(progress, std::size_t{block.size[0]} * block.size[1] * block.size[2]);
        });
    if (is_cancelled(progress)) return cancelled("filling the distance field");
    return {};
}

} // namespace proxima
