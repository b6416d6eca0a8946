// An octree's statistics as the tables that people read.
#pragma once

#include "proxima/octree.h"

#include <string>

namespace proxima {

/// The thesis's columns, then the classes of the leaves and the size in memory.
[[nodiscard]] std::string statistics_text(const OctreeParameters& parameters,
                                          const OctreeStatistics& statistics);

} // namespace proxima
