#include "proxima_peer.h"

#include "base/check.h"
#include "index/build_mesh_index.h"
#include "index/lists/build_lists.h"
#include "query/closest/closest_feature.h"

#include <vector>

namespace proxima::bench {
namespace {

class ProximaPeer {
public:
    explicit ProximaPeer(MeshIndex index) : index_(std::move(index)) {}

    [[nodiscard]] PeerAnswer closest(const Vec3& point) const
    {
        return answer_of(*closest_feature(index_, point));
    }

    /// A few at a time, so that its answers stay in the cache
    /// until they are taken over.
    void closest(std::span<const Vec3> points, std::span<PeerAnswer> answers)
    {
        for (std::size_t first = 0; first < points.size(); first += features_.size()) {
            const auto some =
                points.subspan(first, std::min(features_.size(), points.size() - first));
            const auto found = std::span(features_).first(some.size());
            const Status status = closest_features(index_, some, {.answers = found});
            PROXIMA_CHECK(status.has_value());
            std::ranges::transform(found, answers.begin() + static_cast<std::ptrdiff_t>(first),
                                   answer_of);
        }
    }

    [[nodiscard]] std::size_t bytes() const { return index_.bytes(); }

private:
    static PeerAnswer answer_of(const ClosestFeature& found)
    {
        return {found.squared_distance, found.triangle};
    }

    MeshIndex index_;
    std::vector<ClosestFeature> features_ = std::vector<ClosestFeature>(4096);
};

} // namespace

Result<std::unique_ptr<Contender>> make_proxima_peer(const TriangleMesh& mesh,
                                                     std::uint64_t bytes_per_triangle)
{
    const double start = nanoseconds_now();
    auto index = build_mesh_index(mesh, {.threads = {1}});
    if (index && bytes_per_triangle != 0) {
        index = with_lists(*index, {.budget_bytes = bytes_per_triangle * mesh.triangle_count(),
                                    .threads = {1}});
    }
    if (!index) return tl::unexpected(index.error());
    const double seconds = 1e-9 * (nanoseconds_now() - start);
    auto contender = make_contender<ProximaPeer>("proxima", std::move(*index));
    contender->build_seconds = seconds;
    return contender;
}

} // namespace proxima::bench
