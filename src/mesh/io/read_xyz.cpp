#include "mesh/io/read_xyz.h"

#include "base/text.h"
#include "mesh/io/text_cursor.h"
#include "mesh/io/text_mesh_reader.h"

namespace proxima::detail {

namespace {

using XyzCursor = TextCursor<TextDialect{.has_comments = true}>;

class XyzReader : TextMeshReader<XyzCursor> {
public:
    XyzReader(const MeshSource& source, const ReadOptions& options)
        : TextMeshReader(source, options)
    {}

    Result<TriangleMesh> read(Vertices vertices)
    {
        while (cursor_.next_filled_line())
            if (!may_continue() || !read_point()) return tl::unexpected(error());
        if (!mesh_.add_points_of_vertices()) {
            (void)refused_by_mesh();
            return tl::unexpected(error());
        }
        return mesh_.finish(vertices);
    }

private:
    bool read_point()
    {
        Vec3 position;
        double other = 0;
        int count = 0;
        while (cursor_.real(count < 3 ? position[count] : other)) count = std::min(count + 1, 3);
        if (!cursor_.at_line_end()) {
            return refuse("a line has something that is not a number: each has x y z with blanks "
                          "between them, and numbers that are passed over");
        }
        if (count < 3) {
            return refuse(concat("a line has ", count, count == 1 ? " number" : " numbers",
                                 ": a point needs x y z"));
        }
        return mesh_.add_vertex(position) || refused_by_mesh();
    }
};

} // namespace

Result<TriangleMesh> read_xyz(const MeshSource& source, const ReadOptions& options,
                              Vertices vertices)
{
    if (auto status = source.check_line_ends(); !status) return tl::unexpected(status.error());
    return XyzReader(source, options).read(vertices);
}

} // namespace proxima::detail
