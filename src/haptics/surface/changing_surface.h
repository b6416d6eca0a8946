// The surface of a mesh whose vertices are on their way from one position to another.
//
//     from  ·--------·--->  to        vertex = from + part (to - from)
//                  part
//
// A tree of boxes that hold a group's triangles at both ends holds them in between, too, and serves
// all parts of a motion.
#pragma once

#include "haptics/surface/contact_surface.h"
#include "haptics/surface/triangle_tree.h"
#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>

namespace proxima {

/// What a changing surface is made of; it refers to all of it.
struct ChangingParts {
    const TriangleMesh* from = nullptr;
    const TriangleMesh* to = nullptr;       ///< with the same triangles
    const TriangleTree* tree = nullptr;     ///< about both; null: every query tests every triangle
    std::span<const TriangleId> order = {}; ///< of the tree
    SurfaceScale scale = {};                ///< of both
};

/// Queries are noexcept, without allocation, from any thread; set() by one thread, while none queries.
class ChangingSurface final : public ContactSurface {
public:
    ChangingSurface() = default;
    ChangingSurface(const ChangingParts& parts, double part) { set(parts, part); }

    /// Moves the vertices. noexcept, O(1). \pre 0 <= part <= 1
    void set(const ChangingParts& parts, double part) noexcept;

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return parts_.scale; }
    /// About 1 us and 20 ns per triangle written.
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override;
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;
    [[nodiscard]] std::uint64_t edition() const noexcept override { return edition_; }

    /// A triangle where it is now. \pre set() was called; the id is in range
    [[nodiscard]] Triangle triangle(TriangleId id) const noexcept;

private:
    ChangingParts parts_;
    double part_ = 1;
    std::uint64_t edition_ = 0;
};

} // namespace proxima
