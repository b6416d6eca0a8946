#include "scene_peers.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

namespace proxima::bench {
namespace {

/// A DynamicAABBTreeCollisionManager, oriented boxes with swept spheres for a mesh, in doubles. The
/// manager's boxes bound the mesh's bounding sphere where the rotation is not the identity.
class FclScenePeer final : public ScenePeer {
public:
    explicit FclScenePeer(const TriangleMesh& mesh)
    {
        model_ = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
        std::vector<fcl::Triangle> triangles;
        for (const TriangleCorners& corners : mesh.triangles())
            triangles.emplace_back(corners[0], corners[1], corners[2]);
        model_->beginModel();
        model_->addSubModel({mesh.positions().begin(), mesh.positions().end()}, triangles);
        model_->endModel();
    }
    [[nodiscard]] std::string name() const override { return "fcl"; }

    /// Makes the objects: each constructor finds the bounds of the whole mesh again, which a program
    /// pays once per object, not once per scene.
    void prepare_build(std::span<const RigidTransform> poses) override
    {
        manager_.reset();
        objects_.clear();
        pointers_.clear();
        for (std::size_t i = 0; i < poses.size(); ++i) {
            objects_.push_back(
                std::make_unique<fcl::CollisionObjectd>(model_, transform(poses[i])));
            objects_.back()->setUserData(
                reinterpret_cast<void*>(i)); // NOLINT(performance-no-int-to-ptr)
            pointers_.push_back(objects_.back().get());
        }
    }
    /// Registers the objects and sets up the tree.
    void build(std::span<const RigidTransform> /*poses*/) override
    {
        manager_ = std::make_unique<fcl::DynamicAABBTreeCollisionManagerd>();
        manager_->registerObjects(pointers_);
        manager_->setup();
    }
    void move(std::span<const RigidTransform> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) {
            objects_[i]->setTransform(transform(poses[i]));
            objects_[i]->computeAABB();
        }
        manager_->update();
    }
    [[nodiscard]] bool finds_pairs() const override { return true; }
    ScenePairs find_pairs() override
    {
        ScenePairs pairs;
        manager_->collide(&pairs, [](fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* to) {
            fcl::CollisionResultd result;
            fcl::collide<double>(a, b, fcl::CollisionRequestd(1, false), result);
            if (result.isCollision()) {
                const auto number = [](const fcl::CollisionObjectd* of) {
                    return static_cast<std::uint32_t>(
                        reinterpret_cast<std::uintptr_t>(of->getUserData()));
                };
                static_cast<ScenePairs*>(to)->emplace_back(number(a), number(b));
            }
            return false;
        });
        return pairs;
    }
    std::size_t count_overlaps() override
    {
        std::size_t count = 0;
        manager_->collide(&count, [](fcl::CollisionObjectd*, fcl::CollisionObjectd*, void* to) {
            ++*static_cast<std::size_t*>(to);
            return false;
        });
        return count;
    }

private:
    static fcl::Transform3d transform(const RigidTransform& pose)
    {
        fcl::Transform3d moved = fcl::Transform3d::Identity();
        moved.linear() = pose.rotation;
        moved.translation() = pose.translation;
        return moved;
    }

    std::shared_ptr<fcl::BVHModel<fcl::OBBRSSd>> model_;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
    std::vector<fcl::CollisionObjectd*> pointers_; ///< to them, in the same order
    std::unique_ptr<fcl::DynamicAABBTreeCollisionManagerd> manager_;
};

} // namespace

std::unique_ptr<ScenePeer> make_fcl_scene_peer(const TriangleMesh& mesh)
{
    return std::make_unique<FclScenePeer>(mesh);
}

} // namespace proxima::bench
