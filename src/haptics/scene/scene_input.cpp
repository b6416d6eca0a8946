#include "haptics/scene/scene_input.h"

#include "base/check.h"
#include "base/text.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace proxima {

namespace {

bool is_rigid(const RigidTransform& pose) noexcept
{
    const Mat3& r = pose.rotation;
    if (!r.allFinite() || !pose.translation.allFinite()) return false;
    return (r.transpose() * r - Mat3::Identity()).norm() <= rigid_tolerance && r.determinant() > 0;
}

bool in_range(const ObjectMotion& motion) noexcept
{
    return std::isfinite(motion.seconds) && motion.seconds >= 0 && motion.velocity.allFinite() &&
           (motion.spin.array().abs() <= most_spin).all() && std::isfinite(motion.coast_seconds) &&
           motion.coast_seconds >= 0;
}

} // namespace

Status check_scene_triangles(std::size_t count)
{
    constexpr std::size_t most = std::size_t{1} << scene_triangle_bits;
    if (count <= most) return {};
    return fail(ErrorCode::invalid_argument,
                concat("a body in a scene has at most ", most, " triangles, not ", count,
                       ": give it fewer, or split it into several objects"));
}

SceneInput::SceneInput(const Box& bounds) : bounds_(bounds)
{
    PROXIMA_CHECK((bounds.extent().array() > 0).all());
}

SceneInput::Object::Object(const ObjectCourse& start) : course(start)
{
    for (Snapshot<ObjectCourse>& each : courses) {
        each.writing() = start;
        each.publish();
    }
}

SceneInput::Object& SceneInput::object(ObjectId id)
{
    PROXIMA_CHECK_LT(to_index(id), objects_.size());
    return *objects_[to_index(id)];
}

Result<SceneInput::Object*> SceneInput::find(ObjectId id)
{
    if (to_index(id) < objects_.size()) return objects_[to_index(id)].get();
    return fail(ErrorCode::invalid_argument,
                concat("no object has the id ", to_index(id), ": the scene has ", objects_.size(),
                       objects_.size() == 1 ? " object" : " objects"));
}

bool SceneInput::contains(const Box& box, const RigidTransform& pose,
                          const Vec3& margin) const noexcept
{
    const Vec3 lower = bounds_.lower + margin;
    const Vec3 upper = bounds_.upper - margin;
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<Eigen::Index>(axis);
            p[i] = (corner >> axis & 1U) != 0 ? box.upper[i] : box.lower[i];
        }
        const Vec3 at = pose(p);
        if ((at.array() < lower.array()).any() || (at.array() > upper.array()).any()) return false;
    }
    return true;
}

bool SceneInput::contains_coast(const Box& box, const ObjectMotion& motion) const noexcept
{
    const RigidTransform end = coasted(motion, motion.coast_seconds);
    const double spin = motion.spin.norm();
    const double angle = motion.coast_seconds * spin;
    if (!(angle > 0)) return contains(box, motion.pose) && contains(box, end);
    // However far it turns, it stays within a ball about the object's origin.
    const double reach = box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
    const Box ball = {Vec3::Constant(-reach), Vec3::Constant(reach)};
    if (contains(ball, {Mat3::Identity(), motion.pose.translation}) &&
        contains(ball, {Mat3::Identity(), end.translation}))
        return true;
    if (!(angle < std::numbers::pi)) return false;
    // Its points leave the straight lines between both ends by at most this, across the axis.
    const Vec3 along = motion.spin / spin;
    const Vec3 across = (1 - along.array().square()).max(0).sqrt().matrix();
    const Vec3 margin = angle * angle / 8 * reach * across;
    return contains(box, motion.pose, margin) && contains(box, end, margin);
}

bool SceneInput::contains_course(const Box& box, const ObjectCourse& course) const noexcept
{
    const SceneTime now = clock_.now();
    return contains(box, course.pose_at(now)) &&
           (course.rests_at(now) || contains_coast(box, course.motion()));
}

Result<ObjectId> SceneInput::add(std::shared_ptr<const ContactBody> body,
                                 const RigidTransform& pose)
{
    PROXIMA_CHECK(body != nullptr);
    if (clock_.now() != 0) {
        return fail(ErrorCode::invalid_argument,
                    "objects must be added before the scene's first tick");
    }
    if (objects_.size() == max_scene_objects)
        return fail(ErrorCode::invalid_argument, "a scene cannot have more than 64 objects");
    if (!is_rigid(pose))
        return fail(ErrorCode::invalid_argument, "the object's pose must be a rigid transform");
    if (Status status = check_scene_triangles(body->mesh().triangle_count()); !status)
        return tl::unexpected(status.error());
    if (!contains(body->bounds(), pose))
        return fail(ErrorCode::invalid_argument, "the object must be within the scene's bounds");
    auto object = std::make_unique<Object>(ObjectCourse(pose));
    object->shape.body = std::move(body);
    objects_.push_back(std::move(object));
    return ObjectId{static_cast<std::uint32_t>(objects_.size() - 1)};
}

