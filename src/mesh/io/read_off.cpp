#include "mesh/io/read_off.h"

#include "base/text.h"
#include "mesh/io/text_cursor.h"
#include "mesh/io/text_mesh_reader.h"

#include <vector>

namespace proxima::detail {

namespace {

using OffCursor = TextCursor<TextDialect{.has_comments = true}>;

class OffReader : TextMeshReader<OffCursor> {
public:
    OffReader(const MeshSource& source, const ReadOptions& options)
        : TextMeshReader(source, options)
    {}

    Result<TriangleMesh> read(Vertices vertices)
    {
        if (!read_header() || !read_counts() || !read_vertices() || !read_faces()) {
            return tl::unexpected(error());
        }
        if (cursor_.next_filled_line()) {
            (void)refuse("there is more data than the counts declare: one of them is wrong");
            return tl::unexpected(error());
        }
        if (mesh_.takes_points_and_lines() && face_count_ == 0 && !mesh_.add_points_of_vertices()) {
            (void)refused_by_mesh();
            return tl::unexpected(error());
        }
        return mesh_.finish(vertices);
    }

private:
    // [ST][C][N]OFF; a file that starts with its counts is plain OFF.
    bool read_header()
    {
        if (!cursor_.next_filled_line()) return refuse("the file holds only comments");
        OffCursor ahead = cursor_;
        std::int64_t number = 0;
        if (ahead.integer(number)) return true;
        std::string_view keyword = cursor_.word();
        const auto take = [&](std::string_view prefix) {
            const bool there = keyword.starts_with(prefix);
            if (there) keyword.remove_prefix(prefix.size());
            return there;
        };
        if (take("ST")) least_extra_ += 2;
        if (take("C")) {
            least_extra_ += 3; // three or four components
            most_extra_ += 1;
        }
        if (take("N")) least_extra_ += 3;
        most_extra_ += least_extra_;
        if (keyword == "4OFF" || keyword == "nOFF" || keyword == "4nOFF") {
            return refuse("only three-dimensional OFF files are read, not 4OFF and nOFF",
                          ErrorCode::unsupported_format);
        }
        if (keyword != "OFF") return refuse("an OFF file starts with OFF, NOFF, COFF or STOFF");
        ahead = cursor_;
        if (ahead.word() == "BINARY") {
            return refuse("binary OFF is not read: save it as text or as PLY",
                          ErrorCode::unsupported_format);
        }
        return true;
    }

    // The counts of vertices, faces and, optionally, edges.
    bool read_counts()
    {
        std::int64_t counts[3] = {0, 0, 0};
        int found = 0;
        if (cursor_.next_filled_line()) {
            while (found < 3 && cursor_.integer(counts[found])) ++found;
        }
        if (found < 2 || counts[0] < 0 || counts[1] < 0 || !cursor_.at_line_end()) {
            return refuse("the counts of vertices, faces and edges are missing or no numbers");
        }
        vertex_count_ = static_cast<std::uint64_t>(counts[0]);
        face_count_ = static_cast<std::uint64_t>(counts[1]);
        // A value takes at least a digit and a separator; a face at least its length and corners.
        const std::uint64_t vertex_bytes = 2 * (3 + least_extra_);
        const std::uint64_t face_bytes = 2 + 2 * least_corners();
        const std::uint64_t available = cursor_.remaining() + 1;
        if (vertex_count_ > available / vertex_bytes ||
            face_count_ > (available - vertex_count_ * vertex_bytes) / face_bytes) {
            return refuse(concat("the file promises ", vertex_count_, " vertices and ", face_count_,
                                 " faces but has only ", cursor_.remaining(),
                                 " bytes left for them: it is cut off or its counts are wrong"));
        }
        return true;
    }

    bool read_vertices()
    {
        if (!mesh_.reserve_vertices(vertex_count_)) return refused_by_mesh();
        for (std::uint64_t vertex = 0; vertex < vertex_count_; ++vertex) {
            if (!begin_line("vertex", vertex, vertex_count_)) return false;
            Vec3 position;
            double other = 0;
            std::uint64_t count = 0;
            while (count < 3 + most_extra_ &&
                   cursor_.real(count < 3 ? position[static_cast<int>(count)] : other)) {
                ++count;
            }
            if (!cursor_.at_line_end() || count < 3 + least_extra_) {
                return refuse(concat("vertex ", vertex, " has not the ", 3 + least_extra_,
                                     " numbers that the header announces"));
            }
            if (!mesh_.add_vertex(position)) return refused_by_mesh();
        }
        return true;
    }

    bool read_faces()
    {
        if (!mesh_.reserve_triangles(face_count_)) return refused_by_mesh();
        std::vector<std::uint32_t> corners;
        for (std::uint64_t face = 0; face < face_count_; ++face) {
            if (!begin_line("face", face, face_count_)) return false;
            std::int64_t length = 0;
            if (!cursor_.integer(length) || length < 0 ||
                static_cast<std::uint64_t>(length) < least_corners()) {
                return refuse(concat("face ", face, " does not start with ", least_corners(),
                                     " or more as its number of corners: remove or repair it"));
            }
            if (static_cast<std::uint64_t>(length) > max_face_corners) {
                return refuse(concat("face ", face, " has ", length, " corners, the limit is ",
                                     max_face_corners, ": cut it in the program that made it"),
                              ErrorCode::limit_exceeded);
            }
            corners.clear();
            for (std::int64_t i = 0; i < length; ++i) {
                std::int64_t index = 0;
                if (!cursor_.integer(index)) {
                    return refuse(concat("face ", face, " has not the ", length,
                                         " vertex numbers it announces"));
                }
                if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count_) {
                    return refuse(concat("face ", face, " uses vertex ", index,
                                         " but the file has ", vertex_count_, ", counted from 0"));
                }
                corners.push_back(static_cast<std::uint32_t>(index));
            }
            if (!skip_colour()) {
                return refuse(concat("face ", face, " has more behind its vertex numbers than the ",
                                     "4 numbers of a colour"));
            }
            const bool added =
                corners.size() < 3 ? mesh_.add_point_or_segment(corners) : mesh_.add_face(corners);
            if (!added) return refused_by_mesh();
        }
        return true;
    }

    [[nodiscard]] std::uint64_t least_corners() const noexcept
    {
        return mesh_.takes_points_and_lines() ? 1 : 3;
    }

    bool skip_colour()
    {
        double component = 0;
        int count = 0;
        while (count < 4 && cursor_.real(component)) ++count;
        return cursor_.at_line_end();
    }

    bool begin_line(std::string_view what, std::uint64_t index, std::uint64_t count)
    {
        if (!may_continue()) return false;
        if (cursor_.next_filled_line()) return true;
        return refuse(concat("the file ends before ", what, " ", index, " of ", count,
                             ": it is cut off, copy it again"));
    }

    std::uint64_t least_extra_ = 0; ///< numbers of a vertex behind its position
    std::uint64_t most_extra_ = 0;
    std::uint64_t vertex_count_ = 0;
    std::uint64_t face_count_ = 0;
};

} // namespace

Result<TriangleMesh> read_off(const MeshSource& source, const ReadOptions& options,
                              Vertices vertices)
{
    if (auto status = source.check_line_ends(); !status) return tl::unexpected(status.error());
    return OffReader(source, options).read(vertices);
}

} // namespace proxima::detail
