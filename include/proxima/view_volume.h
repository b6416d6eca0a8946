// What a camera sees: a convex volume between planes, bounded or not (thesis section 5.4).
//
//     auto volume = make_perspective_volume({.eye = {0, 0, 5}, .forward = {0, 0, -1}});
//     auto wedge = make_view_volume(planes);          // any closed half-spaces
//
// A volume is exactly the set of points that its planes, taken as the doubles they are, have in
// common.
#pragma once

#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// The points with normal . x + offset >= 0. The normal points inward and may have any length.
struct ViewPlane {
    Vec3 normal = Vec3::UnitZ();
    double offset = 0;
};

/// The one point on three planes: known exactly though no doubles may hold it.
using PlaneMeeting = std::array<ViewPlane, 3>;

/// As many planes as a volume may have.
inline constexpr std::size_t max_view_planes = 1024;

/// Immutable; made by the functions below. Members are noexcept and may be called from any thread.
class ViewVolume {
public:
    [[nodiscard]] std::span<const ViewPlane> planes() const noexcept { return planes_; }

    /// Whether no point is inside all planes: such a volume sees nothing. Decided exactly.
    [[nodiscard]] bool empty() const noexcept { return !inner_point_; }

    /// A point of the volume. \pre !empty()
    [[nodiscard]] const PlaneMeeting& inner_point() const noexcept { return *inner_point_; }

private:
    friend Result<ViewVolume> make_view_volume(std::span<const ViewPlane> planes);

    std::vector<ViewPlane> planes_;
    std::optional<PlaneMeeting> inner_point_;
};

/// The points inside all planes. Planes that contradict each other make an empty volume, no error;
/// so may a volume be flat, or reach to infinity. Errors: invalid_argument (no planes, NaN or
/// infinity, a normal of no length: which), limit_exceeded (more than max_view_planes). About 0.1
/// us per plane, at worst their number cubed.
[[nodiscard]] Result<ViewVolume> make_view_volume(std::span<const ViewPlane> planes);

/// A truncated pyramid. Lengths in the mesh's unit.
struct PerspectiveCamera {
    Vec3 eye = Vec3::Zero();
    Vec3 forward = -Vec3::UnitZ();                  ///< of any length
    Vec3 up = Vec3::UnitY();                        ///< of any length, not along forward
    double field_of_view = 0.25 * std::numbers::pi; ///< radians from bottom to top, below pi
    double aspect = 1;                              ///< width over height
    double near = 0.01;                             ///< along forward
    double far = std::numeric_limits<double>::infinity();
};

/// A box. Lengths in the mesh's unit.
struct OrthographicCamera {
    Vec3 eye = Vec3::Zero();
    Vec3 forward = -Vec3::UnitZ(); ///< of any length
    Vec3 up = Vec3::UnitY();       ///< of any length, not along forward
    double width = 2;
    double height = 2;
    double near = 0; ///< along forward; may be negative
    double far = std::numeric_limits<double>::infinity();
};

/// Planes left, right, bottom, top, near, and far unless that is infinite; their numbers are
/// rounded. Error invalid_argument for a camera that sees no volume: directions that are zero or
/// along each other, an angle, aspect, width or height that is not positive, near not below far or,
/// in perspective, not positive; any number that is not finite but for far.
[[nodiscard]] Result<ViewVolume> make_perspective_volume(const PerspectiveCamera& camera);
[[nodiscard]] Result<ViewVolume> make_orthographic_volume(const OrthographicCamera& camera);

} // namespace proxima
