// The place that a spring pulls the device to: as steady as proxy and device are.
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace proxima {
namespace {

using testing::HandPath;
using testing::TouchMesh;

struct HeldSteps {
    std::uint64_t touching = 0;
    std::uint64_t limited = 0; ///< ticks whose slide was out of moves
    double most = 0;           ///< of a step beyond the ways of proxy and device, in safety gaps
};

/// How far the spring's stretch changes beyond the ways of its two ends: |dF| <= K (|dp| + |dq|).
HeldSteps follow(const TriangleMesh& mesh, const ProxyOptions& options, std::uint32_t seed,
                 int ticks)
{
    const MeshContactSurface surface(mesh);
    Proxy proxy(surface, options);
    HandPath path(mesh, seed);
    Vec3 device = path.next();
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
        if (placed && last.has_room && now.has_room) {
            const double beyond = (stretch - last_stretch).norm() - way;
            steps.most = std::max(steps.most, beyond / safety_gap(surface.scale()));
        }
        steps.touching += now.hold != Hold::free ? 1U : 0U;
        steps.limited += now.slide.end == SlideEnd::limited ? 1U : 0U;
        device = next;
        last = now;
        last_stretch = stretch;
        placed = true;
    }
    return steps;
}

TEST(HeldPlace, steps_no_farther_than_proxy_and_device)
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
                EXPECT_LT(steps.most, 100) << named.name << ", radius " << radius << ", friction "
                                           << friction << ", seed " << seed;
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
TEST(HeldPlace, nothing_holds_a_proxy_on_a_free_way)
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
} // namespace proxima
