#include "mesh/io/read_stl.h"

#include "base/text.h"
#include "mesh/io/text_cursor.h"
#include "mesh/io/text_mesh_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <vector>

namespace proxima::detail {

namespace {

using StlCursor = TextCursor<TextDialect{.line_ends_are_blanks = true}>;
using LineCursor = TextCursor<TextDialect{}>;

//     80 bytes of anything | triangle count, uint32 | per triangle: normal and three corners,
//     12 float32 little-endian, and two bytes of attributes
constexpr std::size_t header_bytes = 80;
constexpr std::size_t first_triangle = header_bytes + 4;
constexpr std::size_t triangle_bytes = 50;

std::uint32_t load_uint32(const char* bytes) noexcept
{
    std::array<unsigned char, 4> octets{};
    std::memcpy(octets.data(), bytes, octets.size());
    return octets[0] | std::uint32_t{octets[1]} << 8U | std::uint32_t{octets[2]} << 16U |
           std::uint32_t{octets[3]} << 24U;
}

/// The corners of the triangle at `position`. The normal precedes them.
Vec3 load_corner(const char* position, std::size_t corner) noexcept
{
    const auto value = [&](std::size_t index) {
        return static_cast<double>(std::bit_cast<float>(load_uint32(position + index * 4)));
    };
    const std::size_t x = 3 * (corner + 1);
    return {value(x), value(x + 1), value(x + 2)};
}

bool equals_any_case(std::string_view word, std::string_view lower_case) noexcept
{
    return std::ranges::equal(word, lower_case, [](char letter, char expected) {
        return (letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter) == expected;
    });
}

bool fits_binary(std::string_view text) noexcept
{
    return text.size() >= first_triangle &&
           text.size() - first_triangle ==
               std::uint64_t{load_uint32(text.data() + header_bytes)} * triangle_bytes;
}

Result<TriangleMesh> read_binary(const MeshSource& source, const ReadOptions& options,
                                 Vertices vertices)
{
    const std::string_view text = source.text;
    MeshAssembler mesh(source, options);
    ReadProgress progress(options.execution.progress, text);
    const std::uint32_t count = load_uint32(text.data() + header_bytes);
    const bool welds = vertices == Vertices::welded;
    // A closed surface has half as many vertices as triangles.
    if (!(welds ? mesh.reserve_welded(count / 2)
                : mesh.reserve_vertices(std::uint64_t{3} * count)) ||
        !mesh.reserve_triangles(count)) {
        return tl::unexpected(mesh.error());
    }
    constexpr std::uint32_t block = MeshAssembler::weld_block / 3;
    std::array<Vec3, std::size_t{3} * block> corners;
    std::array<std::uint32_t, std::size_t{3} * block> ids{};
    const char* position = text.data() + first_triangle;
    for (std::uint32_t first = 0; first < count; first += block) {
        if (!progress.may_continue(position)) return cancelled("reading", source.name);
        const std::uint32_t triangles = std::min(block, count - first);
        for (std::uint32_t triangle = 0; triangle < triangles; ++triangle) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                corners[std::size_t{3} * triangle + corner] = load_corner(position, corner);
            }
            position += triangle_bytes;
        }
        const std::span found = std::span(ids).first(std::size_t{3} * triangles);
        bool added = true;
        if (welds) {
            added = mesh.add_welded(std::span(corners).first(found.size()), found);
        } else {
            std::iota(found.begin(), found.end(), 3 * first);
            for (std::size_t i = 0; i < found.size(); ++i) {
                added = added && mesh.add_vertex(corners[i]);
            }
        }
        for (std::size_t i = 0; i < found.size(); i += 3) {
            added = added && mesh.add_triangle({found[i], found[i + 1], found[i + 2]});
        }
        if (!added) return tl::unexpected(mesh.error());
    }
    return mesh.finish(vertices);
}

// solid NAME / facet normal x y z / outer loop / vertex x y z ... / endloop / endfacet / endsolid
class TextReader : TextMeshReader<StlCursor> {
public:
    TextReader(const MeshSource& source, const ReadOptions& options, Vertices vertices)
        : TextMeshReader(source, options), vertices_(vertices)
    {}

    Result<TriangleMesh> read()
    {
        cursor_.skip_blanks();
        while (!cursor_.at_end()) {
            if (!read_solid()) return tl::unexpected(error());
            cursor_.skip_blanks();
        }
        if (!add_facets()) return tl::unexpected(mesh_.error());
        return mesh_.finish(vertices_);
    }

private:
    bool read_solid()
    {
        if (!expect("solid")) return false;
        skip_name();
        while (true) {
            if (!may_continue()) return false;
            if (!cursor_.take_word("facet")) {
                const std::string_view word = cursor_.word();
                if (equals_any_case(word, "endsolid")) break;
                if (!equals_any_case(word, "facet")) return refuse_word(word, "facet or endsolid");
            }
            if (!read_facet()) return false;
        }
        skip_name();
        return true;
    }

