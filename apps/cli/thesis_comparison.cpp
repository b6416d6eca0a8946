#include "cli/thesis_comparison.h"

#include <array>

namespace proxima {

std::span<const ThesisTable> thesis_tables() noexcept
{
    static constexpr std::array<ThesisTable, 7> tables = {
        {{"2.1", "Statistics for octree of the sphere (threshold 1)", compare_table_2_1},
         {"2.2", "Statistics for octree of the sphere (depth 5)", compare_table_2_2},
         {"2.3", "Octree statistics for various benchmark models (depth 5)", compare_table_2_3},
         {"3.2", "Summary of computational complexities", compare_table_3_2},
         {"3.3", "Elapsed time for generating the octree", compare_table_3_3},
         {"5", "Queries by the thesis's structures, beside the mesh index", compare_queries},
         {"5.1", "Adjacency depths that suffice, by the speed of the hand",
          compare_adjacency_depths}}};
    return tables;
}

} // namespace proxima
