// The thesis's tables, measured here and set beside its values.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

struct ThesisComparisonOptions {
    std::string meshes; ///< folder with the models of Table 2.3, empty where none is known
    Threads threads_to_measure = {1}; ///< for Table 3.3
    bool as_printed = false;          ///< Table 2.1 also by the pseudocode as printed
    Execution execution = {};
};

/// One table: rows for people and for programs, and a note for every difference.
struct ThesisComparison {
    std::string text;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    std::vector<std::string> notes;
};

struct ThesisTable {
    std::string_view number;
    std::string_view title;
    Result<ThesisComparison> (*compare)(const ThesisComparisonOptions& options);
};

/// The tables of chapters 2 and 3, in their order, and ours of chapters 4 and 5.
[[nodiscard]] std::span<const ThesisTable> thesis_tables() noexcept;

[[nodiscard]] Result<ThesisComparison> compare_table_2_1(const ThesisComparisonOptions& options);
[[nodiscard]] Result<ThesisComparison> compare_table_2_2(const ThesisComparisonOptions& options);
[[nodiscard]] Result<ThesisComparison> compare_table_2_3(const ThesisComparisonOptions& options);
[[nodiscard]] Result<ThesisComparison> compare_table_3_2(const ThesisComparisonOptions& options);
[[nodiscard]] Result<ThesisComparison> compare_table_3_3(const ThesisComparisonOptions& options);

/// Chapters 4 and 5 have no tables: these are ours, of what they describe.
[[nodiscard]] Result<ThesisComparison> compare_queries(const ThesisComparisonOptions& options);
[[nodiscard]] Result<ThesisComparison>
compare_adjacency_depths(const ThesisComparisonOptions& options);

} // namespace proxima
