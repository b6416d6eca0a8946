// Whether two solids have a point in common, asked in one pose after another.
#pragma once

#include "query/contacts/solid_parts.h"

namespace proxima {

class PROXIMA_HIDDEN SolidOverlap {
public:
    /// The parts must outlive it.
    SolidOverlap(const SolidParts& a, const SolidParts& b) : a_(a), b_(b) {}

    /// Exact. Starts from the pair of triangles that met last.
    [[nodiscard]] bool operator()(const RigidTransform& pose_b) noexcept;

private:
    const SolidParts& a_;
    const SolidParts& b_;
    MeshMeeting last_;
};

} // namespace proxima
