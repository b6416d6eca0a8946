#include "cli/thesis_comparison.h"
namespace proxima {
Result<ThesisComparison> compare_table_3_2(const ThesisComparisonOptions&) { return ThesisComparison{}; }
}
