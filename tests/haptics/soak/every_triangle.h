// All triangles of a mesh, each looked at in every question: what a proxy on the octree is held
// against, fast enough for every tick.
//
//     boxes    one for each triangle, six floats, rounded outward          no tree, no cells
//     first    the distance of every box, in floats, less their rounding
//     then     the triangles whose boxes are near enough, in doubles, as MeshContactSurface does
#pragma once

#include "haptics/surface/contact_surface.h"

#include <array>
#include <vector>

namespace proxima::soak {

/// The same answers as MeshContactSurface, bit for bit; 1 ns per triangle of the mesh. The mesh
/// must outlive it. One thread.
class EveryTriangle final : public ContactSurface {
public:
    explicit EveryTriangle(const TriangleMesh& mesh);

    [[nodiscard]] const SurfaceScale& scale() const noexcept override { return scale_; }
    [[nodiscard]] std::size_t collect(const Vec3& p, double distance,
                                      std::span<ContactTriangle> buffer) const noexcept override;
    [[nodiscard]] double clearance(const Vec3& p) const noexcept override;

private:
    static constexpr std::size_t group = 64;

    /// At most the squared distance of each box of a group.
    void bound(std::size_t first, const std::array<float, 3>& p,
               std::array<float, group>& squared) const noexcept;

    const TriangleMesh& mesh_;
    SurfaceScale scale_;
    std::size_t padded_ = 0;                  ///< triangles, up to whole groups
    std::array<std::vector<float>, 3> lower_; ///< by axis
    std::array<std::vector<float>, 3> upper_;
};

} // namespace proxima::soak
