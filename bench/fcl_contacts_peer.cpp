#include "fcl_contacts_peer.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/math/motion/interp_motion.h>
#include <fcl/math/motion/translation_motion.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace proxima::bench {
namespace {

using FclModel = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<FclModel> model_of(const TriangleMesh& mesh, const RigidTransform& pose = {})
{
    std::vector<fcl::Vector3d> points;
    for (const Vec3& p : mesh.positions()) points.emplace_back(pose(p));
    std::vector<fcl::Triangle> triangles;
    for (const TriangleCorners& corners : mesh.triangles())
        triangles.emplace_back(corners[0], corners[1], corners[2]);
    auto model = std::make_shared<FclModel>();
    model->beginModel();
    model->addSubModel(points, triangles);
    model->endModel();
    return model;
}

std::shared_ptr<fcl::Convexd> convex_of(const ConvexPolyhedron& hull)
{
    auto points =
        std::make_shared<std::vector<fcl::Vector3d>>(hull.points().begin(), hull.points().end());
    auto faces = std::make_shared<std::vector<int>>();
    for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
        const auto loop = hull.facet_loop(f);
        faces->push_back(static_cast<int>(loop.size()));
        for (const std::uint32_t corner : loop) faces->push_back(static_cast<int>(corner));
    }
    return std::make_shared<fcl::Convexd>(points, static_cast<int>(hull.facet_count()), faces);
}

fcl::Transform3d transform_of(const RigidTransform& pose)
{
    fcl::Transform3d moved = fcl::Transform3d::Identity();
    moved.linear() = pose.rotation;
    moved.translation() = pose.translation;
    return moved;
}

} // namespace

struct FclTimeOfContact::Models {
    std::shared_ptr<FclModel> a;
    std::shared_ptr<FclModel> b;
};

FclTimeOfContact::FclTimeOfContact(const TriangleMesh& a, const TriangleMesh& b)
    : models_(std::make_unique<Models>(Models{model_of(a), model_of(b)}))
{}

FclTimeOfContact::~FclTimeOfContact() = default;

std::optional<double> FclTimeOfContact::time(const RigidMotion& motion, FclAdvance how) const
{
    const RigidTransform& from = motion.start;
    const RigidTransform to = pose_at(motion, 1);
    // Constructors without a center leave it uninitialized.
    const fcl::InterpMotion<double> still(Mat3::Identity(), Vec3::Zero(), Mat3::Identity(),
                                          Vec3::Zero(), Vec3::Zero());
    const fcl::InterpMotion<double> moving(from.rotation, from.translation, to.rotation,
                                           to.translation, motion.center);
    const bool steps = how == FclAdvance::steps;
    const fcl::ContinuousCollisionRequestd request(
        steps ? 200 : 10000, steps ? 5e-3 : 1e-9, fcl::CCDM_LINEAR, fcl::GST_LIBCCD,
        steps ? fcl::CCDC_NAIVE : fcl::CCDC_CONSERVATIVE_ADVANCEMENT);
    fcl::ContinuousCollisionResultd result;
    (void)fcl::continuousCollide<double>(models_->a.get(), &still, models_->b.get(), &moving,
                                         request, result);
    if (!result.is_collide) return std::nullopt;
    return result.time_of_contact;
}

struct FclTranslation::Models {
    std::shared_ptr<FclModel> a;
    std::shared_ptr<FclModel> b;
};

FclTranslation::FclTranslation(TriangleMesh a, TriangleMesh b)
    : a_(std::move(a)), b_(std::move(b)), models_(std::make_unique<Models>())
{}

FclTranslation::~FclTranslation() = default;

void FclTranslation::prepare(const RigidMotion& motion)
{
    *models_ = {model_of(a_), model_of(b_, motion.start)};
}

std::optional<double> FclTranslation::time(const RigidMotion& motion)
{
    const Mat3 unturned = Mat3::Identity();
    const fcl::TranslationMotion<double> still(unturned, Vec3::Zero(), Vec3::Zero());
    const fcl::TranslationMotion<double> moving(unturned, Vec3::Zero(), motion.displacement);
    const fcl::ContinuousCollisionRequestd request(10, 1e-4, fcl::CCDM_TRANS, fcl::GST_LIBCCD,
                                                   fcl::CCDC_POLYNOMIAL_SOLVER);
    fcl::ContinuousCollisionResultd result;
    (void)fcl::continuousCollide<double>(models_->a.get(), &still, models_->b.get(), &moving,
                                         request, result);
    if (!result.is_collide) return std::nullopt;
    return result.time_of_contact;
}

struct FclConvexDepth::Shapes {
    std::shared_ptr<fcl::Convexd> a;
    std::shared_ptr<fcl::Convexd> b;
};

FclConvexDepth::FclConvexDepth(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
    : shapes_(std::make_unique<Shapes>(Shapes{convex_of(a), convex_of(b)}))
{}

FclConvexDepth::~FclConvexDepth() = default;

double FclConvexDepth::depth(const RigidTransform& pose_b, FclDepthMethod method) const
{
    const fcl::Transform3d at_a = fcl::Transform3d::Identity();
    const fcl::Transform3d at_b = transform_of(pose_b);
    if (method == FclDepthMethod::signed_distance) {
        const fcl::DistanceRequestd request(false, true);
        fcl::DistanceResultd result;
        (void)fcl::distance<double>(shapes_->a.get(), at_a, shapes_->b.get(), at_b, request,
                                    result);
        return std::max(0.0, -result.min_distance);
    }
    fcl::CollisionRequestd request(1, true);
    if (method == FclDepthMethod::gjk_epa) request.gjk_solver_type = fcl::GST_INDEP;
    fcl::CollisionResultd result;
    (void)fcl::collide<double>(shapes_->a.get(), at_a, shapes_->b.get(), at_b, request, result);
    if (!result.isCollision()) return 0;
    const double depth = result.getContact(0).penetration_depth;
    // FCL's own solver negates the depth.
    return std::max(0.0, method == FclDepthMethod::gjk_epa ? -depth : depth);
}

} // namespace proxima::bench
