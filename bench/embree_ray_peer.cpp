#include "base/check.h"
#include "ray_peers.h"

#include <embree3/rtcore.h>

#include <atomic>

namespace proxima::bench {
namespace {

bool count_memory(void* total, ssize_t bytes, bool /*after*/)
{
    *static_cast<std::atomic<std::ptrdiff_t>*>(total) += bytes;
    return true;
}

class EmbreeRayPeer final : public RayPeer {
public:
    EmbreeRayPeer(const TriangleMesh& mesh, EmbreeMode mode)
        : mode_(mode), device_(rtcNewDevice("threads=1"))
    {
        PROXIMA_CHECK(device_ != nullptr);
        rtcSetDeviceMemoryMonitorFunction(device_, count_memory, &bytes_);
        scene_ = rtcNewScene(device_);
        if (mode == EmbreeMode::robust) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        auto* const geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        constexpr std::size_t stride = 12;
        auto* const positions = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, stride, mesh.vertex_count()));
        auto* const corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, stride, mesh.triangle_count()));
        for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                positions[3 * i + k] =
                    static_cast<float>(mesh.positions()[i][static_cast<Eigen::Index>(k)]);
            }
        }
        for (std::size_t i = 0; i < mesh.triangle_count(); ++i)
            for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = mesh.triangles()[i][k];
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
        PROXIMA_CHECK_EQ(static_cast<int>(rtcGetDeviceError(device_)), int{RTC_ERROR_NONE});
    }
    ~EmbreeRayPeer() override
    {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    EmbreeRayPeer(const EmbreeRayPeer&) = delete;
    EmbreeRayPeer& operator=(const EmbreeRayPeer&) = delete;

    [[nodiscard]] std::string name() const override
    {
        return mode_ == EmbreeMode::robust ? "embree robust" : "embree fast";
    }
    [[nodiscard]] std::size_t bytes() const override { return static_cast<std::size_t>(bytes_); }

    void prepare(std::span<const Ray> rays, Coherence coherence) override
    {
        flags_ = coherence == Coherence::coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                  : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
        hits_.assign(rays.size(), RTCRayHit{});
        for (std::size_t i = 0; i < rays.size(); ++i) {
            RTCRay& ray = hits_[i].ray;
            const Eigen::Vector3f o = rays[i].origin.cast<float>();
            const Eigen::Vector3f d = rays[i].direction.cast<float>();
            ray.org_x = o.x(), ray.org_y = o.y(), ray.org_z = o.z();
            ray.dir_x = d.x(), ray.dir_y = d.y(), ray.dir_z = d.z();
            ray.tfar = std::numeric_limits<float>::infinity();
            ray.mask = ~0U;
            hits_[i].hit.geomID = RTC_INVALID_GEOMETRY_ID;
            hits_[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        }
        rays_.clear();
        for (const RTCRayHit& at : hits_) rays_.push_back(at.ray);
    }
    void cast_closest() override
    {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (RTCRayHit& at : hits_) rtcIntersect1(scene_, &context, &at);
    }
    void cast_closest_together() override
    {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = flags_;
        rtcIntersect1M(scene_, &context, hits_.data(), static_cast<unsigned>(hits_.size()),
                       sizeof(hits_[0]));
    }
    void cast_any() override
    {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (RTCRay& ray : rays_) rtcOccluded1(scene_, &context, &ray);
    }
    void cast_any_together() override
    {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = flags_;
        rtcOccluded1M(scene_, &context, rays_.data(), static_cast<unsigned>(rays_.size()),
                      sizeof(rays_[0]));
    }
    [[nodiscard]] PeerHit hit(std::size_t ray) const override
    {
        const RTCRayHit& at = hits_[ray];
        if (at.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        return {at.hit.primID, static_cast<double>(at.ray.tfar)};
    }
    [[nodiscard]] bool was_hit(std::size_t ray) const override { return rays_[ray].tfar < 0; }

private:
    EmbreeMode mode_;
    std::atomic<std::ptrdiff_t> bytes_ = 0;
    RTCDevice device_;
    RTCScene scene_ = nullptr;
    RTCIntersectContextFlags flags_ = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    std::vector<RTCRayHit> hits_;
    std::vector<RTCRay> rays_;
};

} // namespace

std::unique_ptr<RayPeer> make_embree_ray_peer(const TriangleMesh& mesh, EmbreeMode mode)
{
    return std::make_unique<EmbreeRayPeer>(mesh, mode);
}

} // namespace proxima::bench
