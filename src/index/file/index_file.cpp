#include "proxima/index_io.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "index/check_structure.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "index/signs/sign_parts.h"
#include "index/slabs/block_slab.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr FileFormat index_format{{'P', 'r', 'o', 'x', 'i', 'm', 'a', 'I'}, 1, "mesh index file"};

enum SectionId : std::uint32_t {
    header_section = 1,
    blocks_section,
    float_rows_section,
    double_rows_section,
    ids_section,
    vertex_incidences_section,
    edge_incidences_section,
    lists_section,
    table_section,
    nodes_section,
    runs_section,
    arena_section,
    slabs_section,
    signs_section,
    sign_rows_section,
    sides_section,
    vertex_sides_section,
    vertex_signs_section,
    edge_signs_section,
    edge_lists_section,
    clusters_section,
    cluster_order_section
};

/// Frame and root. Doubles by their bits, so that the struct has no other values.
struct IndexHeader {
    std::array<std::uint64_t, 3> center{};
    std::uint64_t scale = 0;
    std::uint64_t fingerprint = 0;
    std::uint32_t root = 0;
    std::uint32_t has_exact_leaves = 0; ///< 0 or 1
};

/// All of lists but their arrays.
struct ListsHeader {
    std::array<std::uint64_t, 3> center{};
    std::uint64_t half = 0;
    std::uint64_t scale = 0;
    std::uint64_t mean_list = 0;
    std::uint64_t expected_list = 0;
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t references = 0;
    std::uint64_t blocks = 0;
    std::uint32_t max_depth = 0;
    std::uint32_t max_list = 0;
    std::uint32_t worst_case_steps = 0;
    std::uint32_t worst_case_blocks = 0;
    std::uint32_t table_depth = 0;
    std::uint32_t searched_leaves = 0;
};

/// All of signs but their arrays.
struct SignsHeader {
    std::array<std::uint64_t, 3> lower{};
    std::array<std::uint64_t, 3> upper{};
    std::uint64_t unit = 0;
    std::uint64_t least_height = 0;
};
static_assert(sizeof(IndexHeader) == 48 && sizeof(ListsHeader) == 112);
static_assert(sizeof(SignsHeader) == 64 && sizeof(VertexSign) == 32);
static_assert(sizeof(RunEntry) == 24 && sizeof(BlockSlab) == 8);
static_assert(alignof(IndexBlock) <= section_alignment);

std::uint64_t bits(double value)
{
    return std::bit_cast<std::uint64_t>(value);
}

double number(std::uint64_t bits)
{
    return std::bit_cast<double>(bits);
}

std::array<std::uint64_t, 3> bits(const Vec3& v)
{
    return {bits(v[0]), bits(v[1]), bits(v[2])};
}

Vec3 vector(const std::array<std::uint64_t, 3>& v)
{
    return {number(v[0]), number(v[1]), number(v[2])};
}

IndexHeader header_of(const IndexParts& index)
{
    return {bits(index.center()), bits(index.scale()), index.mesh_fingerprint(), index.root(),
            index.has_exact_leaves()};
}

ListsHeader header_of(const ProximityLists& lists)
{
    const ProximityStatistics& counts = lists.statistics();
    ListsHeader header;
    header.center = bits(lists.frame().center);
    header.half = bits(lists.frame().half);
    header.scale = bits(lists.frame().scale);
    header.mean_list = bits(counts.mean_list);
    header.expected_list = bits(counts.expected_list);
    header.nodes = counts.nodes;
    header.leaves = counts.leaves;
    header.references = counts.references;
    header.blocks = counts.blocks;
    header.max_depth = counts.max_depth;
    header.max_list = counts.max_list;
    header.worst_case_steps = counts.worst_case_steps;
    header.worst_case_blocks = counts.worst_case_blocks;
    header.table_depth = static_cast<std::uint32_t>(lists.table_depth());
    header.searched_leaves = static_cast<std::uint32_t>(counts.searched_leaves);
    return header;
}

