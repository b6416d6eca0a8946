// The two programs of docs/coming_from.md for those who know Embree.
#include "coming_from/arrays.h"
#include "proxima/cast_ray.h"

#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace proxima::embree_test {
namespace {

using testing::Arrays;

float by_embree(const Arrays& mesh, float x, float y)
{
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh.points.data(), 0, 12, mesh.points.size() / 3);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.corners.data(), 0, 12, mesh.corners.size() / 3);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);

    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    ray.ray.org_x = x, ray.ray.org_y = y, ray.ray.org_z = 5;
    ray.ray.dir_z = -1;
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = ~0U;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &ray);
    if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID)
        std::printf("%g, triangle %u\n", ray.ray.tfar, ray.hit.primID);
    rtcReleaseGeometry(geometry);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return ray.ray.tfar;
}

double by_proxima(const TriangleMesh& mesh, double x, double y)
{
    const MeshIndex index = build_mesh_index(mesh).value();
    const auto hit = closest_hit(index, {.origin = Vec3(x, y, 5), .direction = Vec3(0, 0, -1)});
    if (hit) std::printf("%g, triangle %u\n", hit->t, to_index(hit->triangle));
    return hit.value_or(RayHit{}).t;
}

TEST(ComingFromEmbree, TheSameRaysHitTheSame)
{
    const Arrays arrays = testing::arrays_of("icosphere:3");
    const TriangleMesh mesh = mesh_of(arrays);
    for (const float x : {-0.6F, -0.31F, 0.1F, 0.53F}) {
        for (const float y : {-0.5F, 0.2F, 0.45F}) {
            const double t = by_proxima(mesh, x, y);
            EXPECT_NEAR(t, by_embree(arrays, x, y), 1e-5) << x << ' ' << y;
            EXPECT_NEAR(t, 5 - std::sqrt(1 - x * x - y * y), 0.01) << x << ' ' << y;
        }
    }
}

} // namespace
} // namespace proxima::embree_test
