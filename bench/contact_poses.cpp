#include "contact_poses.h"

#include "proxima/intersect_meshes.h"

#include <Eigen/Geometry>

#include <random>

namespace proxima::bench {
namespace {

constexpr int random_poses = 60;
constexpr int near_poses = 20;
constexpr double gap = 1e-3; // of the mesh's size

class PoseMaker {
public:
    PoseMaker(const TriangleMesh& mesh, const MeshIndex& index, std::uint64_t seed)
        : index_(index), box_(bounding_box(mesh)), random_(seed)
    {}

    /// Turned about the centre, and moved within a box of the mesh's size.
    RigidTransform overlapping()
    {
        RigidTransform pose = turned();
        pose.translation += box_.extent().cwiseProduct(Vec3(unit(), unit(), unit())) / 2;
        return pose;
    }
    /// Where the meshes come together along a random line through the centre, or that far before
    /// (positive) or behind.
    RigidTransform meeting(double before)
    {
        RigidTransform pose = turned();
        const Vec3 way = direction();
        const double size = box_.extent().norm();
        double apart = 2 * size;
        double touching = 0;
        // The outermost meeting, as far as steps of a hundredth can tell, then halved.
        const auto at = [&](double distance) {
            return RigidTransform{pose.rotation, pose.translation + distance * way};
        };
        for (int steps = 200; steps > 0; --steps) {
            const double distance = steps * size / 100;
            if (meshes_intersect(index_, index_, at(distance))) {
                touching = distance;
                break;
            }
            apart = distance;
        }
        while (apart - touching > 1e-9 * size) {
            const double middle = (apart + touching) / 2;
            (meshes_intersect(index_, index_, at(middle)) ? touching : apart) = middle;
        }
        return at(touching + before * size);
    }

private:
    double unit() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
    Vec3 direction()
    {
        std::normal_distribution<double> normal;
        const double x = normal(random_);
        const double y = normal(random_);
        return Vec3(x, y, normal(random_)).normalized();
    }
    RigidTransform turned()
    {
        std::normal_distribution<double> normal;
        const double w = normal(random_);
        const double x = normal(random_);
        const double y = normal(random_);
        const Eigen::Quaterniond turn(w, x, y, normal(random_));
        RigidTransform pose;
        pose.rotation = turn.normalized().toRotationMatrix();
        pose.translation = box_.center() - pose.rotation * box_.center();
        return pose;
    }

    const MeshIndex& index_;
    Box box_;
    std::mt19937_64 random_;
};

} // namespace

std::vector<PoseSet> contact_poses(const TriangleMesh& mesh, const MeshIndex& index,
                                   std::uint64_t seed)
{
    PoseMaker make(mesh, index, seed);
    std::vector<PoseSet> sets = {{"random", {}}, {"near", {}}, {"touch", {}}};
    for (int i = 0; i < random_poses;) {
        const RigidTransform pose = make.overlapping();
        if (!meshes_intersect(index, index, pose)) continue;
        sets[0].poses.push_back(pose);
        ++i;
    }
    for (int i = 0; i < near_poses; ++i) sets[1].poses.push_back(make.meeting(gap));
    for (int i = 0; i < near_poses; ++i) sets[2].poses.push_back(make.meeting(-gap));
    return sets;
}

} // namespace proxima::bench
