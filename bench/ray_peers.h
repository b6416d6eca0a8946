// What casts rays in ray_bench: ours and Embree 3, fast and robust, single rays and batches.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace proxima::bench {

struct PeerHit {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    std::uint32_t triangle = none;
    double t = std::numeric_limits<double>::infinity();
};

/// Whether neighbours of a set go the same way.
enum class Coherence : std::uint8_t { coherent, incoherent };

/// One way to cast; prepared for a set by prepare(), so that conversions are not timed.
class RayPeer {
public:
    RayPeer() = default;
    RayPeer(const RayPeer&) = delete;
    RayPeer& operator=(const RayPeer&) = delete;
    virtual ~RayPeer() = default;

    [[nodiscard]] virtual std::string name() const = 0;
    [[nodiscard]] virtual std::size_t bytes() const = 0;
    virtual void prepare(std::span<const Ray> rays, Coherence coherence) = 0;
    /// The closest hits, ray by ray and as a batch; any hits. To be read by hit() and was_hit().
    virtual void cast_closest() = 0;
    virtual void cast_closest_together() = 0;
    virtual void cast_any() = 0;
    virtual void cast_any_together() = 0;
    [[nodiscard]] virtual PeerHit hit(std::size_t ray) const = 0;
    [[nodiscard]] virtual bool was_hit(std::size_t ray) const = 0;
};

[[nodiscard]] std::unique_ptr<RayPeer> make_proxima_ray_peer(const TriangleMesh& mesh);

enum class EmbreeMode : std::uint8_t { fast, robust };
[[nodiscard]] std::unique_ptr<RayPeer> make_embree_ray_peer(const TriangleMesh& mesh,
                                                            EmbreeMode mode);

} // namespace proxima::bench
