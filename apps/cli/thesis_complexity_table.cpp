// Table 3.2: what the methods cost at worst, counted while their code runs on counting numbers.
#include "cli/text_table.h"
#include "cli/thesis_comparison.h"
#include "proxima/base/text.h"
#include "proxima/octree/operation_table.h"

namespace proxima {

Result<ThesisComparison> compare_table_3_2(const ThesisComparisonOptions& /*options*/)
{
    TextTable table({"Method", "Dots", "Thesis", "Crosses", "Thesis", "Flops", "Thesis", "Add",
                     "Sub", "Mul", "Div", "Neg", "Compare"});
    ThesisComparison comparison;
    for (const OperationCountRow& row : count_operations()) {
        const OperationCounts& counts = row.counts;
        const auto thesis = [&](auto value) { return value ? to_text(*value) : std::string("-"); };
        std::optional<int> dots;
        std::optional<int> crosses;
        std::optional<int> flops;
        if (row.thesis) {
            dots = row.thesis->dot_products;
            crosses = row.thesis->cross_products;
            flops = row.thesis->flops;
        }
        table.add_row({row.method, to_text(counts.dot_products), thesis(dots),
                       to_text(counts.cross_products), thesis(crosses), to_text(counts.flops()),
                       thesis(flops), to_text(counts.additions), to_text(counts.subtractions),
                       to_text(counts.multiplications), to_text(counts.divisions),
                       to_text(counts.negations), to_text(counts.comparisons)});
        const auto beside = [](std::int64_t ours, const std::optional<int>& printed) {
            nlohmann::ordered_json pair = {{"proxima", ours}};
            if (printed) pair["thesis"] = *printed;
            return pair;
        };
        comparison.rows.push_back({{"method", row.method},
                                   {"dot_products", beside(counts.dot_products, dots)},
                                   {"cross_products", beside(counts.cross_products, crosses)},
                                   {"flops", beside(counts.flops(), flops)},
                                   {"additions", counts.additions},
                                   {"subtractions", counts.subtractions},
                                   {"multiplications", counts.multiplications},
                                   {"divisions", counts.divisions},
                                   {"negations", counts.negations},
                                   {"comparisons", counts.comparisons}});
    }
    comparison.text = concat("Worst of many triangles and cells; flops leave out comparisons and "
                             "negations; dots and crosses are part of them\n\n",
                             table.text(), "\n");
    comparison.notes = {
        "The thesis counts 81 flops for edge x axis products; they are copies and negations. "
        "Opposite "
        "normals share a dot product, so 13 serve where it counts 26.",
        "Its 27 cross products of the geometric method are the components of nine. Its hull method "
        "sums 4 + ... + 42 to 440, which is 460.",
        "Lines without a thesis value are ours: what is prepared once per triangle or depth, and "
        "the "
        "closed form of the method fast, which goes down by additions alone."};
    return comparison;
}

} // namespace proxima
