#include "proxima/view_volume.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "geometry/view_plane.h"

namespace proxima {

namespace {

Displacement from_zero(const Vec3& to) noexcept
{
    return {Vec3::Zero(), to};
}

ViewPlane coordinate_plane(int axis) noexcept
{
    return {Vec3::Unit(axis), 0};
}

// Looks for a point of all half-spaces, one after the other: if the point found so far is outside
// of the next, and there is any inside, then there is one on its plane; on that plane likewise, and
// on lines [seidel-1991]. All points are meetings of three planes, some of them coordinate planes.
class PointSearch {
public:
    explicit PointSearch(std::span<const ViewPlane> planes) noexcept : planes_(planes) {}

    [[nodiscard]] std::optional<PlaneMeeting> in_space() const noexcept
    {
        std::optional<PlaneMeeting> at =
            PlaneMeeting{coordinate_plane(0), coordinate_plane(1), coordinate_plane(2)};
        for (std::size_t i = 0; i < planes_.size() && at; ++i)
            if (side_of_plane(planes_[i], *at) < 0) at = on_plane(i);
        return at;
    }

private:
    /// A point on plane `last` inside all before it.
    [[nodiscard]] std::optional<PlaneMeeting> on_plane(std::size_t last) const noexcept
    {
        const ViewPlane& plane = planes_[last];
        int axis = 0;
        plane.normal.cwiseAbs().maxCoeff(&axis);
        std::optional<PlaneMeeting> at =
            PlaneMeeting{plane, coordinate_plane((axis + 1) % 3), coordinate_plane((axis + 2) % 3)};
        for (std::size_t i = 0; i < last && at; ++i)
            if (side_of_plane(planes_[i], *at) < 0) at = on_line(last, i);
        return at;
    }

    /// A point on planes `first` and `last` inside all before the latter.
    [[nodiscard]] std::optional<PlaneMeeting> on_line(std::size_t first,
                                                      std::size_t last) const noexcept
    {
        const Displacement n = from_zero(planes_[first].normal);
        const Displacement m = from_zero(planes_[last].normal);
        int axis = 0;
        while (axis < 3 && cross_component_sign(n, m, axis) == 0) ++axis;
        if (axis == 3) return std::nullopt; // parallel, and the whole plane is outside of the other
        const auto meeting = [&](const ViewPlane& third) {
            return PlaneMeeting{planes_[first], planes_[last], third};
        };
        const ViewPlane* lower = nullptr; // along the line, whose direction is n x m
        const ViewPlane* upper = nullptr;
        for (const ViewPlane& plane : planes_.first(last)) {
            const int slope = determinant_sign(n, m, from_zero(plane.normal));
            if (slope == 0) {
                if (side_of_plane(plane, meeting(coordinate_plane(axis))) < 0) return std::nullopt;
                continue;
            }
            const ViewPlane*& bound = slope > 0 ? lower : upper;
            if (bound == nullptr || side_of_plane(plane, meeting(*bound)) < 0) bound = &plane;
        }
        if (lower != nullptr && upper != nullptr && side_of_plane(*upper, meeting(*lower)) < 0)
            return std::nullopt;
        if (lower != nullptr) return meeting(*lower);
        return meeting(upper != nullptr ? *upper : coordinate_plane(axis));
    }

