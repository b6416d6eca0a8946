#include "contact_peers.h"
#include "proxima/mesh_index.h"

#include <chrono>

namespace proxima::bench {
namespace {

class ProximaContactPeer final : public ContactPeer {
public:
    explicit ProximaContactPeer(const TriangleMesh& mesh)
    {
        const auto start = std::chrono::steady_clock::now();
        index_ = build_mesh_index(mesh, {.execution = {.threads = {1}}}).value();
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    [[nodiscard]] std::string name() const override { return "proxima"; }
    [[nodiscard]] double build_seconds() const override { return seconds_; }
    [[nodiscard]] bool intersects(const RigidTransform& pose) override
    {
        return meshes_intersect(index_, index_, pose);
    }
    std::size_t find_pairs(const RigidTransform& pose) override
    {
        pairs_ = intersecting_pairs(index_, index_, pose);
        return pairs_.size();
    }
    [[nodiscard]] std::vector<TrianglePair> sorted_pairs() const override { return pairs_; }

private:
    MeshIndex index_;
    double seconds_ = 0;
    std::vector<TrianglePair> pairs_;
};

} // namespace

std::unique_ptr<ContactPeer> make_proxima_contact_peer(const TriangleMesh& mesh)
{
    return std::make_unique<ProximaContactPeer>(mesh);
}

} // namespace proxima::bench
