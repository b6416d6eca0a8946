#include "mesh/io/read_ply.h"

#include "base/text.h"
#include "mesh/io/mesh_assembler.h"
#include "mesh/io/ply_header.h"
#include "mesh/io/ply_values.h"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

namespace proxima::detail {

namespace {

enum class ElementKind : std::uint8_t { vertex, face, strips, edge, other };

ElementKind kind_of(const PlyElement& element) noexcept
{
    if (element.name == "vertex") return ElementKind::vertex;
    if (element.name == "face") return ElementKind::face;
    if (element.name == "tristrips") return ElementKind::strips;
    if (element.name == "edge") return ElementKind::edge;
    return ElementKind::other;
}

bool names_corners(const PlyProperty& property) noexcept
{
    return property.name == "vertex_indices" || property.name == "vertex_index";
}

// Which coordinate a property of a vertex is, -1 for none.
int axis_of(const PlyProperty& property) noexcept
{
    if (property.name == "x") return 0;
    if (property.name == "y") return 1;
    return property.name == "z" ? 2 : -1;
}

// Which end a property of an edge is, -1 for none.
int end_of(const PlyProperty& property) noexcept
{
    if (property.name == "vertex1") return 0;
    return property.name == "vertex2" ? 1 : -1;
}

// Turns the indices of a strip list into triangles and reverses every second one.
class StripCutter {
public:
    enum class Step : std::uint8_t { taken, stray_corners, refused };

    explicit StripCutter(MeshAssembler& mesh) noexcept : mesh_(mesh) {}

    Step corner(std::uint32_t corner)
    {
        Step step = Step::taken;
        if (length_ >= 2) {
            const bool flipped = length_ % 2 != 0;
            const TriangleCorners corners = flipped ? TriangleCorners{after_, before_, corner}
                                                    : TriangleCorners{before_, after_, corner};
            if (!mesh_.add_triangle(corners)) step = Step::refused;
        }
        before_ = after_;
        after_ = corner;
        ++length_;
        return step;
    }

    /// Ends a strip. Strips of one or two corners are refused, because they would be lost.
    Step end()
    {
        const bool stray = length_ == 1 || length_ == 2;
        length_ = 0;
        return stray ? Step::stray_corners : Step::taken;
    }

private:
    MeshAssembler& mesh_;
    std::uint32_t before_ = 0;
    std::uint32_t after_ = 0;
    std::uint64_t length_ = 0;
};

template <class Values>
class BodyReader {
public:
    BodyReader(const MeshSource& source, const ReadOptions& options, const PlyHeader& header)
        : source_(source), header_(header), values_(header.body), mesh_(source, options),
          progress_(options.execution.progress, source.text)
    {}

    Result<TriangleMesh> read(Vertices vertices)
    {
        const auto vertex_element =
            std::ranges::find(header_.elements, ElementKind::vertex, kind_of);
        if (vertex_element == header_.elements.end()) {
            return fail(ErrorCode::malformed_file, "the header has no element \"vertex\"",
                        source_.name);
        }
        vertex_count_ = vertex_element->count;
        for (const PlyElement& element : header_.elements) {
            element_ = &element;
            element_index_ = 0;
            if (!read_element()) return tl::unexpected(error_);
        }
        if (!values_.is_complete()) {
            return fail(ErrorCode::malformed_file,
                        "there is more data than the header declares: one of its counts is wrong",
                        where());
        }
        if (mesh_.takes_points_and_lines() && mesh_.triangle_count() == 0 &&
            !mesh_.add_points_of_vertices()) {
            return tl::unexpected(mesh_.error());
        }
        return mesh_.finish(vertices);
    }

private:
    bool read_element()
    {
        if (!can_hold_all()) return false;
        switch (kind_of(*element_)) {
        case ElementKind::vertex:
            return read_vertices();
        case ElementKind::face:
            return read_lists<ElementKind::face>();
        case ElementKind::strips:
            return read_lists<ElementKind::strips>();
        case ElementKind::edge:
            if (mesh_.takes_points_and_lines()) return read_edges();
            break;
        case ElementKind::other:
            break;
        }
        if (element_->properties.empty()) return true;
        return each_element([&] {
            return std::ranges::all_of(element_->properties, [&](const PlyProperty& property) {
                return skip_property(property);
            });
        });
    }

    // No count may allocate more than the file can fill.
    bool can_hold_all()
    {
        std::uint64_t least = 0;
        for (const PlyProperty& property : element_->properties) {
            least += values_.least_bytes(property.length_type.value_or(property.type));
        }
        if (least == 0 || element_->count <= values_.remaining() / least) return true;
        return refuse(ErrorCode::malformed_file,
                      concat("the header promises ", element_->count, " elements \"",
                             element_->name.substr(0, 40), "\", which need at least ", least,
                             " bytes each, but only ", values_.remaining(),
                             " are left: the file is cut off or its header wrong"));
    }

