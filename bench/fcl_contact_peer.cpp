#include "contact_peers.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace proxima::bench {
namespace {

/// A hierarchy of bounding volumes in doubles. Contacts are pairs of triangles alone: points and normals
/// would take longer.
template <class Volume>
class FclContactPeer final : public ContactPeer {
public:
    FclContactPeer(const TriangleMesh& mesh, std::string name) : name_(std::move(name))
    {
        const auto start = std::chrono::steady_clock::now();
        model_ = std::make_shared<fcl::BVHModel<Volume>>();
        std::vector<fcl::Triangle> triangles;
        for (const TriangleCorners& corners : mesh.triangles())
            triangles.emplace_back(corners[0], corners[1], corners[2]);
        model_->beginModel();
        model_->addSubModel({mesh.positions().begin(), mesh.positions().end()}, triangles);
        model_->endModel();
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    [[nodiscard]] std::string name() const override { return name_; }
    [[nodiscard]] double build_seconds() const override { return seconds_; }
    [[nodiscard]] bool intersects(const RigidTransform& pose) override
    {
        return collide(pose, 1) > 0;
    }
    std::size_t find_pairs(const RigidTransform& pose) override
    {
        return collide(pose, std::numeric_limits<std::size_t>::max());
    }
    [[nodiscard]] std::vector<TrianglePair> sorted_pairs() const override
    {
        std::vector<TrianglePair> pairs;
        for (std::size_t i = 0; i < result_.numContacts(); ++i) {
            const fcl::Contactd& contact = result_.getContact(i);
            pairs.push_back({TriangleId{static_cast<std::uint32_t>(contact.b1)},
                             TriangleId{static_cast<std::uint32_t>(contact.b2)}});
        }
        std::ranges::sort(pairs);
        return pairs;
    }

private:
    std::size_t collide(const RigidTransform& pose, std::size_t most)
    {
        fcl::Transform3d moved = fcl::Transform3d::Identity();
        moved.linear() = pose.rotation;
        moved.translation() = pose.translation;
        result_.clear();
        return fcl::collide<double>(model_.get(), fcl::Transform3d::Identity(), model_.get(), moved,
                                    {most, false}, result_);
    }

    std::string name_;
    std::shared_ptr<fcl::BVHModel<Volume>> model_;
    double seconds_ = 0;
    fcl::CollisionResultd result_;
};

} // namespace

std::unique_ptr<ContactPeer> make_fcl_contact_peer(const TriangleMesh& mesh, FclVolume volume)
{
    if (volume == FclVolume::obb)
        return std::make_unique<FclContactPeer<fcl::OBBd>>(mesh, "fcl OBB");
    return std::make_unique<FclContactPeer<fcl::OBBRSSd>>(mesh, "fcl OBBRSS");
}

} // namespace proxima::bench
