// Motions that find what is wrong with times of contact: past each other, through each other, turning
// fast, hardly at all, touching in passing.
#pragma once

#include "proxima/geometry.h"
#include "proxima/time_of_contact.h"
#include "proxima/triangle_mesh.h"

#include <random>

namespace proxima::testing {

inline Vec3 random_direction(std::mt19937_64& random)
{
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    return Vec3(x, y, normal(random) + 1e-3).normalized();
}

/// Turned at random.
inline RigidTransform random_pose(std::mt19937_64& random, const Vec3& translation)
{
    const Vec3 axis = random_direction(random);
    RigidTransform pose;
    pose.rotation = Eigen::AngleAxisd(std::uniform_real_distribution<double>(-3, 3)(random), axis)
                        .toRotationMatrix();
    pose.translation = translation;
    return pose;
}

class MotionGenerator {
public:
    MotionGenerator(const TriangleMesh& a, const TriangleMesh& b, std::uint64_t seed)
        : a_(bounding_box(a)), b_(bounding_box(b)), random_(seed),
          size_(0.5 * (a_.extent().norm() + b_.extent().norm()))
    {}

    RigidMotion operator()()
    {
        RigidMotion motion;
        motion.start = random_pose(random_, Vec3::Zero());
        motion.center = b_.center();
        const Vec3 from = (0.4 + unit()) * size_ * random_direction(random_);
        const Vec3 to = 0.5 * unit() * size_ * random_direction(random_);
        motion.start.translation = a_.center() + from - motion.start.rotation * b_.center();
        motion.displacement = (to - from) * (0.5 + 1.5 * unit());
        switch (random_() % 4) {
        case 0: // does not turn
            break;
        case 1: // several revolutions
            motion.turn = 30 * unit() * random_direction(random_);
            break;
        case 2: // about a point outside
            motion.turn = 2 * unit() * random_direction(random_);
            motion.center += size_ * random_direction(random_);
            motion.displacement *= 0.1;
            break;
        default:
            motion.turn = unit() * random_direction(random_);
        }
        return motion;
    }

private:
    double unit() { return std::uniform_real_distribution<double>()(random_); }

    Box a_;
    Box b_;
    std::mt19937_64 random_;
    double size_;
};

} // namespace proxima::testing