    std::span<const ViewPlane> planes_;
};

/// The axes of a camera, of length 1.
struct CameraFrame {
    Vec3 forward;
    Vec3 right;
    Vec3 up;
};

tl::unexpected<Error> refuse(std::string message)
{
    return fail(ErrorCode::invalid_argument, std::move(message), "camera");
}

Result<CameraFrame> camera_frame(const Vec3& eye, const Vec3& forward, const Vec3& up)
{
    if (!eye.allFinite() || !forward.allFinite() || !up.allFinite())
        return refuse("eye, forward and up must be finite numbers");
    if (forward.isZero(0)) return refuse("forward has no length; give where the camera looks");
    if (are_parallel(from_zero(forward), from_zero(up)))
        return refuse("up has no length or is along forward; give another direction");
    CameraFrame frame;
    frame.forward = unit_of(forward);
    // Exact where the two are nearly along each other.
    frame.right = unit_normal(from_zero(forward), from_zero(up));
    frame.up = frame.right.cross(frame.forward).normalized();
    return frame;
}

Status check_depths(double near, double far)
{
    if (!std::isfinite(near) || !(near < far))
        return refuse(concat("near is ", near, " and far ", far, "; near must be less"));
    return {};
}

ViewPlane plane_through(const Vec3& point, const Vec3& normal) noexcept
{
    return {normal, -normal.dot(point)};
}

/// The planes across forward.
void add_depths(std::vector<ViewPlane>& planes, const Vec3& eye, const CameraFrame& frame,
                double near, double far)
{
    planes.push_back(plane_through(eye + near * frame.forward, frame.forward));
    if (std::isfinite(far))
        planes.push_back(plane_through(eye + far * frame.forward, -frame.forward));
}

} // namespace

Result<ViewVolume> make_view_volume(std::span<const ViewPlane> planes)
{
    if (planes.empty())
        return fail(ErrorCode::invalid_argument, "a view volume needs a plane; give at least one");
    if (planes.size() > max_view_planes) {
        return fail(ErrorCode::limit_exceeded, concat("a view volume has at most ", max_view_planes,
                                                      " planes, not ", planes.size()));
    }
    for (std::size_t i = 0; i < planes.size(); ++i) {
        if (!planes[i].normal.allFinite() || !std::isfinite(planes[i].offset)) {
            return fail(ErrorCode::invalid_argument,
                        concat("plane ", i, " has a number that is not finite"));
        }
        if (planes[i].normal.isZero(0)) {
            return fail(ErrorCode::invalid_argument,
                        concat("plane ", i, " has no normal: a, b and c are all zero"));
        }
    }
    ViewVolume volume;
    volume.planes_.assign(planes.begin(), planes.end());
    volume.inner_point_ = PointSearch(planes).in_space();
    return volume;
}

Result<ViewVolume> make_perspective_volume(const PerspectiveCamera& camera)
{
    const auto frame = camera_frame(camera.eye, camera.forward, camera.up);
    if (!frame) return tl::unexpected(frame.error());
    if (Status status = check_depths(camera.near, camera.far); !status)
        return tl::unexpected(status.error());
    if (!(camera.near > 0))
        return refuse(concat("near is ", camera.near, "; in perspective it must be positive"));
    if (!(camera.field_of_view > 0) || !(camera.field_of_view < std::numbers::pi)) {
        return refuse(concat("the field of view is ", camera.field_of_view,
                             " radians; it must be between 0 and pi"));
    }
    if (!(camera.aspect > 0) || !std::isfinite(camera.aspect))
        return refuse(concat("the aspect is ", camera.aspect, "; it must be positive"));
    const double height = std::tan(0.5 * camera.field_of_view);
    const double width = height * camera.aspect;
    const Vec3& eye = camera.eye;
    const auto side = [&](const Vec3& inward, double extent) {
        return plane_through(eye, unit_of(inward + extent * frame->forward));
    };
    std::vector<ViewPlane> planes = {side(frame->right, width), side(-frame->right, width),
                                     side(frame->up, height), side(-frame->up, height)};
    add_depths(planes, eye, *frame, camera.near, camera.far);
    return make_view_volume(planes);
}

Result<ViewVolume> make_orthographic_volume(const OrthographicCamera& camera)
{
    const auto frame = camera_frame(camera.eye, camera.forward, camera.up);
    if (!frame) return tl::unexpected(frame.error());
    if (Status status = check_depths(camera.near, camera.far); !status)
        return tl::unexpected(status.error());
    if (!(camera.width > 0) || !(camera.height > 0) || !std::isfinite(camera.width) ||
        !std::isfinite(camera.height)) {
        return refuse(concat("the view is ", camera.width, " wide and ", camera.height,
                             " high; both must be positive"));
    }
    const Vec3& eye = camera.eye;
    std::vector<ViewPlane> planes;
    for (const auto& [axis, half] :
         {std::pair(frame->right, 0.5 * camera.width), std::pair(frame->up, 0.5 * camera.height)}) {
        planes.push_back(plane_through(eye - half * axis, axis));
        planes.push_back(plane_through(eye + half * axis, -axis));
    }
    add_depths(planes, eye, *frame, camera.near, camera.far);
    return make_view_volume(planes);
}

} // namespace proxima
