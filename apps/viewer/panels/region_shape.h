// The shape of a feature's Voronoi region in any mesh, up to a given length. The region ends where
// another feature is equally near. Where it continues beyond that length, its shape fades.
//
//     cone of the feature's own faces          a corner: a point of the feature and a direction;
//     (local_cone.h)                           a face's three have one direction, a vertex's one
//          d0 ^     ^ d1                       point
//             |_____|
//            b0     b1                         a sample between the corners goes as far as the
//                                              feature is the closest of all: an answer of the
//                                              octree at every step of a search
//
// The samples describe the whole region: with each of its points it contains the segment from there
// to the nearest point of the feature. Where the surface bends inward, the region lies behind it
// and has no part outside. At a saddle there is no region.
#pragma once

#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "viewer/panels/local_cone.h"
#include "viewer/scene.h"
#include "viewer/view_models.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// A half-line of the region, cut off.
struct RegionSample {
    Vec3 base = Vec3::Zero();      ///< of the feature
    Vec3 direction = Vec3::Zero(); ///< of length 1
    double reach = 0.0;            ///< so far the feature is the closest one
    bool goes_on = true;           ///< farther than it was asked for

    [[nodiscard]] Vec3 at(double length) const { return base + length * direction; }
    [[nodiscard]] Vec3 end() const { return at(reach); }
};

struct RegionShape {
    ConeShape shape = ConeShape::empty;
    ConeSide side = ConeSide::outside;
    std::vector<RegionSample> samples;  ///< none of an empty region, one of a line
    std::vector<std::uint32_t> borders; ///< samples where two sides meet, or a side ends
    std::vector<TriangleCorners> cap;   ///< of samples: over the ends; none of flat regions
    std::vector<std::vector<std::uint32_t>> sides; ///< samples in a row, from corner to corner
};

/// The part of the feature's region that is at most `length` away from the feature. The errors are those of
/// local_cone, and cancelled. Takes about a thousand queries per corner of the cone. \pre the index is
/// the model's, length > 0
[[nodiscard]] Result<RegionShape> region_shape(const ViewModel& model, const MeshIndex& with,
                                               Feature feature, double length,
                                               const Progress* progress = nullptr);

/// The surfaces "region" and the lines "region's edges".
void add_region(DrawnScene& scene, const RegionShape& shape, const Color& color);

/// "drawn", or what is to be known of it: that it is flat, behind the surface, or empty.
[[nodiscard]] std::string words_for_region(const RegionShape& shape);

/// How far away another feature is as near: "0.01 to 0.03 away", or that there is none. \pre it is not empty
[[nodiscard]] std::string words_for_end(const RegionShape& shape);

} // namespace proxima
