// The anchor, to which a spring pulls the device: as steady as proxy and device are.
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "proxima/haptic_renderer.h"

#include <Eigen/QR>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace proxima::anchor_test {
namespace {

using testing::HandPath;
using testing::TouchMesh;

/// How far the anchor may lie from a proxy that these contacts hold, in safety gaps.
double most_apart(const SlideResult& slide, bool is_point)
{
    // A slide settles within a quarter of the skin in which triangles count as touched, and a
    // skin is a sixteenth of a gap at most.
    constexpr double rounding = 0x1p-6;
    if (!is_point || slide.contact_count == 0) return rounding;
    // The spring pulls a point to the surface, where the walls that hold it meet. The proxy keeps
    // a gap from each of them.
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> normals(slide.contact_count, 3);
    for (std::size_t i = 0; i < slide.contact_count; ++i)
        normals.row(static_cast<Eigen::Index>(i)) = slide.contacts[i].normal.transpose();
    const Eigen::VectorXd gaps = Eigen::VectorXd::Ones(normals.rows());
    return rounding + normals.completeOrthogonalDecomposition().solve(gaps).norm();
}

/// Lengths are in safety gaps.
struct HeldSteps {
    std::uint64_t touching = 0;
    std::uint64_t limited = 0; ///< ticks whose slide was out of moves
    double beyond = 0;         ///< of a step: more than proxy, device and two gaps explain
    double apart = 0;          ///< of proxy and anchor: more than its gap explains
};

/// How far the spring's stretch changes beyond the ways of its two ends: |dF| <= K (|dp| + |dq|).
HeldSteps follow(const TriangleMesh& mesh, const ProxyOptions& options, std::uint32_t seed,
                 int ticks)
{
    const MeshContactSurface surface(mesh);
    const double gap = safety_gap(surface.scale());
    const bool is_point = options.radius <= gap;
    Proxy proxy(surface, options);
    HandPath path(mesh, seed);
    Vec3 device = path.next();
    SlideScratch scratch;
    // With friction the contacts of the proxy and of its frictionless position differ.
    const auto most_gaps = [&](const ProxyTick& tick, const Vec3& pulled_to) {
        const SlideResult own =
            pull_sphere(surface, options.radius, tick.proxy, pulled_to, scratch);
        return std::max(most_apart(tick.slide, is_point), most_apart(own, is_point));
    };
    proxy.place(device);
    ProxyTick last = proxy.last();
    Vec3 last_stretch = Vec3::Zero();
    bool placed = false;
    HeldSteps steps;
    for (int tick = 0; tick < ticks; ++tick) {
        const Vec3 next = path.next();
        const ProxyTick& now = proxy.follow(next);
        const Vec3 stretch = now.hold == Hold::free ? Vec3(Vec3::Zero()) : Vec3(now.anchor - next);
        const double way = (next - device).norm() + (now.proxy - last.proxy).norm();
        if (placed && last.is_placed && now.is_placed) {
            const double gaps = most_gaps(last, device) + most_gaps(now, next);
            const double beyond = ((stretch - last_stretch).norm() - way) / gap;
            steps.beyond = std::max(steps.beyond, beyond - gaps);
        }
        if (now.hold != Hold::free) {
            ++steps.touching;
            const double apart = (now.anchor - now.proxy).norm() / gap;
            steps.apart = std::max(steps.apart, apart - most_gaps(now, next));
        }
        steps.limited += now.slide.end == SlideEnd::limited ? 1U : 0U;
        device = next;
        last = now;
        last_stretch = stretch;
        placed = true;
    }
    return steps;
}

TEST(Anchor, MovesNoFartherThanProxyAndDevice)
{
    std::vector<TouchMesh> meshes = testing::touch_meshes();
    meshes.push_back({"fine sheet", testing::bumpy_sheet(40)});
    std::uint32_t seed = 40;
    HeldSteps sum;
    for (const TouchMesh& named : meshes) {
        const double size = MeshContactSurface(named.mesh).scale().extent;
        for (const double radius : {0.0, 0.01, 0.08}) {
            for (const double friction : {0.0, 0.4}) {
                const ProxyOptions options = {.radius = radius * size,
                                              .static_friction = friction,
                                              .dynamic_friction = 0.75 * friction,
                                              .max_moves = 4};
                const HeldSteps steps = follow(named.mesh, options, ++seed, 300);
                sum.touching += steps.touching;
                sum.limited += steps.limited;
                SCOPED_TRACE(::testing::Message()
                             << named.name << ", radius " << radius << ", friction " << friction
                             << ", seed " << seed);
                EXPECT_EQ(steps.beyond, 0);
                EXPECT_EQ(steps.apart, 0);
            }
        }
    }
    std::printf("%llu ticks of contact, %llu out of moves\n",
                static_cast<unsigned long long>(sum.touching),
                static_cast<unsigned long long>(sum.limited));
    EXPECT_GT(sum.touching, 5000U);
    EXPECT_GT(sum.limited, 500U);
}

// Nothing to hold it but its moves: it comes, however far the device has gone, and is free there.
TEST(Anchor, IsReleasedOnAFreePath)
{
    const TriangleMesh mesh = testing::bumpy_sheet(40);
    const MeshContactSurface surface(mesh);
    Proxy proxy(surface, {.static_friction = 0.4, .dynamic_friction = 0.3, .max_moves = 4});
    const Vec3 start(-0.9, 0.3, 0.2);
    proxy.place(start);
    const Vec3 device(0.9, 0.3, 0.2); // the ways to it are cut by what lies under them
    std::uint64_t late = 0;
    double left = (device - start).norm();
    for (int tick = 0; tick < 40; ++tick) {
        const ProxyTick& now = proxy.follow(device);
        if (now.hold == Hold::free) {
            EXPECT_EQ(now.proxy, device);
            EXPECT_EQ(now.anchor, device);
            continue;
        }
        ++late;
        EXPECT_EQ(now.hold, Hold::sliding);
        EXPECT_EQ(now.anchor, now.proxy);
        EXPECT_LT((device - now.proxy).norm(), left);
        left = (device - now.proxy).norm();
    }
    EXPECT_GT(late, 1U);
    EXPECT_EQ(proxy.last().hold, Hold::free);
}

} // namespace
} // namespace proxima::anchor_test
