#include "base/fixed_stack.h"
#include "base/text.h"
#include "proxima/scene.h"
#include "query/scene/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

enum class BoxSide : std::uint8_t { outside, cut, inside };

/// A volume's planes about a scene. Boxes near a plane count as cut by it, by more than planes in an instance's
/// coordinates are rounded: 16 u (|n|_1 (|x| + |t|) + |d|), |t| part of the box.
class ScenePlanes {
public:
    ScenePlanes(const SceneParts& scene, const ViewVolume& volume)
        : scene_(scene), planes_(volume.planes())
    {
        slacks_.reserve(planes_.size());
        for (const ViewPlane& plane : planes_) {
            slacks_.push_back(
                scene_roundoff * (plane.normal.lpNorm<1>() * scene.reach + std::abs(plane.offset)) +
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

    /// Calls visit(row, side) for rows that are not outside, by the tree's order.
    template <class Visit>
    void walk(std::uint32_t layers, const Visit& visit) const
    {
        if (scene_.tree_rows() == 0) return;
        const IndexParts& tree = scene_.tree.parts();
        FixedStack<std::uint32_t, 7 * IndexParts::max_levels + 1> pending;
        pending.push(tree.root());
        while (!pending.empty()) {
            const std::uint32_t at = pending.pop();
            const IndexBlock& block = tree.blocks()[at & ~index_leaf_bit];
            if ((at & index_leaf_bit) == 0) {
                for (std::size_t slot = 0; slot < 8; ++slot)
                    if (block.node.has_child(slot) &&
                        side_of(box_of(tree, block.node, slot)) != BoxSide::outside)
                        pending.push(block.node.children[slot]);
                continue;
            }
            for (std::uint32_t i = 0; i < block.leaf.count; ++i) {
                const SceneRow& row = scene_.rows[block.leaf.first_row + i];
                if ((row.layers & layers) == 0) continue;
                if (const BoxSide side = side_of(row.box); side != BoxSide::outside)
                    visit(block.leaf.first_row + i, side);
            }
        }
    }

    /// The volume in an instance's coordinates. Error invalid_argument: not finite.
    [[nodiscard]] Result<ViewVolume> in_instance(std::uint32_t row) const
    {
        std::vector<ViewPlane> planes;
        planes.reserve(planes_.size());
        for (const ViewPlane& plane : planes_)
            planes.push_back(to_instance(scene_.poses[row], plane));
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

} // namespace

Result<std::vector<InstanceId>> visible_instances(const Scene& scene, const ViewVolume& volume,
                                                  const SceneCullOptions& options)
{
    const SceneParts& parts = scene.parts();
    const ScenePlanes planes(parts, volume);
    std::vector<InstanceId> visible;
    std::optional<Error> error;
    planes.walk(options.layers, [&](std::uint32_t row, BoxSide side) {
        bool seen = side == BoxSide::inside;
        if (!seen && !error) {
            const auto own = planes.in_instance(row);
            if (!own) {
                error = own.error();
            } else {
                visit_visible(parts.index(parts.rows[row]), *own, options.mode,
                              [&](TriangleRange /*range*/) {
                                  seen = true;
                                  return Flow::stop;
                              });
            }
        }
        if (seen) visible.push_back(InstanceId{parts.rows[row].instance});
    });
    if (error) return tl::unexpected(*error);
    std::ranges::sort(visible);
    return visible;
}

Result<std::vector<InstanceRange>> visible_ranges(const Scene& scene, const ViewVolume& volume,
                                                  const SceneCullOptions& options)
{
    const SceneParts& parts = scene.parts();
    const ScenePlanes planes(parts, volume);
    std::vector<InstanceRange> visible;
    std::optional<Error> error;
    planes.walk(options.layers, [&](std::uint32_t row, BoxSide side) {
        const InstanceId id{parts.rows[row].instance};
        const MeshIndex& index = parts.index(parts.rows[row]);
        if (side == BoxSide::inside) {
            visible.push_back({id, {0, index.triangle_count()}});
        } else if (!error) {
            const auto own = planes.in_instance(row);
            if (!own) {
                error = own.error();
                return;
            }
            visit_visible(index, *own, options.mode, [&](TriangleRange range) {
                visible.push_back({id, range});
                return Flow::proceed;
            });
        }
    });
    if (error) return tl::unexpected(*error);
    std::ranges::sort(visible, [](const InstanceRange& a, const InstanceRange& b) {
        return a.instance < b.instance || (a.instance == b.instance && a.rows.first < b.rows.first);
    });
    return visible;
}

} // namespace proxima
