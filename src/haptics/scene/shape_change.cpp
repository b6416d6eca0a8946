#include "haptics/scene/shape_change.h"

#include <algorithm>
#include <utility>

namespace proxima {

namespace {

/// A bound of |to - from| over the vertices, and more than the rounding of positions between them.
double farthest_motion(const TriangleMesh& from, const TriangleMesh& to, const Box& bounds)
{
    double squared = 0;
    for (const TriangleCorners& corners : to.triangles()) {
        for (const std::uint32_t k : corners) {
            const Vec3 motion = to.positions()[k] - from.positions()[k];
            squared = std::max(squared, motion.squaredNorm());
        }
    }
    const double reach =
        std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff());
    return std::sqrt(squared) * (1 + 0x1p-40) + 0x1p-46 * reach;
}

SurfaceScale scale_of_both(const SurfaceScale& a, const SurfaceScale& b) noexcept
{
    return {std::max(a.extent, b.extent), std::max(a.reach, b.reach),
            std::min(a.mean_edge, b.mean_edge)};
}

} // namespace

Result<std::shared_ptr<const ShapeChange>>
ShapeChange::make(std::shared_ptr<const ContactBody> from, std::shared_ptr<const ContactBody> to,
                  double seconds)
{
    std::shared_ptr<ShapeChange> change(new ShapeChange);
    if (to->search() == BodySearch::index) {
        auto tree = build_triangle_tree(from->mesh(), to->mesh(), to->order());
        if (!tree) return tl::unexpected(tree.error());
        change->tree_ = std::move(*tree);
    }
    change->bounds_ = from->bounds();
    change->bounds_.extend(to->bounds().lower);
    change->bounds_.extend(to->bounds().upper);
    change->scale_ = scale_of_both(from->surface().scale(), to->surface().scale());
    change->farthest_ = farthest_motion(from->mesh(), to->mesh(), change->bounds_);
    change->seconds_ = seconds;
    change->from_ = std::move(from);
    change->to_ = std::move(to);
    return change;
}

ChangingParts ShapeChange::parts() const noexcept
{
    return {.from = &from_->mesh(),
            .to = &to_->mesh(),
            .tree = tree_ ? &*tree_ : nullptr,
            .order = to_->order(),
            .scale = scale_};
}

} // namespace proxima
