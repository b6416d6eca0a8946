// A ray on its way through a scene's tree: the nearest box first as far as depth first allows. Nodes are
// asked in floats (walk_scene.h), rows in doubles; from where floats are too coarse all is asked in doubles.
//
// In doubles planes lie further out by e, the query's part of what rounding moves (scene_parts.h), by more than
// (plane - o) / d is rounded, and by what putting small components of d away from zero moves the ray:
// by 2^-69 of |s d|. A hit's t is that of its triangle to within 2^-21 of the triangle's
// extent (ray_triangle-inl.h): by so much earlier and later than a box's may it come.
#pragma once

#include "base/fixed_stack.h"
#include "proxima/geometry.h"
#include "query/scene/scene_parts.h"
#include "query/scene/walk_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace proxima {

class SceneRay {
public:
    SceneRay(const SceneParts& scene, const Ray& ray) noexcept : scene_(scene), ray_(ray)
    {
        const IndexParts& tree = scene.tree.parts();
        const double size = ray.direction.cwiseAbs().maxCoeff();
        const double distance = ray.origin.cwiseAbs().maxCoeff();
        const double reach = distance + scene.reach;
        const double error = 4 * scene_roundoff * reach;
        is_ordinary_ = size > least_size && size < most_size && reach < most_size &&
                       (reach + size) * tree.scale() < most_in_frame;
        suits_floats_ = is_ordinary_ && error * tree.scale() <= scene_tree_margin;
        for (int axis = 0; axis < 3; ++axis) {
            double along = ray.direction[axis];
            if (!(std::abs(along) >= size * smallest_part))
                along = std::copysign(size * smallest_part, along);
            const double inverse = 1 / along;
            const auto k = static_cast<std::size_t>(axis);
            is_negative_[k] = along < 0;
            world_.inverse[k] = inverse;
            world_.near[k] = ray.origin[axis] + std::copysign(error, along);
            world_.far[k] = ray.origin[axis] - std::copysign(error, along);
            // Planes x of the tree are at c + x / s.
            const double center = tree.center()[axis];
            frame_.inverse[k] = tree.unscale() * inverse;
            frame_.near[k] = (world_.near[k] - center) * tree.scale();
            frame_.far[k] = (world_.far[k] - center) * tree.scale();
        }
        slack_ = (0x1p-18 * scene.largest_extent + error) / size;
        set_most(ray.t_max);
        least_ = ray.t_min - slack_;
    }

    /// No hit behind is wanted.
    void set_most(double t) noexcept { most_ = t + slack_; }

    [[nodiscard]] const Ray& ray() const noexcept { return ray_; }

    /// Calls visit(row) for rows whose boxes the ray meets, until it returns Flow::stop.
    template <class Visit>
    void walk(std::uint32_t layers, const Visit& visit) noexcept
    {
        if (scene_.tree_rows() == 0) return;
        if (!is_ordinary_) return visit_all(layers, visit);
        const IndexParts& tree = scene_.tree.parts();
        if (suits_floats_) {
            Ray wide = ray_;
            wide.t_min -= slack_;
            wide.t_max += slack_;
            const auto take = [&](const IndexLeaf& leaf, RayTraversal& open) {
                const Flow flow = visit_leaf(leaf, layers, visit);
                const float most = rounded_up(most_ * open.rate - open.shift) + 4 * open.t_error;
                open.most = std::min(open.most, most);
                return flow;
            };
            const RayStart start = visit_scene_leaves(tree, wide, take);
            if (start == RayStart::ready || start == RayStart::misses) return;
        }
        FixedStack<PendingBox, 7 * IndexParts::max_levels + 1> pending;
        pending.push({least_, tree.root()});
        while (!pending.empty()) {
            const PendingBox at = pending.pop();
            if (at.enters > most_) continue;
            const IndexBlock& block = tree.blocks()[at.reference & ~index_leaf_bit];
            if ((at.reference & index_leaf_bit) != 0) {
                if (visit_leaf(block.leaf, layers, visit) == Flow::stop) return;
            } else {
                enter(block.node, pending);
            }
        }
    }

private:
    struct PendingBox {
        double enters;
        std::uint32_t reference;
    };
    /// The ray in some coordinates, with planes' errors on its origin's side.
    struct Slopes {
        std::array<double, 3> inverse;
        std::array<double, 3> near;
        std::array<double, 3> far;
    };
    // Products and quotients of what is between stay finite.
    static constexpr double least_size = 0x1p-400;
    static constexpr double most_size = 0x1p400;
    static constexpr double most_in_frame = 0x1p900;
    static constexpr double smallest_part = 0x1p-70;

