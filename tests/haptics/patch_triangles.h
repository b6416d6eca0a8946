// What is in a patch, for tests.
#pragma once

#include "haptics/surface/contact_patch.h"

#include <vector>

namespace proxima::testing {

inline std::vector<ContactTriangle> triangles_of(const ContactPatch& patch)
{
    std::vector<ContactTriangle> triangles(patch.count());
    patch.read(triangles);
    return triangles;
}

} // namespace proxima::testing