    template <class ReadOne>
    bool each_element(ReadOne&& read_one)
    {
        for (element_index_ = 0; element_index_ < element_->count; ++element_index_) {
            if (!progress_.may_continue(values_.position())) {
                error_ = cancelled("reading", source_.name).value();
                return false;
            }
            if (!values_.begin_element()) return refuse_value();
            if (!read_one()) return false;
            if (!values_.end_element()) return refuse_value();
        }
        return true;
    }

    bool read_vertices()
    {
        int found = 0;
        std::vector<int> axes;
        for (const PlyProperty& property : element_->properties) {
            const int axis = axis_of(property);
            axes.push_back(axis);
            if (axis < 0) continue;
            if (property.length_type || (found & (1 << axis)) != 0) {
                return refuse(ErrorCode::malformed_file,
                              concat("the vertex property \"", property.name,
                                     "\" is a list or stands there twice"));
            }
            found |= 1 << axis;
        }
        if (found != 7) {
            return refuse(ErrorCode::malformed_file, "vertices need the properties x, y and z");
        }
        if (!mesh_.reserve_vertices(element_->count)) return refused_by_mesh();
        return each_element([&] {
            Vec3 position;
            for (std::size_t i = 0; i < axes.size(); ++i) {
                const PlyProperty& property = element_->properties[i];
                if (axes[i] < 0) {
                    if (!skip_property(property)) return false;
                } else if (!values_.real(property.type, position[axes[i]])) {
                    return refuse_value();
                }
            }
            return mesh_.add_vertex(position) || refused_by_mesh();
        });
    }

    bool read_edges()
    {
        int found = 0;
        for (const PlyProperty& property : element_->properties) {
            const int end = end_of(property);
            if (end >= 0 && !property.length_type) found |= 1 << end;
        }
        if (found != 3 && element_->count > 0) {
            return refuse(ErrorCode::malformed_file,
                          "edges need the properties vertex1 and vertex2");
        }
        if (!mesh_.reserve_triangles(element_->count)) return refused_by_mesh();
        return each_element([&] {
            std::array<std::uint32_t, 2> ends{};
            for (const PlyProperty& property : element_->properties) {
                const int end = end_of(property);
                const bool read =
                    end < 0 ? skip_property(property)
                            : read_corner(property.type, ends[static_cast<std::size_t>(end)]);
                if (!read) return false;
            }
            return mesh_.add_point_or_segment(ends) || refused_by_mesh();
        });
    }

