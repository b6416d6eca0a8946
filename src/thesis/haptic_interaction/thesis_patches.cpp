#include "thesis/haptic_interaction/thesis_patches.h"

#include "thesis/proximity_octree/thesis_closest.h"

namespace proxima {

bool ThesisPatches::fill(ContactPatch& patch, const Vec3& device, const Vec3& proxy,
                         int depth) noexcept
{
    if (const auto closest = closest_feature(octree_, mesh_, topology_, device)) {
        last_ = closest;
        rings_.fill(patch, device, *closest, depth);
        return true;
    }
    // A proxy on the surface is on either side of it by rounding: asked for a little farther out. A
    // free one is where the device is, which may be outside the root.
    const Vec3 farther = proxy + 0x1p-20 * (proxy - device);
    const Vec3 before = farther.cwiseMax(root_.lower).cwiseMin(root_.upper);
    if (const auto closest = closest_feature(octree_, mesh_, topology_, before)) last_ = closest;
    if (!last_) return false;
    // Nothing is known of the device's own distance.
    ClosestFeature around = *last_;
    around.squared_distance = 0;
    rings_.fill(patch, device, around, depth);
    return true;
}

} // namespace proxima
