#include "haptics/surface/patch_groups.h"

#include "base/simd.h"
#include "counted_allocations.h"
#include "geometry/closest_point.h"
#include "haptics/loop/patch_exchange.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"
#include "proxima/haptic_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>

namespace proxima::patch_groups_test {
namespace {

using testing::HandPath;
using testing::TouchMesh;

/// A patch of which every triangle is looked at in every question: what groups are held against.
class EveryTriangle final : public ContactSurface {
public:
    explicit EveryTriangle(const SurfaceScale& scale) : scale_(scale) {}
    void use(const ContactPatch* patch)
    {
        patch_ = patch;
        triangles_ = patch->triangles();
    }

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override
    {
        std::size_t count = 0;
        for (const ContactTriangle& triangle : triangles_) {
            const Vec3 closest = closest_point(triangle.corners, p).point;
            if ((closest - p).norm() > distance * (1 + 1e-12) + 1e-12 * scale_.reach) continue;
            if (count < buffer.size()) buffer[count] = triangle;
            ++count;
        }
        return count;
    }
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override
    {
        return patch_->clearance - (p - patch_->center).norm() * (1 + 0x1p-50);
    }

private:
    SurfaceScale scale_;
    const ContactPatch* patch_ = nullptr;
    std::span<const ContactTriangle> triangles_;
};

/// Two proxies on the same late patches, by groups and by every triangle.
void feel_both(const TouchMesh& named, int rings, double radius, std::uint32_t seed)
{
    const auto topology = *build_topology(named.mesh);
    const auto listed = *testing::listed_index(named.mesh);
    const IndexContactSurface whole(listed);
    const double size = whole.scale().extent;
    RingPatches made(listed, named.mesh, topology);
    PatchContactSurface grouped(whole.scale());
    EveryTriangle plain(whole.scale());
    const ProxyOptions options = {
        .radius = radius * size, .static_friction = 0.4, .dynamic_friction = 0.3};
    Proxy proxy(grouped, options);
    Proxy slow(plain, options);
    HandPath path(named.mesh, seed);
    ContactPatch patch;
    for (int tick = 0; tick < 60; ++tick) {
        const Vec3 device = path.next();
        if (tick % 10 == 0) {
            made.fill(patch, device, rings);
            grouped.use(&patch);
            plain.use(&patch);
        }
        if (tick == 0) {
            proxy.place(device);
            slow.place(device);
        }
        const ProxyTick& is = proxy.follow(device);
        const ProxyTick& should = slow.follow(device);
        const auto what = named.name + ", rings " + std::to_string(rings) + ", seed " +
                          std::to_string(seed) + ", tick " + std::to_string(tick);
        ASSERT_EQ(is.proxy, should.proxy) << what;
        ASSERT_EQ(is.anchor, should.anchor) << what;
        ASSERT_EQ(is.moves, should.moves) << what;
        ASSERT_EQ(is.hold, should.hold) << what;
    }
}

TEST(PatchGroups, AgreeWithAllTrianglesOfThePatchOnEveryInstructionSet)
{
    std::uint32_t seed = 20;
    for (const SimdTarget& target : simd_targets()) {
        force_simd_target(target);
        for (const TouchMesh& named : testing::touch_meshes()) {
            feel_both(named, 4, 0.0, ++seed);
            if (target.id == simd_targets().front().id) feel_both(named, 2, 0.01, ++seed);
        }
    }
    restore_simd_targets();
}

// Patches of all sizes, down to one triangle: nothing near is missing, and nothing is given twice.
TEST(PatchGroups, MissNoNearTriangle)
{
    std::uint64_t needed = 0;
    std::uint64_t given_in_all = 0;
    for (const TouchMesh& named : testing::touch_meshes()) {
        const MeshContactSurface whole(named.mesh);
        const double size = whole.scale().extent;
        PatchContactSurface surface(whole.scale());
        ContactPatch patch;
        std::vector<ContactTriangle> buffer(ContactPatch::most);
        HandPath path(named.mesh, 5);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> unit(0, 1);
        for (int round = 0; round < 25; ++round) {
            const Vec3 center = path.next();
            const double radius = unit(random) * unit(random) * size;
            std::size_t held = whole.collect(center, radius, patch.copies());
            if (round % 5 == 0) held = std::min<std::size_t>(held, 1 + random() % 20);
            patch.use_copies(held, size);
            const auto copy = std::make_unique<ContactPatch>(patch); // of its own groups
            surface.use(copy.get());
            EXPECT_EQ(surface.groups().size(), (held + 7) / 8);
            patch.use_copies(held, 2 * size);
            ContactCache cache;
            for (int question = 0; question < 12; ++question) {
                const Vec3 p = center + 0.4 * size * unit(random) *
                                            Vec3(unit(random) - 0.5, unit(random) - 0.5,
                                                 question % 3 == 0 ? 0.0 : 0.3);
                const double distance = 0.3 * size * unit(random);
                const bool direct = question % 2 == 0;
                const std::size_t count = direct ? surface.collect(p, distance, buffer)
                                                 : cache.collect(surface, p, distance, buffer);
                ASSERT_LE(count, buffer.size());
                std::set<TriangleId> given;
                for (const ContactTriangle& each : std::span(buffer).first(count)) {
                    given.insert(each.id);
                    EXPECT_EQ(each.corners[0], named.mesh.triangle(each.id)[0]);
                }
                EXPECT_EQ(given.size(), count) << named.name;
                given_in_all += count;
                for (const ContactTriangle& each : copy->triangles()) {
                    const Vec3 closest = closest_point(each.corners, p).point;
                    if ((closest - p).norm() > distance) continue;
                    ++needed;
                    EXPECT_TRUE(given.contains(each.id))
                        << named.name << ", round " << round << ", question " << question
                        << ", triangle " << to_index(each.id) << " of " << held;
                }
            }
        }
    }
    EXPECT_GT(needed, 10000U);
    EXPECT_LT(given_in_all, 2 * needed);
}

TEST(PatchGroups, AreFilledAndQueriedWithoutAllocation)
{
    const TriangleMesh mesh = *sample_mesh("sphere:60x60");
    const auto topology = *build_topology(mesh);
    const auto listed = *testing::listed_index(mesh);
    const IndexContactSurface whole(listed);
    RingPatches rings(listed, mesh, topology);
    PatchExchange exchange;
    PatchContactSurface surface(whole.scale());
    Proxy proxy(surface, {.static_friction = 0.4, .dynamic_friction = 0.3});
    HandPath path(mesh, 3);
    std::vector<Vec3> places;
    for (int i = 0; i < 1200; ++i) places.push_back(path.next());
    proxy.place(places.front());
    std::set<std::uint64_t> editions;
    std::size_t before = testing::allocation_count();
    std::uint64_t touching = 0;
    std::size_t largest = 0;
    for (std::size_t tick = 0; tick < places.size(); ++tick) {
        exchange.send_position({places[tick], proxy.last().proxy, tick});
        ServoPosition place;
        if (tick % 10 == 0 && exchange.receive_position(place)) {
            ContactPatch& patch = exchange.writing();
            rings.fill(patch, place.device, tick % 60 == 0 ? 60 : 4);
            exchange.publish_patch();
        }
        const ContactPatch* const patch = exchange.latest_patch();
        ASSERT_NE(patch, nullptr);
        surface.use(patch);
        touching += proxy.follow(places[tick]).hold != Hold::free ? 1U : 0U;
        largest = std::max(largest, patch->count());
        if (tick % 10 != 0) continue;
        EXPECT_EQ(testing::allocation_count(), before) << tick;
        EXPECT_TRUE(editions.insert(surface.edition()).second) << tick;
        before = testing::allocation_count();
    }
    EXPECT_GT(touching, 50U);
    EXPECT_EQ(largest, mesh.triangle_count()); // a patch may be all there is
}

} // namespace
} // namespace proxima::patch_groups_test