    template <ElementKind Kind>
    bool read_lists()
    {
        const auto lists = std::ranges::count_if(element_->properties, names_corners);
        const auto list = std::ranges::find_if(element_->properties, names_corners);
        if (element_->count == 0) return true;
        if (lists != 1 || !list->length_type) {
            return refuse(
                ErrorCode::malformed_file,
                concat("the element \"", element_->name,
                       R"(" needs one list property "vertex_indices" or "vertex_index")"));
        }
        if (Kind == ElementKind::face && !mesh_.reserve_triangles(element_->count)) {
            return refused_by_mesh();
        }
        const auto list_index = list - element_->properties.begin();
        return each_element([&] {
            for (std::ptrdiff_t i = 0; i < std::ssize(element_->properties); ++i) {
                const PlyProperty& property = element_->properties[static_cast<std::size_t>(i)];
                const bool read = i != list_index             ? skip_property(property)
                                  : Kind == ElementKind::face ? read_face(property)
                                                              : read_strips(property);
                if (!read) return false;
            }
            return true;
        });
    }

    bool read_face(const PlyProperty& list)
    {
        std::int64_t length = 0;
        if (!read_length(list, length)) return false;
        if (length == 3) {
            TriangleCorners corners{};
            for (std::uint32_t& corner : corners) {
                if (!read_corner(list.type, corner)) return false;
            }
            return mesh_.add_triangle(corners) || refused_by_mesh();
        }
        if (length < 3) {
            return refuse(ErrorCode::malformed_file,
                          concat(element_name(), " has ", length,
                                 " corners, a face needs at least 3: remove it"));
        }
        if (static_cast<std::uint64_t>(length) > max_face_corners) {
            return refuse(ErrorCode::limit_exceeded,
                          concat(element_name(), " has ", length, " corners, the limit is ",
                                 max_face_corners, ": cut it in the program that made it"));
        }
        corners_.clear();
        for (std::int64_t i = 0; i < length; ++i) {
            std::uint32_t corner = 0;
            if (!read_corner(list.type, corner)) return false;
            corners_.push_back(corner);
        }
        return mesh_.add_face(corners_) || refused_by_mesh();
    }

    bool read_strips(const PlyProperty& list)
    {
        std::int64_t length = 0;
        if (!read_length(list, length)) return false;
        StripCutter strip(mesh_);
        for (std::int64_t i = 0; i <= length; ++i) {
            std::int64_t index = -1; // what the end of the list stands for
            if (i < length && !values_.integer(list.type, index)) return refuse_value();
            if (index != -1 && !is_vertex(index)) return refuse_index(index);
            const auto step =
                index == -1 ? strip.end() : strip.corner(static_cast<std::uint32_t>(index));
            if (step == StripCutter::Step::refused) return refused_by_mesh();
            if (step == StripCutter::Step::stray_corners) {
                return refuse(
                    ErrorCode::malformed_file,
                    concat(element_name(), " has a strip of fewer than 3 corners: remove it"));
            }
        }
        return true;
    }

    // The length of a list, if the file can hold that many items.
    bool read_length(const PlyProperty& list, std::int64_t& length)
    {
        if (!values_.integer(*list.length_type, length)) return refuse_value();
        const std::uint64_t most = values_.remaining() / values_.least_bytes(list.type);
        if (length >= 0 && static_cast<std::uint64_t>(length) <= most) return true;
        return refuse(ErrorCode::malformed_file,
                      concat(element_name(), " has a list of ", length,
                             " items, but what is left of the file holds ", most, " at most"));
    }

    bool skip_property(const PlyProperty& property)
    {
        std::int64_t length = 1;
        if (property.length_type && !read_length(property, length)) return false;
        for (; length > 0; --length) {
            if (!values_.skip(property.type)) return refuse_value();
        }
        return true;
    }

    bool read_corner(PlyType type, std::uint32_t& corner)
    {
        std::int64_t index = 0;
        if (!values_.integer(type, index)) return refuse_value();
        if (!is_vertex(index)) return refuse_index(index);
        corner = static_cast<std::uint32_t>(index);
        return true;
    }

    [[nodiscard]] bool is_vertex(std::int64_t index) const noexcept
    {
        return index >= 0 && static_cast<std::uint64_t>(index) < vertex_count_;
    }

    [[nodiscard]] std::string element_name() const
    {
        return concat(element_->name.substr(0, 40), " ", element_index_);
    }

    [[nodiscard]] std::string where() const
    {
        const bool is_text = header_.body_kind == PlyBody::ascii;
        return is_text ? source_.at_line(values_.position()) : source_.at_byte(values_.position());
    }

    bool refuse(ErrorCode code, std::string message)
    {
        error_ = {code, std::move(message), where()};
        return false;
    }

    bool refused_by_mesh()
    {
        error_ = mesh_.error();
        return false;
    }

    bool refuse_index(std::int64_t index)
    {
        return refuse(ErrorCode::malformed_file,
                      concat(element_name(), " uses vertex ", index, " but the file has ",
                             vertex_count_, ", counted from 0"));
    }

    bool refuse_value()
    {
        const std::string name = element_name();
        switch (values_.failure()) {
        case PlyFailure::missing_value:
            return refuse(ErrorCode::malformed_file,
                          concat(name, " has fewer values on its line than the header declares"));
        case PlyFailure::extra_value:
            return refuse(ErrorCode::malformed_file,
                          concat(name, " has more values on its line than the header declares"));
        case PlyFailure::no_number:
            return refuse(ErrorCode::malformed_file,
                          concat(name, " has a value that is not a number of its kind"));
        case PlyFailure::ends_early:
        case PlyFailure::none:
            break;
        }
        return refuse(ErrorCode::malformed_file,
                      concat("the file ends in ", name, " of ", element_->count,
                             ": it is cut off, copy it again"));
    }

    const MeshSource& source_;
    const PlyHeader& header_;
    Values values_;
    MeshAssembler mesh_;
    ReadProgress progress_;
    std::uint64_t vertex_count_ = 0;
    const PlyElement* element_ = nullptr;
    std::uint64_t element_index_ = 0;
    std::vector<std::uint32_t> corners_;
    Error error_;
};

} // namespace

Result<TriangleMesh> read_ply(const MeshSource& source, const ReadOptions& options,
                              Vertices vertices)
{
    if (auto status = source.check_line_ends(); !status) return tl::unexpected(status.error());
    const auto header = read_ply_header(source);
    if (!header) return tl::unexpected(header.error());
    switch (header->body_kind) {
    case PlyBody::ascii:
        return BodyReader<PlyTextValues>(source, options, *header).read(vertices);
    case PlyBody::little_endian:
        return BodyReader<PlyBinaryValues<std::endian::little>>(source, options, *header)
            .read(vertices);
    case PlyBody::big_endian:
        break;
    }
    return BodyReader<PlyBinaryValues<std::endian::big>>(source, options, *header).read(vertices);
}

} // namespace proxima::detail