    template <class Visit>
    void visit_all(std::uint32_t layers, const Visit& visit) const noexcept
    {
        for (std::uint32_t row = 0; row < scene_.tree_rows(); ++row) {
            if ((scene_.rows[row].layers & layers) == 0) continue;
            if (visit(row) == Flow::stop) return;
        }
    }

    template <class Pending>
    void enter(const IndexNode& node, Pending& pending) const noexcept
    {
        std::array<double, 8> enters;
        std::array<double, 8> leaves;
        enters.fill(least_);
        leaves.fill(most_);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto step = static_cast<double>(node.step[axis]);
            const double base = static_cast<double>(node.origin[axis]) + 32768.0 * step;
            const double rate = step * frame_.inverse[axis];
            const double near = (base - frame_.near[axis]) * frame_.inverse[axis];
            const double far = (base - frame_.far[axis]) * frame_.inverse[axis];
            const std::uint8_t* const planes = node.planes[axis].data();
            const std::uint8_t* const first = planes + (is_negative_[axis] ? 8 : 0);
            const std::uint8_t* const second = planes + (is_negative_[axis] ? 0 : 8);
            for (std::size_t slot = 0; slot < 8; ++slot) {
                enters[slot] = std::max(enters[slot], near + first[slot] * rate);
                leaves[slot] = std::min(leaves[slot], far + second[slot] * rate);
            }
        }
        std::array<PendingBox, 8> met;
        std::size_t count = 0;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (!(enters[slot] <= leaves[slot]) || !node.has_child(slot)) continue;
            std::size_t position = count++;
            for (; position > 0 && met[position - 1].enters < enters[slot]; --position)
                met[position] = met[position - 1];
            met[position] = {enters[slot], node.children[slot]};
        }
        for (std::size_t i = 0; i < count; ++i) pending.push(met[i]);
    }

    template <class Visit>
    [[nodiscard]] Flow visit_leaf(const IndexLeaf& leaf, std::uint32_t layers,
                                  const Visit& visit) const noexcept
    {
        std::array<PendingBox, 8> met; // by rows
        std::size_t count = 0;
        for (std::uint32_t i = 0; i < leaf.count; ++i) {
            const SceneRow& row = scene_.rows[leaf.first_row + i];
            if ((row.layers & layers) == 0) continue;
            double enters = least_;
            double leaves = most_;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double* const first =
                    is_negative_[axis] ? row.box.upper.data() : row.box.lower.data();
                const double* const second =
                    is_negative_[axis] ? row.box.lower.data() : row.box.upper.data();
                enters = std::max(enters, (first[axis] - world_.near[axis]) * world_.inverse[axis]);
                leaves = std::min(leaves, (second[axis] - world_.far[axis]) * world_.inverse[axis]);
            }
            if (!(enters <= leaves)) continue;
            std::size_t position = count++;
            for (; position > 0 && met[position - 1].enters > enters; --position)
                met[position] = met[position - 1];
            met[position] = {enters, leaf.first_row + i};
        }
        for (std::size_t i = 0; i < count && met[i].enters <= most_; ++i)
            if (visit(met[i].reference) == Flow::stop) return Flow::stop;
        return Flow::proceed;
    }

    const SceneParts& scene_;
    const Ray& ray_;
    bool is_ordinary_ = false;
    bool suits_floats_ = false;
    std::array<bool, 3> is_negative_;
    Slopes world_;
    Slopes frame_;
    double slack_;
    double least_;
    double most_;
};

} // namespace proxima
