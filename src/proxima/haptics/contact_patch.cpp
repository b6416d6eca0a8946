#include "proxima/haptics/contact_patch.h"

#include "proxima/proximity/closest_feature.h"

#include <algorithm>
#include <cmath>

namespace proxima {

void fill_metric_patch(ContactPatch& patch, const ContactSurface& surface, const Vec3& device,
                       double radius) noexcept
{
    constexpr int attempts = 16;
    constexpr double shorter = 0.75; // half the triangles of a surface
    patch.reach = radius;
    std::size_t wanted = surface.collect(device, patch.reach, patch.room());
    for (int attempt = 0; attempt < attempts && wanted > patch.room().size(); ++attempt) {
        patch.reach *= shorter;
        wanted = surface.collect(device, patch.reach, patch.room());
    }
    if (wanted > patch.room().size()) patch.reach = 0;
    patch.count = std::min(wanted, patch.room().size());
    patch.complete = patch.reach >= radius;
    patch.center = device;
    patch.clearance = surface.clearance(device);
    patch.edition = new_edition();
}

RingPatches::RingPatches(const ProximityOctree& octree, const TriangleMesh& mesh,
                         const Topology& topology)
    : octree_(octree), mesh_(mesh), topology_(topology), scratch_(mesh), ids_(ContactPatch::most)
{}

void RingPatches::fill(ContactPatch& patch, const Vec3& device, int depth) noexcept
{
    const ClosestFeature closest = closest_feature(octree_, device);
    const Neighbourhood found =
        collect_rings(mesh_, topology_, closest.feature, depth, scratch_, ids_);
    const std::size_t count = std::min(found.count, patch.room().size());
    for (std::size_t i = 0; i < count; ++i) patch.room()[i] = {mesh_.triangle(ids_[i]), ids_[i]};
    patch.count = count;
    patch.complete = found.complete && count == found.count;
    patch.reach = 0;
    patch.center = device;
    patch.clearance = std::sqrt(closest.squared_distance) * (1 - 0x1p-40);
    patch.edition = new_edition();
}

std::size_t PatchContactSurface::collect(const Vec3& p, double distance,
                                         std::span<ContactTriangle> buffer) const noexcept
{
    if (patch_ == nullptr) return 0;
    std::size_t count = 0;
    for (const ContactTriangle& triangle : patch_->triangles()) {
        const Box box = bounding_box(triangle.corners);
        const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
        if (gap.squaredNorm() > distance * distance) continue;
        if (count < buffer.size()) buffer[count] = triangle;
        ++count;
    }
    return count;
}

double PatchContactSurface::clearance(const Vec3& p) const noexcept
{
    if (patch_ == nullptr) return std::numeric_limits<double>::infinity();
    return patch_->clearance - (p - patch_->center).norm() * (1 + 0x1p-50);
}

} // namespace proxima
