#include "fcl_distance_peer.h"

#include <chrono>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/math/bv/RSS.h>
#include <fcl/narrowphase/distance.h>

namespace proxima::bench {
namespace {

template <class Volume>
class FclDistancePeer final : public DistancePeer {
public:
    FclDistancePeer(const TriangleMesh& a, const TriangleMesh& b, std::string name)
        : name_(std::move(name))
    {
        const auto start = std::chrono::steady_clock::now();
        a_ = model_of(a);
        b_ = model_of(b);
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    [[nodiscard]] std::string name() const override { return name_; }
    [[nodiscard]] double build_seconds() const override { return seconds_; }
    [[nodiscard]] double distance(const RigidTransform& pose_b) override
    {
        fcl::Transform3d pose = fcl::Transform3d::Identity();
        pose.linear() = pose_b.rotation;
        pose.translation() = pose_b.translation;
        const fcl::DistanceRequestd request(true);
        fcl::DistanceResultd result;
        fcl::distance<double>(a_.get(), fcl::Transform3d::Identity(), b_.get(), pose, request,
                              result);
        return result.min_distance;
    }

private:
    using Model = fcl::BVHModel<Volume>;

    static std::shared_ptr<Model> model_of(const TriangleMesh& mesh)
    {
        std::vector<fcl::Vector3d> points(mesh.positions().begin(), mesh.positions().end());
        std::vector<fcl::Triangle> triangles;
        triangles.reserve(mesh.triangle_count());
        for (const TriangleCorners& corners : mesh.triangles())
            triangles.emplace_back(corners[0], corners[1], corners[2]);
        auto model = std::make_shared<Model>();
        model->beginModel();
        model->addSubModel(points, triangles);
        model->endModel();
        return model;
    }

    std::string name_;
    double seconds_ = 0;
    std::shared_ptr<Model> a_;
    std::shared_ptr<Model> b_;
};

} // namespace

std::unique_ptr<DistancePeer> make_fcl_distance_peer(const TriangleMesh& a, const TriangleMesh& b,
                                                     FclVolume volume)
{
    if (volume == FclVolume::rss)
        return std::make_unique<FclDistancePeer<fcl::RSS<double>>>(a, b, "fcl RSS");
    return std::make_unique<FclDistancePeer<fcl::OBBRSS<double>>>(a, b, "fcl OBBRSS");
}

} // namespace proxima::bench
