#include "proxima/index_io.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "index/check_structure.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "index/signs/sign_parts.h"
#include "index/slabs/block_slab.h"

#include <array>
#include <bit>
#include <utility>

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

/// For arrays of structs that hold floats; none of them has bytes without a value.
template <class T>
BinarySection section_of(std::uint32_t id, std::span<const T> array)
{
    return {id, static_cast<std::uint32_t>(sizeof(T)), std::as_bytes(array)};
}

/// Reads sections until one is missing.
class SectionReader {
public:
    explicit SectionReader(const BinaryFile& file) : file_(file) {}

    template <class T>
    void read(std::uint32_t id, std::span<const T>& array)
    {
        if (!status_) return;
        const auto section = file_.section<T>(id);
        if (section) {
            array = *section;
        } else {
            status_ = tl::unexpected(section.error());
        }
    }

    [[nodiscard]] const Status& status() const noexcept { return status_; }

private:
    const BinaryFile& file_;
    Status status_;
};

Result<MeshIndex> index_of(const BinaryFile& file, const std::string& name,
                           const IndexLoadOptions& options)
{
    std::span<const IndexHeader> headers;
    std::span<const ListsHeader> list_headers;
    std::span<const BlockSlab> slabs;
    std::span<const SignsHeader> sign_headers;
    IndexArrays arrays;
    ProximityArrays lists;
    SignArrays signs;
    SectionReader reader(file);
    reader.read(header_section, headers);
    reader.read(blocks_section, arrays.blocks);
    reader.read(float_rows_section, arrays.float_rows);
    reader.read(double_rows_section, arrays.double_rows);
    reader.read(ids_section, arrays.ids);
    reader.read(vertex_incidences_section, arrays.vertex_incidences);
    reader.read(edge_incidences_section, arrays.edge_incidences);
    reader.read(lists_section, list_headers);
    reader.read(table_section, lists.table);
    reader.read(nodes_section, lists.nodes);
    reader.read(runs_section, lists.runs);
    reader.read(arena_section, lists.arena);
    reader.read(slabs_section, slabs);
    reader.read(signs_section, sign_headers);
    reader.read(sign_rows_section, signs.rows);
    reader.read(sides_section, signs.sides);
    reader.read(vertex_sides_section, signs.vertex_sides);
    reader.read(vertex_signs_section, signs.vertices);
    reader.read(edge_signs_section, signs.edges);
    reader.read(edge_lists_section, signs.edge_lists);
    reader.read(clusters_section, signs.winding.clusters);
    reader.read(cluster_order_section, signs.winding.order);
    if (!reader.status()) return tl::unexpected(reader.status().error());

    // What would not fit the numbers of memory must be refused before it gets there.
    if (headers.size() != 1 || list_headers.size() > 1 || sign_headers.size() > 1 ||
        headers[0].has_exact_leaves > 1 || arrays.ids.size() > max_index_triangles) {
        return fail(ErrorCode::malformed_file, "the index's parameters are damaged", name);
    }
    arrays.center = vector(headers[0].center);
    arrays.scale = number(headers[0].scale);
    arrays.fingerprint = headers[0].fingerprint;
    arrays.root = headers[0].root;
    arrays.has_exact_leaves = headers[0].has_exact_leaves != 0;
    IndexParts parts = IndexParts::adopt(arrays, file.storage());
    if (!list_headers.empty()) {
        const ListsHeader& header = list_headers[0];
        if (header.table_depth > static_cast<std::uint32_t>(max_table_depth))
            return fail(ErrorCode::malformed_file, "the lists' parameters are damaged", name);
        const RootFrame frame{vector(header.center), number(header.half), number(header.scale)};
        parts = parts.adopt_lists(std::make_shared<const ProximityLists>(
            ProximityLists::adopt(frame, static_cast<int>(header.table_depth), lists,
                                  statistics_of(header), file.storage())));
    }
    if (!slabs.empty()) parts = parts.adopt_slabs(slabs, file.storage());
    if (!sign_headers.empty()) {
        const SignsHeader& header = sign_headers[0];
        signs.bounds = Box{vector(header.lower), vector(header.upper)};
        signs.winding.unit = number(header.unit);
        signs.least_height = number(header.least_height);
        parts = parts.adopt_signs(
            std::make_shared<const SignParts>(SignParts::adopt(signs, file.storage())));
    }
    MeshIndex index = make_mesh_index(std::move(parts));
    if (const Status status = check_structure(index, {.execution = options.execution}); !status) {
        // What would be a fault of the program in an index of its own is damage in a file.
        const bool stopped = status.error().code == ErrorCode::cancelled;
        return fail(stopped ? ErrorCode::cancelled : ErrorCode::malformed_file,
                    describe(status.error()), name);
    }
    return index;
}

} // namespace

