#include "haptics/tool/seen_object.h"

#include <utility>

namespace proxima {

namespace {

/// The pose of the tool in the frame of an object.
RigidTransform relative_pose(const RigidTransform& object, const RigidTransform& tool) noexcept
{
    const Mat3 back = object.rotation.transpose();
    return {back * tool.rotation, back * (tool.translation - object.translation)};
}

} // namespace

Result<RigidBody> RigidBody::build(const MeshIndex& index)
{
    auto with = with_slabs(index);
    if (!with) return tl::unexpected(with.error());
    auto features = ContactFeatures::build(*with);
    if (!features) return tl::unexpected(features.error());
    const auto inside = build_enclosure(*with);
    if (!inside) return tl::unexpected(inside.error());
    return RigidBody{*with, std::move(*features), *inside};
}

bool SeenObject::is_behind() const noexcept
{
    return pose.translation != goal.translation || pose.rotation != goal.rotation;
}

void SeenObject::look_at(const RigidTransform& tool) noexcept
{
    relative = relative_pose(pose, tool);
}

RigidTransform SeenObject::seen_from_goal(const RigidTransform& tool) const noexcept
{
    return relative_pose(goal, tool);
}

void SeenObject::begin_step(double part) noexcept
{
    moves = is_behind() && part > 0;
    arrives = moves && part == 1;
    step = moves ? twist_between(pose, goal).scaled(part) : Twist();
}

RigidTransform SeenObject::stepped(double part) const noexcept
{
    if (arrives && part == 1) return goal;
    return moves ? moved_by(pose, step, part) : pose;
}

void SeenObject::set_motion(const Twist& twist, const RigidTransform& to, double part) noexcept
{
    motion.from = relative;
    motion.to = relative_pose(stepped(part), to);
    if (moves) {
        motion.twist = twist_between(motion.from, motion.to);
    } else {
        const Mat3 back = pose.rotation.transpose();
        motion.twist = {back * (part * twist.linear), back * (part * twist.angular)};
    }
}

} // namespace proxima
