#include "proxima/touch_scene.h"

#include "haptics/scene/contact_body.h"
#include "haptics/scene/scene_views.h"
#include "haptics/scene/touch_access.h"
#include "proxima/mesh_index.h"

#include <utility>

namespace proxima {

TouchBody::TouchBody(std::shared_ptr<const ContactBody> body) noexcept : body_(std::move(body)) {}

const TriangleMesh& TouchBody::mesh() const noexcept
{
    return body_->mesh();
}

Result<TouchBody> build_touch_body(TriangleMesh mesh, const TouchBodyOptions& options)
{
    return build_contact_body(std::move(mesh), options).map(TouchAccess::wrap);
}

Result<TouchBody> build_touch_body(const MeshIndex& index, const TouchBodyOptions& options)
{
    return build_contact_body(index, options).map(TouchAccess::wrap);
}

Result<TouchBody> refit_touch_body(const TouchBody& body, std::span<const Vec3> positions,
                                   const Execution& execution)
{
    return refit_contact_body(contact_body(body), positions, execution).map(TouchAccess::wrap);
}

TouchScene::TouchScene(const Box& bounds) : views_(std::make_unique<SceneViews>(bounds)) {}
TouchScene::TouchScene(TouchScene&& other) noexcept = default;
TouchScene& TouchScene::operator=(TouchScene&& other) noexcept = default;
TouchScene::~TouchScene() = default;

Result<ObjectId> TouchScene::add(const TouchBody& body, const RigidTransform& pose)
{
    return views_->add(TouchAccess::unwrap(body), pose);
}

Status TouchScene::move(ObjectId object, const ObjectMotion& motion)
{
    return views_->input().move(object, motion);
}

Status TouchScene::exchange(ObjectId object, const TouchBody& body)
{
    return views_->input().exchange(object, TouchAccess::unwrap(body));
}

Status TouchScene::deform(ObjectId object, const TouchBody& body, double seconds)
{
    return views_->input().change_shape(object, TouchAccess::unwrap(body), seconds);
}

Status TouchScene::set_material(ObjectId object, const SurfaceMaterial& material, double seconds)
{
    return views_->input().set_material(object, material, seconds);
}

SceneTick TouchScene::advance(double seconds) noexcept
{
    return views_->own().advance(seconds);
}

std::size_t TouchScene::object_count() const noexcept
{
    return views_->input().object_count();
}

RigidTransform TouchScene::pose(ObjectId object) const noexcept
{
    return views_->own().object(object).now;
}

Vec3 TouchScene::velocity(ObjectId object, const Vec3& point) const noexcept
{
    return views_->own().velocity_at(object, point);
}

} // namespace proxima
