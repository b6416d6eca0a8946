// Patches as the thesis's collision loop makes them (thesis section 5.1.1): the triangles within an
// adjacency depth of the feature that the thesis's proximity octree finds closest.
#pragma once

#include "haptics/surface/contact_patch.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <optional>

namespace proxima {

/// One thread.
class ThesisPatches {
public:
    /// Refers to all, which must outlive it. \pre the octree was built from the mesh
    ThesisPatches(const ThesisProximityOctree& octree, const TriangleMesh& mesh,
                  const Topology& topology, RingPatches& rings) noexcept
        : octree_(octree), root_(cell_box(octree.frame(), CellKey{})), mesh_(mesh),
          topology_(topology), rings_(rings)
    {}

    /// Fills a patch around the feature closest to the device. The thesis's octree has no answer
    /// inside the mesh or outside the root: then the point of the root closest to the proxy is asked
    /// for, which is on the surface or, in free space, where the device is; and then the last feature
    /// found serves. Returns false, and leaves the patch alone, before any feature was found.
    /// noexcept, no allocation. \pre device and proxy are finite, depth >= 0
    bool fill(ContactPatch& patch, const Vec3& device, const Vec3& proxy, int depth) noexcept;

private:
    const ThesisProximityOctree& octree_;
    Box root_; ///< its
    const TriangleMesh& mesh_;
    const Topology& topology_;
    RingPatches& rings_;
    std::optional<ClosestFeature> last_;
};

} // namespace proxima
