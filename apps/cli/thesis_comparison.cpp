#include "cli/thesis_comparison.h"

#include <array>

namespace proxima {

std::span<const ThesisTable> thesis_tables() noexcept
{
    static constexpr std::array<ThesisTable, 5> tables = {
        {{"2.1", "Statistics for octree of the sphere (threshold 1)", compare_table_2_1},
         {"2.2", "Statistics for octree of the sphere (depth 5)", compare_table_2_2},
         {"2.3", "Octree statistics for various benchmark models (depth 5)", compare_table_2_3},
         {"3.2", "Summary of computational complexities", compare_table_3_2},
         {"3.3", "Elapsed time for generating the octree", compare_table_3_3}}};
    return tables;
}

} // namespace proxima
