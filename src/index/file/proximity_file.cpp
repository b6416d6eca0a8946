#include "index/file/proximity_file.h"

#include "base/binary_file.h"
#include "base/text.h"
#include "index/lists/build_proximity_octree.h"
#include "index/lists/check_proximity_structure.h"

#include <array>
#include <bit>
#include <charconv>
#include <utility>

namespace proxima {

namespace {

constexpr FileFormat proximity_format{
    {'P', 'r', 'o', 'x', 'i', 'm', 'a', 'P'}, 1, "proximity octree file"};

enum SectionId : std::uint32_t {
    header_section = 1,
    table_section = 2,
    nodes_section = 3,
    runs_section = 4,
    arena_section = 5,
    float_rows_section = 6,
    double_rows_section = 7,
    vertex_places_section = 8,
    edge_places_section = 9,
    tree_section = 10
};

/// Everything but the arrays. Doubles by their bits, so that the struct has no other values.
struct ProximityFileHeader {
    std::array<std::uint64_t, 3> center{};
    std::uint64_t half = 0;
    std::uint64_t scale = 0;
    std::array<std::uint64_t, 3> tree_origin{};
    std::uint64_t tree_scale = 0;
    std::uint64_t tree_reach = 0;
    std::uint64_t mean_list = 0;
    std::uint64_t expected_list = 0;
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t references = 0;
    std::uint64_t blocks = 0;
    std::uint64_t fingerprint = 0;
    std::uint32_t max_depth = 0;
    std::uint32_t max_list = 0;
    std::uint32_t worst_case_steps = 0;
    std::uint32_t worst_case_blocks = 0;
    std::uint32_t table_depth = 0;
    std::uint32_t searched_leaves = 0;
};
static_assert(sizeof(ProximityFileHeader) == 160);
static_assert(sizeof(RunEntry) == 24 && sizeof(TriangleTreeBlock) == 192);

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

ProximityFileHeader file_header(const ProximityOctree& octree)
{
    const ProximityStatistics& counts = octree.statistics();
    ProximityFileHeader header;
    header.center = bits(octree.frame().center);
    header.half = bits(octree.frame().half);
    header.scale = bits(octree.frame().scale);
    header.tree_origin = bits(octree.tree().origin());
    header.tree_scale = bits(octree.tree().scale());
    header.tree_reach = bits(octree.tree().reach());
    header.mean_list = bits(counts.mean_list);
    header.expected_list = bits(counts.expected_list);
    header.nodes = counts.nodes;
    header.leaves = counts.leaves;
    header.references = counts.references;
    header.blocks = counts.blocks;
    header.fingerprint = octree.mesh_fingerprint();
    header.max_depth = counts.max_depth;
    header.max_list = counts.max_list;
    header.worst_case_steps = counts.worst_case_steps;
    header.worst_case_blocks = counts.worst_case_blocks;
    header.table_depth = static_cast<std::uint32_t>(octree.table_depth());
    header.searched_leaves = static_cast<std::uint32_t>(counts.searched_leaves);
    return header;
}

ProximityStatistics statistics_of(const ProximityFileHeader& header)
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

/// What a loaded octree keeps alive.
struct LoadedOctree {
    std::shared_ptr<const void> file;
    TriangleTree tree;
};

Result<ProximityOctree> octree_of(const BinaryFile& file, const std::string& name,
                                  const ProximityLoadOptions& options)
{
    std::span<const ProximityFileHeader> headers;
    std::span<const TriangleTreeBlock> boxes;
    ProximityArrays arrays;
    SectionReader reader(file);
    reader.read(header_section, headers);
    reader.read(table_section, arrays.table);
    reader.read(nodes_section, arrays.nodes);
    reader.read(runs_section, arrays.runs);
    reader.read(arena_section, arrays.arena);
    reader.read(float_rows_section, arrays.float_rows);
    reader.read(double_rows_section, arrays.double_rows);
    reader.read(vertex_places_section, arrays.vertex_places);
    reader.read(edge_places_section, arrays.edge_places);
    reader.read(tree_section, boxes);
    if (!reader.status()) return tl::unexpected(reader.status().error());

    const auto malformed = [&](const std::string& message) {
        return fail(ErrorCode::malformed_file, message, name);
    };
    // What would not fit the numbers of memory must be refused before it gets there.
    const std::size_t triangles = arrays.float_rows.size() + arrays.double_rows.size();
    if (headers.size() != 1 ||
        headers[0].table_depth > static_cast<std::uint32_t>(max_table_depth)) {
        return malformed("the octree's parameters are damaged");
    }
    if (triangles == 0 || triangles > max_proximity_triangles ||
        boxes.size() != TriangleTree::block_count(static_cast<std::uint32_t>(triangles))) {
        return malformed("the numbers of triangles and boxes are damaged");
    }
    const ProximityFileHeader& header = headers[0];
    const auto storage = std::make_shared<LoadedOctree>();
    storage->file = file.storage();
    storage->tree = TriangleTree::adopt(
        vector(header.tree_origin), number(header.tree_scale), number(header.tree_reach),
        static_cast<std::uint32_t>(triangles), boxes, file.storage());
    const RootFrame frame{vector(header.center), number(header.half), number(header.scale)};
    ProximityOctree octree =
        ProximityOctree::adopt(frame, static_cast<int>(header.table_depth), arrays, &storage->tree,
                               statistics_of(header), header.fingerprint, storage);
    if (const Status status = check_structure(octree, {options.execution}); !status) {
        // What would be a fault of the program in an octree of its own is damage in a file.
        const bool stopped = status.error().code == ErrorCode::cancelled;
        return fail(stopped ? ErrorCode::cancelled : ErrorCode::malformed_file,
                    describe(status.error()), name);
    }
    return octree;
}

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 16> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, 16).ptr;
    return {digits.data(), end};
}

} // namespace