const char* SceneInput::motion_problem(ObjectId id, const ObjectMotion& motion) const noexcept
{
    if (!is_rigid(motion.pose)) return "the object's pose must be a rigid transform";
    if (!in_range(motion)) {
        return "times of a motion must be finite and not negative, its velocity finite, and its "
               "spin at most 1e4 radians per second about each axis";
    }
    const SceneShape& shape = objects_[to_index(id)]->shape;
    const bool changes = shape.change != nullptr &&
                         seconds_between(shape.start, clock_.now()) < shape.change->seconds();
    if (!contains_coast(changes ? shape.change->bounds() : shape.body->bounds(), motion))
        return "the motion would take the object out of the scene's bounds";
    return nullptr;
}

Status SceneInput::move(ObjectId id, const ObjectMotion& motion, const Vec3& pivot)
{
    const auto found = find(id);
    if (!found) return tl::unexpected(found.error());
    Object& object = **found;
    if (const char* const problem = motion_problem(id, motion))
        return fail(ErrorCode::invalid_argument, problem);
    object.course = object.course.continued(motion, clock_.now(), pivot);
    for (Snapshot<ObjectCourse>& courses : object.courses) {
        courses.writing() = object.course;
        courses.publish();
    }
    return {};
}

Status SceneInput::set_material(ObjectId id, const SurfaceMaterial& material, double seconds)
{
    const auto found = find(id);
    if (!found) return tl::unexpected(found.error());
    Object& object = **found;
    if (!is_valid(material)) return fail(ErrorCode::invalid_argument, material_rule);
    if (!(seconds >= 0) || !std::isfinite(seconds)) {
        return fail(ErrorCode::invalid_argument,
                    "the time of a change must be finite and at least 0");
    }
    object.material = object.material.continued(material, seconds, object.shape.body->material(),
                                                object.shape.exchanges, clock_.now());
    for (Snapshot<MaterialCourse>& materials : object.materials) {
        materials.writing() = object.material;
        materials.publish();
    }
    return {};
}

/// Gives all tools a shape. What servo loops have left goes after the lock.
void SceneInput::publish(Object& object, SceneShape shape)
{
    std::array<SceneShape, max_scene_tools> left;
    {
        const std::lock_guard lock(mutex_);
        object.shape = std::move(shape);
        for (std::size_t tool = 0; tool < max_scene_tools; ++tool) {
            ShapeSnapshot* const shapes = object.shapes[tool];
            if (shapes == nullptr) continue;
            left[tool] = std::exchange(shapes->writing(), object.shape);
            shapes->publish();
        }
    }
}

Status SceneInput::exchange(ObjectId id, std::shared_ptr<const ContactBody> body)
{
    PROXIMA_CHECK(body != nullptr);
    const auto found = find(id);
    if (!found) return tl::unexpected(found.error());
    Object& object = **found;
    if (Status status = check_scene_triangles(body->mesh().triangle_count()); !status)
        return status;
    if (!contains_course(body->bounds(), object.course)) {
        return fail(ErrorCode::invalid_argument,
                    "the new body would not be within the scene's bounds");
    }
    SceneShape next;
    next.body = std::move(body);
    next.exchanges = object.shape.exchanges + 1;
    publish(object, std::move(next));
    return {};
}

Status SceneInput::change_shape(ObjectId id, std::shared_ptr<const ContactBody> body,
                                double seconds)
{
    PROXIMA_CHECK(body != nullptr);
    const auto found = find(id);
    if (!found) return tl::unexpected(found.error());
    Object& object = **found;
    if (!body->has_triangles_of(*object.shape.body)) {
        return fail(ErrorCode::invalid_argument,
                    "the body is no refit of the object's: use refit_touch_body, or exchange()");
    }
    if (!(seconds >= 0) || !std::isfinite(seconds)) {
        return fail(ErrorCode::invalid_argument,
                    "the time of a change must be finite and at least 0");
    }
    if (!contains_course(body->bounds(), object.course)) {
        return fail(ErrorCode::invalid_argument,
                    "the new shape would not be within the scene's bounds");
    }
    auto change = ShapeChange::make(object.shape.body, body, seconds);
    if (!change) return tl::unexpected(change.error());
    SceneShape next = object.shape;
    next.travelled += (*change)->farthest();
    next.body = std::move(body);
    next.change = std::move(*change);
    next.start = clock_.now();
    publish(object, std::move(next));
    return {};
}

void SceneInput::join(ObjectId id, std::size_t tool, ShapeSnapshot& shapes)
{
    Object& object = this->object(id);
    const std::lock_guard lock(mutex_);
    PROXIMA_CHECK(object.shapes[tool] == nullptr);
    object.shapes[tool] = &shapes;
    shapes.writing() = object.shape;
    shapes.publish();
}

std::shared_ptr<const ContactBody> SceneInput::body(ObjectId id)
{
    const Object& object = this->object(id);
    const std::lock_guard lock(mutex_);
    return object.shape.body;
}

void SceneInput::leave(std::size_t tool)
{
    const std::lock_guard lock(mutex_);
    for (const auto& object : objects_) object->shapes[tool] = nullptr;
}

} // namespace proxima