SignsHeader header_of(const SignArrays& signs)
{
    return {bits(signs.bounds.lower), bits(signs.bounds.upper), bits(signs.winding.unit),
            bits(signs.least_height)};
}

ProximityStatistics statistics_of(const ListsHeader& header)
{
    ProximityStatistics counts;
    counts.nodes = header.nodes;
    counts.leaves = header.leaves;
    counts.searched_leaves = header.searched_leaves;
    counts.references = header.references;
    counts.blocks = header.blocks;
    counts.max_depth = header.max_depth;
    counts.max_list = header.max_list;
    counts.worst_case_steps = header.worst_case_steps;
    counts.worst_case_blocks = header.worst_case_blocks;
    counts.mean_list = number(header.mean_list);
    counts.expected_list = number(header.expected_list);
    return counts;
}

/// The arrays of a file, those of parts that an index does not have empty.
struct FileArrays {
    std::span<const IndexHeader> headers;
    IndexArrays index;
    std::span<const ListsHeader> lists_headers;
    ProximityArrays lists;
    std::span<const BlockSlab> slabs;
    std::span<const SignsHeader> signs_headers;
    SignArrays signs;
};

/// Calls visit(id, array) for all sections of a file in order, until it returns false.
template <class Arrays, class Visit>
bool visit_sections(Arrays& file, const Visit& visit)
{
    return visit(header_section, file.headers) && visit(blocks_section, file.index.blocks) &&
           visit(float_rows_section, file.index.float_rows) &&
           visit(double_rows_section, file.index.double_rows) &&
           visit(ids_section, file.index.ids) &&
           visit(vertex_incidences_section, file.index.vertex_incidences) &&
           visit(edge_incidences_section, file.index.edge_incidences) &&
           visit(lists_section, file.lists_headers) && visit(table_section, file.lists.table) &&
           visit(nodes_section, file.lists.nodes) && visit(runs_section, file.lists.runs) &&
           visit(arena_section, file.lists.arena) && visit(slabs_section, file.slabs) &&
           visit(signs_section, file.signs_headers) && visit(sign_rows_section, file.signs.rows) &&
           visit(sides_section, file.signs.sides) &&
           visit(vertex_sides_section, file.signs.vertex_sides) &&
           visit(vertex_signs_section, file.signs.vertices) &&
           visit(edge_signs_section, file.signs.edges) &&
           visit(edge_lists_section, file.signs.edge_lists) &&
           visit(clusters_section, file.signs.winding.clusters) &&
           visit(cluster_order_section, file.signs.winding.order);
}