Status save_proximity_octree(const ProximityOctree& octree, const std::filesystem::path& path,
                             const SaveOptions& options)
{
    if (octree.statistics().stale_leaves != 0) {
        return fail(
            ErrorCode::invalid_argument,
            "the octree was refitted and holds what no leaf uses: build it again to save it",
            path.string());
    }
    const ProximityFileHeader header = file_header(octree);
    const ProximityArrays& arrays = octree.arrays();
    const std::array<BinarySection, 10> sections = {
        binary_section(header_section, std::span(&header, 1)),
        binary_section(table_section, arrays.table),
        binary_section(nodes_section, arrays.nodes),
        section_of(runs_section, arrays.runs),
        section_of(arena_section, arrays.arena),
        section_of(float_rows_section, arrays.float_rows),
        section_of(double_rows_section, arrays.double_rows),
        binary_section(vertex_places_section, arrays.vertex_places),
        binary_section(edge_places_section, arrays.edge_places),
        section_of(tree_section, octree.tree().blocks())};
    return write_binary_file(path, proximity_format, sections, options.execution.progress);
}

Result<ProximityOctree> load_proximity_octree(const std::filesystem::path& path,
                                              const ProximityLoadOptions& options)
{
    const auto file =
        BinaryFile::open(path, proximity_format, options.verify, options.execution.progress);
    if (!file) return tl::unexpected(file.error());
    return octree_of(*file, path.string(), options);
}

Result<ProximityOctree> load_proximity_octree(std::span<const std::byte> bytes,
                                              std::shared_ptr<const void> storage,
                                              const std::string& name,
                                              const ProximityLoadOptions& options)
{
    const auto file = BinaryFile::read(bytes, std::move(storage), name, proximity_format,
                                       options.verify, options.execution.progress);
    if (!file) return tl::unexpected(file.error());
    return octree_of(*file, name, options);
}

Status check_same_mesh(const ProximityOctree& octree, const TriangleMesh& mesh)
{
    const std::uint64_t fingerprint = mesh_fingerprint(mesh);
    const std::size_t vertices = octree.arrays().vertex_places.size();
    if (octree.mesh_fingerprint() == fingerprint &&
        octree.triangle_count() == mesh.triangle_count() && vertices == mesh.vertex_count()) {
        return {};
    }
    return fail(ErrorCode::invalid_argument,
                concat("the proximity octree is of another mesh, ", octree.triangle_count(),
                       " triangles, ", vertices, " vertices, fingerprint ",
                       hexadecimal(octree.mesh_fingerprint()), "; this one has ",
                       mesh.triangle_count(), " triangles, ", mesh.vertex_count(),
                       " vertices, fingerprint ", hexadecimal(fingerprint), ": build it again"),
                "mesh");
}

} // namespace proxima
