// What a run of questions took, for people.
#pragma once

#include "distributed/mesh_part.h"
#include "distributed/query_command.h"
#include "distributed/world.h"

#include <cstdint>
#include <string_view>

namespace proxima {

struct QueryTimes {
    double build_seconds = 0; ///< until the indexes are there
    double answer_seconds = 0;
    std::uint64_t build_bytes = 0; ///< sent by this rank until then
};

/// Prints them, and what each rank has, where rows do not go to stdout. Collective.
void report_queries(const QueryOptions& options, const MeshPart& part, std::uint64_t queries,
                    std::string_view what, const QueryTimes& times, const World& world);

} // namespace proxima
