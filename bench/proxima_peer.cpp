#include "proxima_peer.h"

#include "base/check.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"

#include <optional>
#include <vector>

namespace proxima::bench {
namespace {

PeerAnswer answer_of(const ClosestFeature& found)
{
    return {found.squared_distance, found.triangle};
}

class ProximaPeer {
public:
    explicit ProximaPeer(const MeshIndex& index) : index_(index) {}

    [[nodiscard]] PeerAnswer closest(const Vec3& point) const
    {
        return answer_of(*closest_feature(index_, point));
    }
    void closest(std::span<const Vec3> points, std::span<PeerAnswer> answers)
    {
        features_.resize(points.size());
        const Status status = closest_features(index_, points, {.answers = features_},
                                               {.execution = {.threads = {1}}});
        PROXIMA_CHECK(status.has_value());
        std::ranges::transform(features_, answers.begin(), answer_of);
    }
    [[nodiscard]] std::size_t bytes() const { return index_.bytes(); }

private:
    MeshIndex index_;
    std::vector<ClosestFeature> features_; ///< kept for the next batch
};

/// Each query begins with the answer of the one before.
class WarmProximaPeer {
public:
    explicit WarmProximaPeer(const MeshIndex& index) : index_(index) {}

    [[nodiscard]] PeerAnswer closest(const Vec3& point)
    {
        last_ = *closest_feature(index_, point, {.start_from = last_ ? &*last_ : nullptr});
        return answer_of(*last_);
    }
    [[nodiscard]] std::size_t bytes() const { return index_.bytes(); }

private:
    MeshIndex index_;
    std::optional<ClosestFeature> last_;
};

/// Builds an index on one thread, with lists within a budget that is not 0, and times that.
template <class Peer>
Result<std::unique_ptr<Contender>> make_peer(const char* name, const TriangleMesh& mesh,
                                             std::uint64_t list_bytes)
{
    const double start = processor_seconds();
    auto index = build_mesh_index(mesh, {.execution = {.threads = {1}}});
    if (index && list_bytes != 0) {
        index = with_lists(*index, {.list_bytes = list_bytes, .execution = {.threads = {1}}});
    }
    if (!index) return tl::unexpected(index.error());
    const double seconds = processor_seconds() - start;
    auto contender = make_contender<Peer>(name, *index);
    contender->build_seconds = seconds;
    return contender;
}

} // namespace

Result<std::unique_ptr<Contender>> make_proxima_peer(const TriangleMesh& mesh,
                                                     std::uint64_t list_bytes_per_triangle)
{
    return make_peer<ProximaPeer>(list_bytes_per_triangle == 0 ? "tree" : "lists", mesh,
                                  list_bytes_per_triangle * mesh.triangle_count());
}

Result<std::unique_ptr<Contender>> make_warm_proxima_peer(const TriangleMesh& mesh)
{
    return make_peer<WarmProximaPeer>("tree-warm", mesh, 0);
}

} // namespace proxima::bench
