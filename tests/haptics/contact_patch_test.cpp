#include "haptics/surface/contact_patch.h"

#include "haptics/loop/patch_exchange.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <limits>
#include <thread>

namespace proxima::contact_patch_test {
namespace {

/// A hand that never goes faster than `speed` along a path that does.
class SlowHand {
public:
    SlowHand(const TriangleMesh& mesh, std::uint32_t seed, double way)
        : path_(mesh, seed), way_(way), at_(path_.next()), goal_(at_)
    {}
    Vec3 next()
    {
        while ((goal_ - at_).norm() < way_) goal_ = path_.next();
        at_ += (goal_ - at_).normalized() * way_;
        return at_;
    }

private:
    testing::HandPath path_;
    double way_;
    Vec3 at_;
    Vec3 goal_;
};

/// Ticks in which a proxy on late patches and one on the whole surface differed, and of these
/// whether a contact's triangle was not in the patch.
struct Misses {
    std::uint64_t touching = 0;
    std::uint64_t missing = 0; ///< contacts of the whole surface's proxy not in the patch
    std::size_t largest = 0;   ///< triangles of a patch
};

Misses follow(const TriangleMesh& mesh, int depth, std::uint32_t seed, int ticks)
{
    const auto topology = *build_topology(mesh);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface whole(listed);
    // The model is 0.12 m long on the device; the hand goes at 1 m/s.
    const double speed = whole.scale().extent / 0.12;
    constexpr double servo_seconds = 1e-3;
    constexpr int servo_ticks = 10; // per collision tick, and as late is a patch
    RingPatches rings(listed, mesh, topology);
    std::array<ContactPatch, 2> patches;
    std::size_t making = 0;
    PatchContactSurface late(whole.scale());
    Proxy proxy(late, {});
    Proxy expected(whole, {});
    SlowHand hand(mesh, seed, speed * servo_seconds);
    Misses misses;
    Vec3 device = hand.next();
    const auto make = [&] { rings.fill(patches[making], device, depth); };
    expected.place(device);
    proxy.place(expected.last().proxy);
    make();
    late.use(&patches[making]);
    for (int tick = 0; tick < ticks; ++tick) {
        if (tick % servo_ticks == 0) {
            late.use(&patches[making]); // the one that was made a collision tick ago
            making = 1 - making;
            make();
        }
        device = hand.next();
        const ProxyTick& should = expected.follow(device);
        const ProxyTick& is = proxy.follow(device);
        const ContactPatch& used = patches[1 - making];
        const auto there = used.triangles();
        misses.largest = std::max(misses.largest, there.size());
        EXPECT_TRUE(used.complete);
        misses.touching += should.hold != Hold::free ? 1U : 0U;
        for (std::size_t i = 0; i < should.slide.contact_count; ++i) {
            const TriangleId id = should.slide.contacts[i].triangle;
            const bool has_it = std::ranges::any_of(
                there, [&](const ContactTriangle& each) { return each.id == id; });
            misses.missing += has_it ? 0U : 1U;
        }
        if (is.proxy == should.proxy) continue;
        proxy.place(should.proxy); // on with both together
    }
    return misses;
}

TEST(ContactPatch, RingsMissContactsBeyondTheirReach)
{
    const TriangleMesh mesh = *sample_mesh("torus:60x30");
    std::uint64_t before = 1U << 30U;
    for (const int depth : {1, 3, 6}) {
        const Misses misses = follow(mesh, depth, 7, 1500);
        std::printf("rings %d: %llu contacts missed in %llu touching ticks, patches of up to %zu\n",
                    depth, static_cast<unsigned long long>(misses.missing),
                    static_cast<unsigned long long>(misses.touching), misses.largest);
        EXPECT_LT(misses.missing, before) << depth;
        before = misses.missing;
        if (depth == 1) {
            EXPECT_GT(misses.missing, 0U);
        }
    }
}

TEST(ContactPatch, NothingIsTouchedWithoutAPatch)
{
    const PatchContactSurface surface(SurfaceScale{});
    std::array<ContactTriangle, 4> buffer;
    EXPECT_EQ(surface.collect(Vec3::Zero(), 1e9, buffer), 0U);
    EXPECT_EQ(surface.clearance(Vec3::Zero()), std::numeric_limits<double>::infinity());
}

TEST(ContactPatch, ReportsThatItIsIncomplete)
{
    const TriangleMesh mesh = *sample_mesh("sphere:100x100");
    const auto topology = *build_topology(mesh);
    const auto listed = *testing::listed_index(mesh);
    RingPatches rings(listed, mesh, topology);
    ContactPatch patch;
    rings.fill(patch, Vec3(0, 0, 1.5), 3);
    EXPECT_TRUE(patch.complete);
    EXPECT_LT(patch.count(), ContactPatch::most);
    rings.fill(patch, Vec3(0, 0, 1.5), 80);
    EXPECT_FALSE(patch.complete);
    EXPECT_EQ(patch.count(), ContactPatch::most);
}

TEST(PatchExchange, HandsOverPatchesWhileAServoRuns)
{
    const TriangleMesh mesh = *sample_mesh("torus:24x12");
    const auto topology = *build_topology(mesh);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface whole(listed);
    PatchExchange exchange;
    PatchContactSurface late(whole.scale());
    Proxy proxy(late, {});
    SlowHand hand(mesh, 3, 0.002);
    Vec3 device = hand.next();
    proxy.place(device);
    std::uint64_t with_patch = 0;
    std::uint64_t inconsistent = 0;
    std::atomic<bool> ending{false};
    std::uint64_t made = 0;
    std::thread collision([&] {
        RingPatches rings(listed, mesh, topology);
        while (!ending) {
            ServoPosition position;
            if (exchange.receive_position(position)) {
                rings.fill(exchange.writing(), position.device, 4);
                exchange.writing().made_at = position.tick;
                exchange.publish_patch();
                ++made;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    });
    const ServoStatistics seen = run_servo_loop({.ticks = 400}, [&](std::uint64_t tick) {
        device = hand.next();
        exchange.send_position({device, proxy.last().proxy, tick});
        const ContactPatch* const patch = exchange.latest_patch();
        late.use(patch);
        proxy.follow(device);
        if (patch == nullptr) return Flow::proceed;
        ++with_patch;
        for (const ContactTriangle& each : patch->triangles())
            inconsistent += each.corners[0] == mesh.triangle(each.id)[0] ? 0U : 1U;
        return Flow::proceed;
    });
    ending = true;
    collision.join();
    EXPECT_EQ(seen.ticks, 400U);
    EXPECT_GE(made, 5U);
    EXPECT_GT(with_patch, 100U);
    EXPECT_EQ(inconsistent, 0U);
}

} // namespace
} // namespace proxima::contact_patch_test
