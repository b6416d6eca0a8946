// The change of an object's shape, as the application hands it to the servo loop: two bodies with the
// same triangles, and a tree about both.
#pragma once

#include "haptics/scene/contact_body.h"
#include "haptics/surface/changing_surface.h"
#include "haptics/surface/triangle_tree.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <memory>
#include <optional>

namespace proxima {

/// Immutable.
class ShapeChange {
public:
    /// Errors: those of build_triangle_tree. O(triangles). \pre one body is a refit of the other, or
    /// both of a third
    [[nodiscard]] static Result<std::shared_ptr<const ShapeChange>>
    make(std::shared_ptr<const ContactBody> from, std::shared_ptr<const ContactBody> to,
         double seconds);

    [[nodiscard]] const ContactBody& from() const noexcept { return *from_; }
    [[nodiscard]] const ContactBody& to() const noexcept { return *to_; }
    [[nodiscard]] double seconds() const noexcept { return seconds_; }
    /// A box that holds both shapes.
    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }
    /// No vertex moves farther, rounding included.
    [[nodiscard]] double farthest() const noexcept { return farthest_; }
    /// What a ChangingSurface is made of.
    [[nodiscard]] ChangingParts parts() const noexcept;

private:
    ShapeChange() = default;

    std::shared_ptr<const ContactBody> from_;
    std::shared_ptr<const ContactBody> to_;
    std::optional<TriangleTree> tree_; ///< none for bodies that test every triangle
    SurfaceScale scale_;
    Box bounds_;
    double farthest_ = 0;
    double seconds_ = 0;
};

} // namespace proxima
