#include "base/fixed_stack.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/scene.h"
#include "query/scene/found_lists.h"
#include "query/scene/scene_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t culled_per_task = 64;

enum class BoxSide : std::uint8_t { outside, cut, inside };

/// A row of the scene, and on which side of a volume its box is.
struct RowSide {
    std::uint32_t instance;
    std::uint32_t row;
    BoxSide side;
};

/// A volume's planes about a scene. Boxes near a plane count as cut by it, by more than planes in an instance's
/// coordinates are rounded: 16 u (|n|_1 (|x| + |t|) + |d|), |t| part of the box. Where |d| is more than twice |n|_1 |x|, d alone tells
/// the side, by more than half of itself, which no rounding reaches; so slacks need no |d|.
class ScenePlanes {
public:
    ScenePlanes(const SceneParts& scene, const ViewVolume& volume)
        : scene_(scene), planes_(volume.planes())
    {
        slacks_.reserve(planes_.size());
        for (const ViewPlane& plane : planes_) {
            slacks_.push_back(scene_roundoff * (plane.normal.lpNorm<1>() * scene.reach) +
                              std::numeric_limits<double>::min());
        }
    }

    [[nodiscard]] BoxSide side_of(const Box& box) const noexcept
    {
        BoxSide side = BoxSide::inside;
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            double least = planes_[i].offset;
            double most = planes_[i].offset;
            for (int axis = 0; axis < 3; ++axis) {
                const double n = planes_[i].normal[axis];
                least += n * (n >= 0 ? box.lower[axis] : box.upper[axis]);
                most += n * (n >= 0 ? box.upper[axis] : box.lower[axis]);
            }
            if (most < -slacks_[i]) return BoxSide::outside;
            if (!(least > slacks_[i])) side = BoxSide::cut;
        }
        return side;
    }

    /// Rows that are not outside, ascending by instance.
    [[nodiscard]] std::vector<RowSide> rows_in_view(std::uint32_t layers) const
    {
        std::vector<RowSide> found;
        if (scene_.tree_rows() == 0) return found;
        const IndexParts& tree = scene_.tree.parts();
        FixedStack<std::uint32_t, 7 * IndexParts::max_levels + 1> pending;
        pending.push(tree.root());
        while (!pending.empty()) {
            const std::uint32_t at = pending.pop();
            const IndexBlock& block = tree.blocks()[at & ~index_leaf_bit];
            if ((at & index_leaf_bit) == 0) {
                for (std::size_t slot = 0; slot < 8; ++slot) {
                    if (block.node.has_child(slot) &&
                        side_of(box_of(tree, block.node, slot)) != BoxSide::outside)
                        pending.push(block.node.children[slot]);
                }
                continue;
            }
            for (std::uint32_t i = 0; i < block.leaf.count; ++i) {
                const SceneRow& row = scene_.rows[block.leaf.first_row + i];
                if ((row.layers & layers) == 0) continue;
                if (const BoxSide side = side_of(row.box); side != BoxSide::outside)
                    found.push_back({row.instance, block.leaf.first_row + i, side});
            }
        }
        std::ranges::sort(found, {}, &RowSide::instance);
        return found;
    }

    /// The volume in an instance's coordinates. Error invalid_argument: not finite.
    [[nodiscard]] Result<ViewVolume> in_instance(std::uint32_t row) const
    {
        std::vector<ViewPlane> planes(planes_.begin(), planes_.end());
        for (ViewPlane& plane : planes) plane = to_instance(scene_.poses[row], plane);
        auto volume = make_view_volume(planes);
        if (volume) return volume;
        return fail(volume.error().code, volume.error().message,
                    concat("instance ", scene_.rows[row].instance));
    }

private:
    /// In the scene's coordinates. Planes lie outward by more than it is rounded.
    static Box box_of(const IndexParts& tree, const IndexNode& node, std::size_t slot) noexcept
    {
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            box.lower[k] = node.plane(axis, slot) * tree.unscale() + tree.center()[k];
            box.upper[k] = node.plane(axis, 8 + slot) * tree.unscale() + tree.center()[k];
        }
        return box;
    }

    const SceneParts& scene_;
    std::span<const ViewPlane> planes_;
    std::vector<double> slacks_;
};

/// What visit(row, planes, add) adds for all rows in view, ascending by instance. Errors: that of the lowest
/// instance, budget_exceeded, cancelled.
template <class Found, class Visit>
Result<std::vector<Found>> cull_scene(const SceneParts& scene, const ViewVolume& volume,
                                      const SceneCullOptions& options, const Visit& visit)
{
    const Execution& execution = options.execution;
    const ScenePlanes planes(scene, volume);
    const std::vector<RowSide> rows = planes.rows_in_view(options.layers);
    begin_stage(execution.progress, "culling instances", rows.size());
    const std::size_t tasks = chunk_count(rows.size(), culled_per_task);
    FoundLists<Found> found(tasks, execution.budget, rows.capacity() * sizeof(RowSide));
    std::vector<std::optional<Error>> errors(tasks);
    parallel_chunks(rows.size(), culled_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        const std::size_t task = first / culled_per_task;
                        const auto add = [&](const Found& one) { found.add(task, one); };
                        for (std::size_t i = first; i < end; ++i) {
                            if (is_cancelled(execution.progress) || found.is_over()) return;
                            if (Status status = visit(rows[i], planes, add); !status) {
                                errors[task] = status.error();
                                return;
                            }
                        }
                        advance_stage(execution.progress, end - first);
                    });
    if (is_cancelled(execution.progress)) return cancelled("culling instances");
    for (const std::optional<Error>& error : errors)
        if (error) return tl::unexpected(*error);
    if (found.is_over()) {
        return fail(ErrorCode::budget_exceeded,
                    concat("there are more than ", found.most(),
                           " answers, which the memory budget does not hold; take fewer instances "
                           "or layers, or raise the budget"));
    }
    return found.take();
}

} // namespace

Result<std::vector<InstanceId>> visible_instances(const Scene& scene, const ViewVolume& volume,
                                                  const SceneCullOptions& options)
{
    const SceneParts& parts = scene.parts();
    return cull_scene<InstanceId>(
        parts, volume, options,
        [&](const RowSide& at, const ScenePlanes& planes, const auto& add) -> Status {
            bool seen = at.side == BoxSide::inside;
            if (!seen) {
                const auto own = planes.in_instance(at.row);
                if (!own) return tl::unexpected(own.error());
                visit_visible(parts.index(parts.rows[at.row]), *own, options.mode,
                              [&](TriangleRange /*range*/) {
                                  seen = true;
                                  return Flow::stop;
                              });
            }
            if (seen) add(InstanceId{at.instance});
            return {};
        });
}

Result<std::vector<InstanceRange>> visible_ranges(const Scene& scene, const ViewVolume& volume,
                                                  const SceneCullOptions& options)
{
    const SceneParts& parts = scene.parts();
    return cull_scene<InstanceRange>(
        parts, volume, options,
        [&](const RowSide& at, const ScenePlanes& planes, const auto& add) -> Status {
            const InstanceId id{at.instance};
            const MeshIndex& index = parts.index(parts.rows[at.row]);
            if (at.side == BoxSide::inside) {
                add(InstanceRange{id, {0, index.triangle_count()}});
                return {};
            }
            const auto own = planes.in_instance(at.row);
            if (!own) return tl::unexpected(own.error());
            visit_visible(index, *own, options.mode, [&](TriangleRange range) {
                add(InstanceRange{id, range});
                return Flow::proceed;
            });
            return {};
        });
}

} // namespace proxima