    // The rest of this line, which may be empty.
    void skip_name()
    {
        LineCursor line({cursor_.position(), cursor_.remaining()});
        line.skip_line();
        cursor_ = StlCursor({line.position(), line.remaining()});
    }

    bool read_facet()
    {
        if (!expect("normal")) return false;
        for (int i = 0; i < 3; ++i) (void)cursor_.word();
        if (!expect("outer") || !expect("loop")) return false;
        const std::size_t first = positions_.size();
        while (true) {
            if (!cursor_.take_word("vertex")) {
                const std::string_view word = cursor_.word();
                if (equals_any_case(word, "endloop")) break;
                if (!equals_any_case(word, "vertex")) return refuse_word(word, "vertex or endloop");
            }
            const std::size_t corner = positions_.size() - first;
            Vec3 position;
            for (int axis = 0; axis < 3; ++axis) {
                if (!cursor_.real(position[axis])) {
                    return refuse(
                        concat("vertex ", corner, " of facet ", facet_, " has not three numbers"));
                }
            }
            if (corner == max_face_corners) {
                return refuse(concat("facet ", facet_, " has more than ", max_face_corners,
                                     " corners: cut it in the program that made it"),
                              ErrorCode::limit_exceeded);
            }
            positions_.push_back(position);
        }
        const std::size_t corners = positions_.size() - first;
        if (corners < 3) {
            return refuse(concat("facet ", facet_, " has ", corners,
                                 " corners, it needs at least 3: remove it"));
        }
        if (!expect("endfacet")) return false;
        ++facet_;
        facet_ends_.push_back(static_cast<std::uint32_t>(positions_.size()));
        return positions_.size() < MeshAssembler::weld_block || add_facets() || refused_by_mesh();
    }

    // Looks up many waiting corners at a time, so that the memory of one is fetched while others
    // are compared.
    bool add_facets()
    {
        corners_.resize(positions_.size());
        for (std::size_t begin = 0; begin < positions_.size();) {
            const std::size_t count =
                std::min(MeshAssembler::weld_block, positions_.size() - begin);
            const auto positions = std::span<const Vec3>(positions_).subspan(begin, count);
            const auto corners = std::span(corners_).subspan(begin, count);
            if (vertices_ == Vertices::welded) {
                if (!mesh_.add_welded(positions, corners)) return false;
            } else {
                std::iota(corners.begin(), corners.end(),
                          static_cast<std::uint32_t>(mesh_.vertex_count()));
                for (const Vec3& position : positions) {
                    if (!mesh_.add_vertex(position)) return false;
                }
            }
            begin += count;
        }
        std::uint32_t begin = 0;
        for (const std::uint32_t end : facet_ends_) {
            if (!mesh_.add_face(std::span(corners_).subspan(begin, end - begin))) return false;
            begin = end;
        }
        positions_.clear();
        facet_ends_.clear();
        return true;
    }

    template <std::size_t Size>
    bool expect(const char (&expected)[Size])
    {
        if (cursor_.take_word(expected)) return true;
        const std::string_view word = cursor_.word();
        return equals_any_case(word, expected) || refuse_word(word, expected);
    }

    bool refuse_word(std::string_view word, std::string_view expected)
    {
        if (word.empty()) {
            return refuse(concat("the file ends in facet ", facet_, " where ", expected,
                                 " should come: it is cut off, copy it again"));
        }
        return refuse(concat("\"", word.substr(0, 40), "\" stands where ", expected,
                             " should in facet ", facet_));
    }

    Vertices vertices_;
    std::uint64_t facet_ = 0;
    // Facets that wait to be added:
    std::vector<Vec3> positions_;
    std::vector<std::uint32_t> facet_ends_; ///< in positions_
    std::vector<std::uint32_t> corners_;    ///< the vertices at positions_
};

tl::unexpected<Error> refuse_binary(const MeshSource& source)
{
    const std::size_t size = source.text.size();
    if (size < first_triangle) {
        return fail(ErrorCode::malformed_file,
                    concat("neither text that starts with \"solid\" nor the ", first_triangle,
                           " bytes that a binary STL has at least, only ", size,
                           ": it is cut off or no STL"),
                    source.name);
    }
    const std::uint64_t count = load_uint32(source.text.data() + header_bytes);
    return fail(ErrorCode::malformed_file,
                concat("a binary STL of ", count, " triangles, as its header says, has ",
                       first_triangle + count * triangle_bytes, " bytes, this file has ", size,
                       ": it is cut off or no STL"),
                source.name);
}

} // namespace

Result<TriangleMesh> read_stl(const MeshSource& source, const ReadOptions& options,
                              Vertices vertices)
{
    if (fits_binary(source.text)) return read_binary(source, options, vertices);
    StlCursor start(without_byte_order_mark(source.text));
    // Text has no zero bytes, the numbers of a binary file nearly always do.
    const bool is_text =
        equals_any_case(start.word(), "solid") && source.text.find('\0') == std::string_view::npos;
    if (!is_text) return refuse_binary(source);
    if (auto status = source.check_line_ends(); !status) return tl::unexpected(status.error());
    return TextReader(source, options, vertices).read();
}

} // namespace proxima::detail
