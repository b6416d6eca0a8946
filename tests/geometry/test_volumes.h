// View volumes that find what is wrong: frusta and boxes, wedges and slabs, needles, planes through
// corners and along faces, flat and contradictory ones, far away or around everything, of many
// planes, of any scale.
#pragma once

#include "proxima/view_volume.h"

#include "proxima/geometry.h"

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace proxima::testing {

/// Planes of small whole numbers.
inline std::vector<ViewPlane> whole_planes(std::mt19937_64& random, std::size_t count, int reach)
{
    const auto number = [&](int size) {
        return static_cast<double>(
            static_cast<int>(random() % static_cast<unsigned>(2 * size + 1)) - size);
    };
    std::vector<ViewPlane> planes(count);
    for (ViewPlane& plane : planes) {
        do {
            const double x = number(3);
            const double y = number(3);
            plane.normal = Vec3(x, y, number(3));
        } while (plane.normal.isZero(0));
        plane.offset = number(reach);
    }
    return planes;
}

/// Volumes about the points of a mesh.
class VolumeGenerator {
public:
    VolumeGenerator(std::span<const Vec3> points, std::uint64_t seed)
        : points_(points), random_(seed)
    {
        for (const Vec3& point : points) box_.extend(point);
        size_ = box_.extent().maxCoeff();
        if (!(size_ > 0)) size_ = std::max(box_.upper.cwiseAbs().maxCoeff(), 1e-3);
    }

    ViewVolume operator()()
    {
        std::vector<ViewPlane> planes = some_planes();
        if (below(4) == 0) {
            // The same planes by numbers of any size.
            for (ViewPlane& plane : planes) {
                const int shift = static_cast<int>(below(40)) - 20;
                plane.normal *= std::ldexp(1.0, shift);
                plane.offset *= std::ldexp(1.0, shift);
            }
        }
        return make_view_volume(planes).value();
    }

private:
    std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
    double unit() { return std::uniform_real_distribution<double>()(random_); }
    Vec3 direction()
    {
        const double x = 2 * unit() - 1;
        const double y = 2 * unit() - 1;
        return Vec3(x, y, 2 * unit() - 1 + 1e-3).normalized();
    }
    Vec3 some_point() { return points_[below(points_.size())]; }
    /// A corner, between corners, of the box, or around it.
    Vec3 place()
    {
        switch (below(4)) {
        case 0:
            return some_point();
        case 1:
            return 0.5 * some_point() + 0.5 * some_point();
        default: {
            const double reach = below(3) == 0 ? 3 : 1;
            const double x = unit() - 0.5;
            const double y = unit() - 0.5;
            return box_.center() + reach * size_ * Vec3(x, y, unit() - 0.5);
        }
        }
    }
    static ViewPlane through(const Vec3& point, const Vec3& normal)
    {
        return {normal, -normal.dot(point)};
    }
    static std::vector<ViewPlane> planes_of(const Result<ViewVolume>& volume)
    {
        return {volume->planes().begin(), volume->planes().end()};
    }

    std::vector<ViewPlane> some_planes()
    {
        switch (below(8)) {
        case 0:
        case 1: { // a pyramid from outside, a needle at times
            PerspectiveCamera camera;
            camera.eye = place();
            camera.forward = place() - camera.eye;
            if (camera.forward.isZero(0)) camera.forward = direction();
            camera.up = direction();
            camera.field_of_view = below(4) == 0 ? 1e-4 : 0.05 + 2.5 * unit();
            camera.near = size_ * std::ldexp(1.0, -static_cast<int>(below(12)));
            if (below(2) == 0) camera.far = camera.near + size_ * 3 * unit();
            return planes_of(make_perspective_volume(camera));
        }
        case 2: { // a box
            OrthographicCamera camera;
            camera.eye = place();
            camera.forward = direction();
            camera.up = direction();
            camera.width = size_ * (0.01 + unit());
            camera.height = size_ * (0.01 + unit());
            camera.near = below(2) == 0 ? 0 : -size_ * unit();
            camera.far = size_ * (0.01 + unit());
            return planes_of(make_orthographic_volume(camera));
        }
        case 3: { // a box along the axes, from corner to corner of the mesh
            const Vec3 a = some_point();
            const Vec3 b = some_point();
            std::vector<ViewPlane> planes;
            for (int axis = 0; axis < 3; ++axis) {
                planes.push_back({Vec3::Unit(axis), -std::min(a[axis], b[axis])});
                planes.push_back({-Vec3::Unit(axis), std::max(a[axis], b[axis])});
            }
            return planes;
        }
        case 4: { // any few planes, through corners often
            std::vector<ViewPlane> planes(1 + below(5));
            for (ViewPlane& plane : planes) plane = through(place(), direction());
            return planes;
        }
        case 5: { // a slab or a plane along an axis, through a corner
            const Vec3 normal = Vec3::Unit(static_cast<int>(below(3)));
            const ViewPlane plane = through(some_point(), normal);
            const double width = below(2) == 0 ? 0 : size_ * unit();
            return {plane, {-normal, -plane.offset + width}};
        }
        case 6: { // a ball of many planes
            const Vec3 middle = place();
            const double radius = size_ * (0.05 + unit());
            std::vector<ViewPlane> planes(5 + below(120));
            for (ViewPlane& plane : planes) {
                const Vec3 outward = direction();
                plane = through(middle + radius * outward, -outward);
            }
            return planes;
        }
        default: { // around everything, or far away
            const Vec3 outward = direction();
            const double distance = size_ * std::ldexp(1.0, static_cast<int>(below(40)));
            const double side = below(2) == 0 ? 1 : -1;
            return {through(box_.center() + distance * outward, -side * outward),
                    through(place(), direction())};
        }
        }
    }

    std::span<const Vec3> points_;
    std::mt19937_64 random_;
    Box box_;
    double size_ = 1;
};

} // namespace proxima::testing
