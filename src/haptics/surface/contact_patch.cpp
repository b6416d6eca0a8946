#include "haptics/surface/contact_patch.h"

#include "base/check.h"
#include "haptics/surface/find_groups.h"
#include "proxima/closest_feature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

void ContactPatch::use_copies(std::size_t triangles, double extent) noexcept
{
    PROXIMA_CHECK_LE(triangles, copies_.size());
    groups_.make(std::span<const ContactTriangle>(copies_).first(triangles), extent);
    count_ = triangles;
    edition_ = new_edition();
}

void ContactPatch::read_triangles(std::span<const std::uint32_t> ranks,
                                  std::span<ContactTriangle> triangles) const noexcept
{
    // Another processor wrote them: prefetch all before the first is read.
    for (const std::uint32_t rank : ranks) {
        __builtin_prefetch(&copies_[rank]);
        __builtin_prefetch(reinterpret_cast<const std::byte*>(&copies_[rank]) + 64);
    }
    for (std::size_t i = 0; i < ranks.size(); ++i) triangles[i] = copies_[ranks[i]];
}

RingPatches::RingPatches(const MeshIndex& index, const TriangleMesh& mesh, const Topology& topology)
    : index_(index), mesh_(mesh), topology_(topology),
      extent_(bounding_box(mesh).extent().maxCoeff()), scratch_(mesh), ids_(ContactPatch::most)
{}

void RingPatches::fill(ContactPatch& patch, const Vec3& device, int depth) noexcept
{
    fill(patch, device, *closest_feature(index_, device), depth);
}

void RingPatches::fill(ContactPatch& patch, const Vec3& device, const ClosestFeature& closest,
                       int depth) noexcept
{
    const Neighbourhood found =
        collect_rings(mesh_, topology_, closest.feature, depth, scratch_, ids_);
    const std::size_t count = std::min(found.written, patch.copies().size());
    for (std::size_t i = 0; i < count; ++i) patch.copies()[i] = {mesh_.triangle(ids_[i]), ids_[i]};
    patch.use_copies(count, extent_);
    patch.complete = found.complete && count == found.written;
    patch.center = device;
    patch.clearance = std::sqrt(closest.squared_distance) * (1 - 0x1p-40);
}

std::size_t PatchContactSurface::collect(const Vec3& p, double distance,
                                         std::span<ContactTriangle> buffer) const noexcept
{
    if (is_empty()) return 0;
    std::size_t count = 0;
    const double squared = distance * distance;
    visit_within(patch_->tree(), {p, p}, squared, [&](RowRange found) noexcept {
        constexpr std::uint32_t width = TriangleTree::width;
        std::array<std::uint32_t, width> ranks{};
        std::array<ContactTriangle, width> triangles;
        for (std::uint32_t i = 0; i < found.count; ++i) ranks[i] = found.first + i;
        patch_->read_triangles(std::span(ranks).first(found.count), triangles);
        for (const ContactTriangle& triangle : std::span(triangles).first(found.count)) {
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
    return patch_->groups();
}

GroupQuery PatchContactSurface::group_query(const Vec3& p) const noexcept
{
    if (is_empty()) return {.position = p};
    return patch_->group_query(p);
}

void PatchContactSurface::find_groups(const Vec3& p, double distance,
                                      GroupBoxes& boxes) const noexcept
{
    boxes.count = 0;
    if (is_empty()) return;
    proxima::find_groups(patch_->tree(), p, distance, boxes);
}

void PatchContactSurface::read_triangles(std::span<const std::uint32_t> ranks,
                                         std::span<ContactTriangle> triangles) const noexcept
{
    patch_->read_triangles(ranks, triangles);
}

double PatchContactSurface::clearance(const Vec3& p) const noexcept
{
    if (patch_ == nullptr) return std::numeric_limits<double>::infinity();
    return patch_->clearance - (p - patch_->center).norm() * (1 + 0x1p-50);
}

} // namespace proxima
