#include "mesh/io/read_obj.h"

#include "base/text.h"
#include "mesh/io/text_cursor.h"
#include "mesh/io/text_mesh_reader.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace proxima::detail {

namespace {

using ObjCursor = TextCursor<TextDialect{.has_comments = true, .continues_lines = true}>;

// Statements that say nothing about polygons: other vertex data, points and lines where nobody asked
// for them, grouping, display, and the curves and attributes of free-form geometry.
constexpr std::string_view passed_over[] = {
    "vt",   "vn",     "vp",     "g",          "o",         "s",    "usemtl",   "mtllib", "l",
    "p",    "mg",     "cstype", "deg",        "bmat",      "step", "curv",     "curv2",  "parm",
    "trim", "hole",   "scrv",   "sp",         "end",       "con",  "bevel",    "lod",    "usemap",
    "cdc",  "maplib", "ctech",  "shadow_obj", "trace_obj", "res",  "c_interp", "stech",  "d_interp",
};

// Statements of surfaces that this reader cannot keep.
constexpr std::string_view not_read[] = {"surf", "bsp", "bzp", "cdp", "call", "csh"};

class ObjReader : TextMeshReader<ObjCursor> {
public:
    ObjReader(const MeshSource& source, const ReadOptions& options)
        : TextMeshReader(source, options)
    {}

    Result<TriangleMesh> read(Vertices vertices)
    {
        while (cursor_.next_filled_line()) {
            line_ = cursor_.position();
            if (!may_continue() || !read_statement()) return tl::unexpected(error());
        }
        if (largest_index_ >= static_cast<std::int64_t>(mesh_.vertex_count())) {
            line_ = line_of_largest_;
            element_ = element_of_largest_;
            (void)refuse_index(largest_index_ + 1);
            return tl::unexpected(error());
        }
        if (mesh_.takes_points_and_lines() && mesh_.triangle_count() == 0 &&
            !mesh_.add_points_of_vertices()) {
            (void)refused_by_mesh();
            return tl::unexpected(error());
        }
        return mesh_.finish(vertices);
    }

private:
    bool read_statement()
    {
        const std::string_view keyword = cursor_.word();
        element_ = keyword == "l" ? "a line" : keyword == "p" ? "a point" : "a face";
        if (keyword == "v") return read_vertex();
        if (keyword == "f" || keyword == "fo") return read_face();
        if (mesh_.takes_points_and_lines() && keyword == "l") return read_line();
        if (mesh_.takes_points_and_lines() && keyword == "p") return read_points();
        if (std::ranges::find(passed_over, keyword) != std::end(passed_over)) {
            cursor_.skip_line();
            return true;
        }
        if (std::ranges::find(not_read, keyword) != std::end(not_read)) {
            return refuse(ErrorCode::unsupported_format,
                          concat("\"", keyword, "\" statements (free-form surfaces, other files) ",
                                 "are not read: export the model as polygons"));
        }
        return refuse(ErrorCode::malformed_file,
                      concat("\"", keyword.substr(0, 40), "\" is no OBJ statement"));
    }

    // x y z, then nothing, a weight, a colour, or a colour and its opacity.
    bool read_vertex()
    {
        constexpr int most_values = 7;
        Vec3 position;
        double other = 0;
        int count = 0;
        while (count < most_values && cursor_.real(count < 3 ? position[count] : other)) ++count;
        if (!cursor_.at_line_end()) {
            return refuse(ErrorCode::malformed_file,
                          "a vertex has something that is not a number, or too many of them");
        }
        if (count < 3 || count == 5) {
            return refuse(ErrorCode::malformed_file,
                          concat("a vertex has ", count, " numbers: it needs x y z, with a weight ",
                                 "or a colour at most"));
        }
        return mesh_.add_vertex(position) || refused_by_mesh();
    }

    bool read_face()
    {
        corners_.clear();
        while (!cursor_.at_line_end()) {
            std::uint32_t corner = 0;
            if (!read_corner(corner)) return false;
            if (corners_.size() == max_face_corners) {
                return refuse(ErrorCode::limit_exceeded,
                              concat("a face has more than ", max_face_corners,
                                     " corners: cut it in the program that made it"));
            }
            corners_.push_back(corner);
        }
        if (corners_.size() < 3) {
            return refuse(
                ErrorCode::malformed_file,
                concat("a face has ", corners_.size(), " corners, it needs at least 3: remove it"));
        }
        return mesh_.add_face(corners_) || refused_by_mesh();
    }

    bool read_line()
    {
        std::array<std::uint32_t, 2> ends{};
        int count = 0;
        for (; !cursor_.at_line_end(); ++count) {
            ends[0] = ends[1];
            if (!read_corner(ends[1])) return false;
            if (count > 0 && !mesh_.add_point_or_segment(ends)) return refused_by_mesh();
        }
        return count >= 2 ||
               refuse(ErrorCode::malformed_file,
                      concat("a line has ", count, " corners, it needs at least 2: remove it"));
    }

    bool read_points()
    {
        if (cursor_.at_line_end())
            return refuse(ErrorCode::malformed_file, "a point has no vertex: remove it");
        while (!cursor_.at_line_end()) {
            std::array<std::uint32_t, 1> point{};
            if (!read_corner(point[0])) return false;
            if (!mesh_.add_point_or_segment(point)) return refused_by_mesh();
        }
        return true;
    }

    // vertex, vertex/texture, vertex//normal or vertex/texture/normal.
    bool read_corner(std::uint32_t& corner)
    {
        std::int64_t index = 0;
        std::int64_t other = 0;
        if (!cursor_.integer_here(index)) return refuse_corner();
        if (cursor_.take('/')) {
            const bool has_texture = cursor_.integer_here(other);
            if (cursor_.take('/') ? !cursor_.integer_here(other) : !has_texture) {
                return refuse_corner();
            }
        }
        if (!cursor_.ends_value()) return refuse_corner();

        const auto known = static_cast<std::int64_t>(mesh_.vertex_count());
        if (index == 0 || index < -known || index > index_limit) return refuse_index(index);
        // Vertices may follow later, so indices are checked at the end.
        const std::int64_t vertex = index < 0 ? known + index : index - 1;
        if (vertex > largest_index_) {
            largest_index_ = vertex;
            line_of_largest_ = line_;
            element_of_largest_ = element_;
        }
        corner = static_cast<std::uint32_t>(vertex);
        return true;
    }

    bool refuse(ErrorCode code, std::string message)
    {
        return refuse_at(line_, code, std::move(message));
    }

    bool refuse_corner()
    {
        return refuse(
            ErrorCode::malformed_file,
            concat(element_, " has something that is not an index like 1, 1/2, 1//3 or 1/2/3"));
    }

    bool refuse_index(std::int64_t index)
    {
        return refuse(ErrorCode::malformed_file,
                      concat(element_, " uses vertex ", index, " but there are ",
                             mesh_.vertex_count(),
                             ", counted from 1 or, from the last one back, from -1"));
    }

    static constexpr std::int64_t index_limit = 0xFFFFFFFE;

    const char* line_ = nullptr;
    std::string_view element_; ///< of the line, for messages
    std::int64_t largest_index_ = -1;
    const char* line_of_largest_ = nullptr;
    std::string_view element_of_largest_;
    std::vector<std::uint32_t> corners_;
};

} // namespace

Result<TriangleMesh> read_obj(const MeshSource& source, const ReadOptions& options,
                              Vertices vertices)
{
    if (auto status = source.check_line_ends(); !status) return tl::unexpected(status.error());
    return ObjReader(source, options).read(vertices);
}

} // namespace proxima::detail
