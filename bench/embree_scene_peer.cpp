#include "base/check.h"
#include "scene_peers.h"

#include <embree3/rtcore.h>

#include <array>
#include <limits>

namespace proxima::bench {
namespace {

/// Instances of one scene of triangles, which is static and built with high quality.
class EmbreeScenePeer final : public ScenePeer {
public:
    EmbreeScenePeer(const TriangleMesh& mesh, EmbreeTraversal traversal, EmbreeTopLevel top_level)
        : traversal_(traversal == EmbreeTraversal::robust ? RTC_SCENE_FLAG_ROBUST
                                                          : RTC_SCENE_FLAG_NONE),
          dynamic_(top_level == EmbreeTopLevel::dynamic_low_quality),
          device_(rtcNewDevice("threads=1"))
    {
        PROXIMA_CHECK(device_ != nullptr);
        shape_ = rtcNewScene(device_);
        rtcSetSceneFlags(shape_, traversal_);
        rtcSetSceneBuildQuality(shape_, RTC_BUILD_QUALITY_HIGH);
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
        rtcAttachGeometry(shape_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(shape_);
    }
    ~EmbreeScenePeer() override
    {
        release();
        rtcReleaseScene(shape_);
        rtcReleaseDevice(device_);
    }
    EmbreeScenePeer(const EmbreeScenePeer&) = delete;
    EmbreeScenePeer& operator=(const EmbreeScenePeer&) = delete;

    [[nodiscard]] std::string name() const override
    {
        const std::string name =
            traversal_ == RTC_SCENE_FLAG_ROBUST ? "embree robust" : "embree fast";
        return name + (dynamic_ ? ", dynamic low" : ", static high");
    }

    void prepare_build(std::span<const RigidTransform> /*poses*/) override { release(); }
    void build(std::span<const RigidTransform> poses) override
    {
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, dynamic_ ? traversal_ | RTC_SCENE_FLAG_DYNAMIC : traversal_);
        rtcSetSceneBuildQuality(scene_, dynamic_ ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_HIGH);
        for (const RigidTransform& pose : poses) {
            auto* const instance = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetGeometryInstancedScene(instance, shape_);
            set_pose(instance, pose);
            rtcAttachGeometry(scene_, instance);
            instances_.push_back(instance);
        }
        rtcCommitScene(scene_);
        PROXIMA_CHECK_EQ(static_cast<int>(rtcGetDeviceError(device_)), int{RTC_ERROR_NONE});
    }
    void move(std::span<const RigidTransform> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) set_pose(instances_[i], poses[i]);
        rtcCommitScene(scene_);
    }
    [[nodiscard]] bool casts_rays() const override { return true; }
    /// A cast shortens the rays that hit.
    void prepare_rays(std::span<const Ray> rays) override
    {
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
    }
    void cast_rays() override
    {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (RTCRayHit& at : hits_) rtcIntersect1(scene_, &context, &at);
    }
    [[nodiscard]] SceneRayAnswer answer(std::size_t ray) const override
    {
        const RTCRayHit& at = hits_[ray];
        if (at.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        return {at.hit.instID[0], at.hit.primID, static_cast<double>(at.ray.tfar)};
    }

private:
    static void set_pose(RTCGeometry instance, const RigidTransform& pose)
    {
        std::array<float, 12> columns{};
        std::size_t filled = 0;
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 3; ++row) {
                columns[filled++] = static_cast<float>(column < 3 ? pose.rotation(row, column)
                                                                  : pose.translation[row]);
            }
        }
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
        rtcCommitGeometry(instance);
    }
    void release()
    {
        for (auto* const instance : instances_) rtcReleaseGeometry(instance);
        instances_.clear();
        if (scene_ != nullptr) rtcReleaseScene(scene_);
        scene_ = nullptr;
    }

    RTCSceneFlags traversal_;
    bool dynamic_;
    RTCDevice device_;
    RTCScene shape_ = nullptr;
    RTCScene scene_ = nullptr;
    std::vector<RTCGeometry> instances_;
    std::vector<RTCRayHit> hits_;
};

} // namespace

std::unique_ptr<ScenePeer> make_embree_scene_peer(const TriangleMesh& mesh,
                                                  EmbreeTraversal traversal,
                                                  EmbreeTopLevel top_level)
{
    return std::make_unique<EmbreeScenePeer>(mesh, traversal, top_level);
}

} // namespace proxima::bench
