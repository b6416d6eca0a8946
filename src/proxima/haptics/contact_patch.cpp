#include "proxima/haptics/contact_patch.h"

#include "proxima/haptics/find_groups.h"
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
    patch.make_groups(surface.scale().extent);
    patch.edition = new_edition();
}

RingPatches::RingPatches(const ProximityOctree& octree, const TriangleMesh& mesh,
                         const Topology& topology)
    : octree_(octree), mesh_(mesh), topology_(topology),
      extent_(bounding_box(mesh).extent().maxCoeff()), scratch_(mesh), ids_(ContactPatch::most)
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
    patch.make_groups(extent_);
    patch.edition = new_edition();
}

std::size_t PatchContactSurface::collect(const Vec3& p, double distance,
                                         std::span<ContactTriangle> buffer) const noexcept
{
    if (is_empty()) return 0;
    std::size_t count = 0;
    const double squared = distance * distance;
    visit_within(patch_->groups().tree(), {p, p}, squared, [&](RankRange ranks) noexcept {
        for (const ContactTriangle& triangle :
             patch_->triangles().subspan(ranks.first, ranks.count)) {
            const Box box = bounding_box(triangle.corners);
            const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
            if (gap.squaredNorm() > squared) continue;
            if (count < buffer.size()) buffer[count] = triangle;
            ++count;
        }
    });
    return count;
}

std::span<const TriangleGroup> PatchContactSurface::groups() const noexcept
{
    if (is_empty()) return {};
    return patch_->groups().groups();
}

GroupQuery PatchContactSurface::group_query(const Vec3& p) const noexcept
{
    if (is_empty()) return {.place = p};
    return patch_->groups().query(p);
}

void PatchContactSurface::find_groups(const Vec3& p, double distance,
                                      GroupBoxes& boxes) const noexcept
{
    boxes.count = 0;
    if (!is_empty()) proxima::find_groups(patch_->groups().tree(), p, distance, boxes);
}

void PatchContactSurface::read_triangles(std::span<const std::uint32_t> ranks,
                                         std::span<ContactTriangle> triangles) const noexcept
{
    // Another processor wrote them: all are sent for before the first is read.
    const std::span<const ContactTriangle> all = patch_->triangles();
    for (const std::uint32_t rank : ranks) {
        __builtin_prefetch(&all[rank]);
        __builtin_prefetch(reinterpret_cast<const std::byte*>(&all[rank]) + 64);
    }
    for (std::size_t i = 0; i < ranks.size(); ++i) triangles[i] = all[ranks[i]];
}

double PatchContactSurface::clearance(const Vec3& p) const noexcept
{
    if (patch_ == nullptr) return std::numeric_limits<double>::infinity();
    return patch_->clearance - (p - patch_->center).norm() * (1 + 0x1p-50);
}

} // namespace proxima
