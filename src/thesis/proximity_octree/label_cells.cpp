#include "thesis/proximity_octree/label_cells.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_box.h"

#include <atomic>

namespace proxima {
namespace {

/// So many children are one task: one where lists are long, at the top.
std::size_t block_size(std::size_t children, std::size_t labels)
{
    constexpr std::size_t labels_per_block = 4096;
    return std::clamp<std::size_t>(labels_per_block * children / (8 * labels + 1), 1, 512);
}

void append(CellLists& lists, const CellLists& more)
{
    const std::size_t start = lists.numbers.size();
    lists.numbers.insert(lists.numbers.end(), more.numbers.begin(), more.numbers.end());
    for (std::size_t i = 1; i < more.first.size(); ++i)
        lists.first.push_back(start + more.first[i]);
}

void append(LabelledCells& cells, const LabelledCells& more)
{
    cells.keys.insert(cells.keys.end(), more.keys.begin(), more.keys.end());
    cells.types.insert(cells.types.end(), more.types.begin(), more.types.end());
    append(cells.closest, more.closest);
    append(cells.touching, more.touching);
}

} // namespace

LabelledCells CellLabeller::root() const
{
    LabelledCells cells;
    cells.keys.push_back(CellKey{});
    cells.types.push_back(CellClass::boundary);
    for (std::uint32_t number = 0; number < numbers_.count(); ++number)
        if (regions_.has_region(number)) cells.closest.numbers.push_back(number);
    cells.closest.first.push_back(cells.closest.numbers.size());
    cells.touching = cells.closest;
    return cells;
}

bool CellLabeller::touches(Feature feature, const Box& box) const
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        return box.contains(mesh_.position(VertexId{feature.id}));
    case FeatureKind::edge: {
        const auto [p, q] = topology_.vertices(EdgeId{feature.id});
        return triangle_overlaps_box({{mesh_.position(p), mesh_.position(q), mesh_.position(q)}},
                                     box);
    }
    case FeatureKind::face:
        break;
    }
    return triangle_overlaps_box(mesh_.triangle(TriangleId{feature.id}), box);
}

void CellLabeller::append_touching(std::span<const std::uint32_t> candidates, const Box& box,
                                   std::vector<std::uint32_t>& output) const
{
    const auto faces = of_kind(candidates, numbers_, FeatureKind::face);
    const auto is_touched = [&](std::uint32_t number) {
        return touches(numbers_.feature(number), box);
    };
    // Faces hold their edges and vertices: where none is touched, neither are those.
    const auto first_face = std::ranges::find_if(faces, is_touched);
    if (first_face == faces.end()) return;
    for (const std::uint32_t number : candidates.first(candidates.size() - faces.size()))
        if (is_touched(number)) output.push_back(number);
    std::copy_if(first_face, faces.end(), std::back_inserter(output), is_touched);
}

bool CellLabeller::is_before_a_face_of(std::span<const std::uint32_t> list, const Vec3& point) const
{
    const auto is_before = [&](TriangleId id) {
        const Triangle triangle = mesh_.triangle(id);
        return orient3d(triangle[0], triangle[1], triangle[2], point) > 0;
    };
    return std::ranges::any_of(list, [&](std::uint32_t number) {
        const Feature feature = numbers_.feature(number);
        switch (feature.kind) {
        case FeatureKind::vertex:
            return std::ranges::any_of(topology_.triangles(VertexId{feature.id}), is_before);
        case FeatureKind::edge:
            return std::ranges::any_of(topology_.triangles(EdgeId{feature.id}), is_before);
        case FeatureKind::face:
            break;
        }
        return is_before(TriangleId{feature.id});
    });
}

void CellLabeller::append_child(const LabelledCells& level, std::uint32_t cell, int octant,
                                LabelledCells& output) const
{
    const CellKey key = child(level.keys[cell], octant);
    const Box box = cell_box(frame_, key);
    const Vec3 centre = box.center();
    const double half_size = 0.5 * box.extent().maxCoeff();

    auto& touching = output.touching.numbers;
    const std::size_t touching_start = touching.size();
    append_touching(level.touching.list(cell), box, touching);
    const auto touched = std::span(touching).subspan(touching_start);

    // A feature is in its own region, so what touches the cell needs no test.
    auto& closest = output.closest.numbers;
    const std::size_t closest_start = closest.size();
    auto next_touched = touched.begin();
    for (const std::uint32_t number : level.closest.list(cell)) {
        if (next_touched != touched.end() && *next_touched == number) {
            closest.push_back(number);
            ++next_touched;
        } else if (regions_.meets(number, centre, half_size)) {
            closest.push_back(number);
        }
    }

    CellClass type = CellClass::outer;
    if (!touched.empty()) {
        type = CellClass::boundary;
    } else if (level.types[cell] == CellClass::boundary &&
               !is_before_a_face_of(std::span(closest).subspan(closest_start), centre)) {
        // Nothing, or regions that begin just beyond the cell.
        type = CellClass::inner;
        closest.resize(closest_start);
    }
    output.keys.push_back(key);
    output.types.push_back(type);
    output.closest.first.push_back(closest.size());
    output.touching.first.push_back(touching.size());
}

Result<LabelledCells> CellLabeller::children(const LabelledCells& level,
                                             std::span<const std::uint32_t> cells,
                                             const LabelOptions& options) const
{
    const std::size_t count = 8 * cells.size();
    const std::size_t block = block_size(count, level.closest.numbers.size());
    std::vector<LabelledCells> blocks(chunk_count(count, block));
    const std::uint64_t limit = budget_bytes(options.execution.budget);
    std::atomic<std::uint64_t> used{options.held_bytes};
    begin_stage(options.execution.progress, "labelling cells", count);
    parallel_chunks(count, block, options.execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        LabelledCells& output = blocks[first / block];
                        for (std::size_t at = first; at < end; ++at) {
                            if (is_cancelled(options.execution.progress) ||
                                used.load(std::memory_order_relaxed) > limit)
                                return;
                            const std::uint64_t before = output.bytes();
                            append_child(level, cells[at / 8], static_cast<int>(at % 8), output);
                            // In the block, again in the level, and once more as leaves.
                            used += 3 * (output.bytes() - before);
                        }
                        advance_stage(options.execution.progress, end - first);
                    });
    if (is_cancelled(options.execution.progress)) return cancelled("building the proximity octree");
    if (Status status = check_budget(options.execution.budget, used, "the proximity octree",
                                     "lower the depth, raise the thresholds or the budget");
        !status)
        return tl::unexpected(status.error());

    LabelledCells result;
    for (LabelledCells& finished : blocks) {
        append(result, finished);
        finished = {};
    }
    return result;
}

} // namespace proxima
