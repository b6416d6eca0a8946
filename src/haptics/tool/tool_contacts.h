// The points at which a triangle of an object and one of the tool hold each other back.
//
//     vertex and face    edge and edge    vertex and edge    vertex and vertex
//
// A contact is where the distance of the two surfaces is least among near points: neighbours of a
// vertex or an edge are no nearer. So a tool that slides over the edges between triangles of one plane
// is not held back by them. Where edges cross, neighbours may be a little nearer: an edge of the tool
// that all but lies in a face touches both borders of that face, or each motion would turn it about the
// one into the other.
#pragma once

#include "haptics/tool/contact_features.h"
#include "haptics/tool/triangle_separation.h"
#include "proxima/geometry.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

struct FeatureContact {
    Vec3 scene_point = Vec3::Zero();
    Vec3 tool_point = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ(); ///< from the scene to the tool, of length 1
    double gap = 0;              ///< their distance
    std::uint32_t pair = 0;
    std::uint32_t object = 0;
    bool turns = false; ///< the normal is that of a face or edge of the tool, and turns with it
    Vec3 scene_edge = Vec3::Zero(); ///< of edges that cross: their directions, of length 1
    Vec3 tool_edge = Vec3::Zero();

    /// The gap between the features once the tool has turned about its origin and moved its point of
    /// the contact, the scene at rest: right to the second order where the same features touch.
    [[nodiscard]] double gap_after(const Mat3& turn, const Vec3& moved_point) const noexcept;
};

/// The features of an object, and where it is.
struct PlacedFeatures {
    const ContactFeatures* features = nullptr;
    RigidTransform pose = {};
};

/// Writes the contacts of the pair's own features that are at most `farthest` apart, as many as there
/// is room for. Returns how many were written. noexcept, no allocation.
[[nodiscard]] std::size_t find_contacts(const NearPair& pair, const PlacedFeatures& scene,
                                        const PlacedFeatures& tool, double farthest,
                                        std::span<FeatureContact> contacts) noexcept;

} // namespace proxima