Status save_index(const MeshIndex& index, const std::filesystem::path& path,
                  const SaveOptions& options)
{
    const ProximityLists* const lists = index.parts().lists();
    if (lists != nullptr && lists->statistics().stale_leaves != 0) {
        return fail(ErrorCode::invalid_argument,
                    "the lists were refitted and hold what no leaf uses: build them again to save "
                    "the index",
                    path.string());
    }
    const IndexHeader header = header_of(index.parts());
    const ListsHeader lists_header = lists != nullptr ? header_of(*lists) : ListsHeader{};
    const ProximityArrays arrays = lists != nullptr ? lists->arrays() : ProximityArrays{};
    const SignParts* const parts = index.parts().signs();
    const SignArrays signs = parts != nullptr ? parts->arrays() : SignArrays{};
    const SignsHeader signs_header = header_of(signs);
    const std::array<BinarySection, 22> sections = {
        binary_section(header_section, std::span(&header, 1)),
        section_of(blocks_section, index.parts().blocks()),
        section_of(float_rows_section, index.parts().float_rows()),
        section_of(double_rows_section, index.parts().double_rows()),
        binary_section(ids_section, index.ids()),
        binary_section(vertex_incidences_section, index.parts().vertex_incidences()),
        binary_section(edge_incidences_section, index.parts().edge_incidences()),
        binary_section(lists_section, std::span(&lists_header, lists != nullptr ? 1 : 0)),
        binary_section(table_section, arrays.table),
        binary_section(nodes_section, arrays.nodes),
        section_of(runs_section, arrays.runs),
        section_of(arena_section, arrays.arena),
        binary_section(slabs_section, index.parts().slabs()),
        binary_section(signs_section, std::span(&signs_header, parts != nullptr ? 1 : 0)),
        binary_section(sign_rows_section, signs.rows),
        binary_section(sides_section, signs.sides),
        binary_section(vertex_sides_section, signs.vertex_sides),
        section_of(vertex_signs_section, signs.vertices),
        binary_section(edge_signs_section, signs.edges),
        binary_section(edge_lists_section, signs.edge_lists),
        section_of(clusters_section, signs.winding.clusters),
        binary_section(cluster_order_section, signs.winding.order)};
    return write_binary_file(path, index_format, sections, options.execution.progress);
}

Result<MeshIndex> load_index(const std::filesystem::path& path, const IndexLoadOptions& options)
{
    const auto file =
        BinaryFile::open(path, index_format, options.verify, options.execution.progress);
    if (!file) return tl::unexpected(file.error());
    return index_of(*file, path.string(), options);
}

Result<MeshIndex> load_index(std::span<const std::byte> bytes, std::shared_ptr<const void> storage,
                             const std::string& name, const IndexLoadOptions& options)
{
    const auto file = BinaryFile::read(bytes, std::move(storage), name, index_format,
                                       options.verify, options.execution.progress);
    if (!file) return tl::unexpected(file.error());
    return index_of(*file, name, options);
}

} // namespace proxima