Result<MeshIndex> index_of(const BinaryFile& file, const std::string& name,
                           const LoadOptions& options)
{
    FileArrays arrays;
    Status status;
    const auto read = [&]<class T>(std::uint32_t id, std::span<const T>& array) {
        const auto section = file.section<T>(id);
        if (section) {
            array = *section;
        } else {
            status = tl::unexpected(section.error());
        }
        return section.has_value();
    };
    if (!visit_sections(arrays, read)) return tl::unexpected(status.error());
    auto& [headers, index, lists_headers, lists, slabs, signs_headers, signs] = arrays;

    // What would not fit the numbers of memory must be refused before it gets there.
    if (headers.size() != 1 || lists_headers.size() > 1 || signs_headers.size() > 1 ||
        headers[0].has_exact_leaves > 1 || index.ids.size() > max_index_triangles) {
        return fail(ErrorCode::malformed_file, "the index's parameters are damaged", name);
    }
    index.center = vector(headers[0].center);
    index.scale = number(headers[0].scale);
    index.fingerprint = headers[0].fingerprint;
    index.root = headers[0].root;
    index.has_exact_leaves = headers[0].has_exact_leaves != 0;
    IndexParts parts = IndexParts::adopt(index, file.storage());
    if (!lists_headers.empty()) {
        const ListsHeader& header = lists_headers[0];
        if (header.table_depth > static_cast<std::uint32_t>(max_table_depth))
            return fail(ErrorCode::malformed_file, "the lists' parameters are damaged", name);
        const RootFrame frame{vector(header.center), number(header.half), number(header.scale)};
        parts = parts.adopt_lists(std::make_shared<const ProximityLists>(
            ProximityLists::adopt(frame, static_cast<int>(header.table_depth), lists,
                                  statistics_of(header), file.storage())));
    }
    if (!slabs.empty()) parts = parts.adopt_slabs(slabs, file.storage());
    if (!signs_headers.empty()) {
        const SignsHeader& header = signs_headers[0];
        signs.bounds = Box{vector(header.lower), vector(header.upper)};
        signs.winding.unit = number(header.unit);
        signs.least_height = number(header.least_height);
        parts = parts.adopt_signs(
            std::make_shared<const SignParts>(SignParts::adopt(signs, file.storage())));
    }
    MeshIndex result = make_mesh_index(std::move(parts));
    status = check_structure(result, {.execution = options.execution});
    if (!status) {
        // What would be a fault of the program in an index of its own is damage in a file.
        const bool stopped = status.error().code == ErrorCode::cancelled;
        return fail(stopped ? ErrorCode::cancelled : ErrorCode::malformed_file,
                    describe(status.error()), name);
    }
    return result;
}

} // namespace

Status save_index(const MeshIndex& index, const std::filesystem::path& path,
                  const SaveOptions& options)
{
    const IndexParts& parts = index.parts();
    if (parts.triangle_count() == 0) {
        return fail(ErrorCode::invalid_argument,
                    "the index is empty: build it from a mesh to save it", path.string());
    }
    const ProximityLists* const lists = parts.lists();
    if (lists != nullptr && lists->statistics().stale_leaves != 0) {
        return fail(ErrorCode::invalid_argument,
                    "the lists were refitted and hold what no leaf uses: build them again to save "
                    "the index",
                    path.string());
    }
    const IndexHeader header = header_of(parts);
    ListsHeader lists_header;
    SignsHeader signs_header;
    FileArrays arrays;
    arrays.headers = {&header, 1};
    arrays.index = parts.arrays();
    arrays.slabs = parts.slabs();
    if (lists != nullptr) {
        lists_header = header_of(*lists);
        arrays.lists_headers = {&lists_header, 1};
        arrays.lists = lists->arrays();
    }
    if (const SignParts* const signs = parts.signs(); signs != nullptr) {
        signs_header = header_of(signs->arrays());
        arrays.signs_headers = {&signs_header, 1};
        arrays.signs = signs->arrays();
    }
    std::vector<BinarySection> sections;
    // None of the structs has bytes without a value.
    (void)visit_sections(arrays, [&]<class T>(std::uint32_t id, std::span<const T> array) {
        sections.push_back({id, static_cast<std::uint32_t>(sizeof(T)), std::as_bytes(array)});
        return true;
    });
    return write_binary_file(path, index_format, sections, options.execution.progress);
}

Result<MeshIndex> load_index(const std::filesystem::path& path, const LoadOptions& options)
{
    const auto file = BinaryFile::open(path, index_format,
                                       {.verify = options.verify,
                                        .access = options.access,
                                        .budget = options.execution.budget,
                                        .progress = options.execution.progress});
    if (!file) return tl::unexpected(file.error());
    return index_of(*file, path.string(), options);
}

Result<MeshIndex> load_index(std::span<const std::byte> bytes, std::shared_ptr<const void> storage,
                             const std::string& name, const LoadOptions& options)
{
    const auto file = BinaryFile::read(bytes, std::move(storage), name, index_format,
                                       options.verify, options.execution.progress);
    if (!file) return tl::unexpected(file.error());
    return index_of(*file, name, options);
}

} // namespace proxima
