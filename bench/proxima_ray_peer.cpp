#include "proxima/cast_ray.h"
#include "proxima/mesh_index.h"
#include "ray_peers.h"

namespace proxima::bench {
namespace {

const RayBatchOptions one_thread{.execution = {.threads = {1}}};

class ProximaRayPeer final : public RayPeer {
public:
    explicit ProximaRayPeer(const TriangleMesh& mesh)
    {
        index_ = build_mesh_index(mesh, {.execution = {.threads = {1}}}).value();
    }
    [[nodiscard]] std::string name() const override { return "proxima"; }
    [[nodiscard]] std::size_t bytes() const override { return index_.bytes(); }
    void prepare(std::span<const Ray> rays, Coherence /*coherence*/) override
    {
        rays_ = rays;
        hits_.assign(rays.size(), std::nullopt);
        any_ = std::make_unique<bool[]>(rays.size());
    }
    void cast_closest() override
    {
        for (std::size_t i = 0; i < rays_.size(); ++i) hits_[i] = closest_hit(index_, rays_[i]);
    }
    void cast_closest_together() override { (void)closest_hits(index_, rays_, hits_, one_thread); }
    void cast_any() override
    {
        for (std::size_t i = 0; i < rays_.size(); ++i) any_[i] = any_hit(index_, rays_[i]);
    }
    void cast_any_together() override
    {
        (void)any_hits(index_, rays_, std::span(any_.get(), rays_.size()), one_thread);
    }
    [[nodiscard]] PeerHit hit(std::size_t ray) const override
    {
        if (!hits_[ray]) return {};
        return {to_index(hits_[ray]->triangle), hits_[ray]->t};
    }
    [[nodiscard]] bool was_hit(std::size_t ray) const override { return any_[ray]; }

private:
    MeshIndex index_;
    std::span<const Ray> rays_;
    std::vector<std::optional<RayHit>> hits_;
    std::unique_ptr<bool[]> any_;
};

} // namespace

std::unique_ptr<RayPeer> make_proxima_ray_peer(const TriangleMesh& mesh)
{
    return std::make_unique<ProximaRayPeer>(mesh);
}

} // namespace proxima::bench
