#include "mesh/io/gltf_geometry.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <optional>

namespace proxima::detail {

namespace {

using Id = JsonText::Id;

/// Extensions that say nothing of where triangles are, by how their names begin, and the one that is read.
constexpr std::array<std::string_view, 10> harmless = {"KHR_draco_mesh_compression",
                                                       "KHR_materials_",
                                                       "KHR_texture_",
                                                       "KHR_lights_",
                                                       "KHR_xmp",
                                                       "KHR_animation_pointer",
                                                       "EXT_texture_",
                                                       "EXT_lights_",
                                                       "MSFT_texture_",
                                                       "ADOBE_materials_"};

constexpr std::array<double, 3> index_types = {5121, 5123, 5125};
constexpr double float_type = 5126;
constexpr double long_index_type = 5125;
constexpr double triangle_mode = 4;
constexpr double strip_mode = 5;
constexpr double fan_mode = 6;
constexpr double most_count = 0x1p40; // of an accessor, in whole numbers

std::vector<Id> list(const JsonText& json, Id id, std::string_view key)
{
    const auto found = json.member(id, key);
    return found ? json.children(*found) : std::vector<Id>{};
}

class GeometryCheck {
public:
    GeometryCheck(const MeshSource& source, const JsonText& json)
        : source_(source), json_(json), accessors_(list(json, JsonText::root(), "accessors"))
    {}

    /// assimp would read glTF 1 by a reader that ends the program where an index is out of range.
    [[nodiscard]] Status version() const
    {
        const auto asset = json_.member(JsonText::root(), "asset");
        const auto version = asset ? json_.member(*asset, "version") : std::nullopt;
        const std::string_view text = version ? json_[*version].text : std::string_view();
        if (text == "2" || text.starts_with("2.")) return {};
        return fail(ErrorCode::unsupported_format,
                    text.empty() ? std::string("it does not say which version of glTF it is of")
                                 : concat("it is of glTF version ", text.substr(0, 20),
                                          ", only version 2 is read: convert it"),
                    source_.name);
    }

    [[nodiscard]] Status extensions() const
    {
        for (const Id each : list(json_, JsonText::root(), "extensionsRequired")) {
            const std::string_view name = json_[each].text;
            const auto begins_so = [&](std::string_view start) { return name.starts_with(start); };
            if (std::ranges::any_of(harmless, begins_so)) continue;
            const std::string_view advice = name == "KHR_mesh_quantization"
                                                ? "write positions as floats (gltfpack -noq)"
                                                : "save it without";
            return fail(ErrorCode::unsupported_format,
                        concat("it requires the extension ", name, ", which is not read: ", advice),
                        source_.name);
        }
        return {};
    }

    [[nodiscard]] Result<std::vector<GltfPrimitive>> primitives() const
    {
        std::vector<GltfPrimitive> found;
        const std::vector<Id> meshes = list(json_, JsonText::root(), "meshes");
        for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
            for (const Id primitive : list(json_, meshes[mesh], "primitives")) {
                const auto checked = check(primitive, mesh);
                if (!checked) return tl::unexpected(checked.error());
                found.push_back(*checked);
            }
        }
        std::ranges::sort(found);
        return found;
    }

private:
    [[nodiscard]] Result<GltfPrimitive> check(Id primitive, std::size_t mesh) const
    {
        const auto refuse = [&](std::string_view what) {
            return fail(ErrorCode::malformed_file, concat(what, " of mesh ", mesh), source_.name);
        };
        const auto extensions = json_.member(primitive, "extensions");
        const bool is_draco =
            extensions && json_.member(*extensions, "KHR_draco_mesh_compression").has_value();
        const auto attributes = json_.member(primitive, "attributes");
        const auto positions = attributes ? accessor(*attributes, "POSITION") : std::nullopt;
        if (positions) {
            if (json_.number(*positions, "componentType", float_type) != float_type)
                return refuse("floats are needed for the positions");
            const auto type = json_.member(*positions, "type");
            if (type && json_[*type].text != "VEC3")
                return refuse("three numbers each are needed for the positions");
        }
        const auto indices = accessor(primitive, "indices");
        if (indices) {
            const double type = json_.number(*indices, "componentType", index_types.back());
            if (std::ranges::find(index_types, type) == index_types.end())
                return refuse("unsigned integers are needed for the indices");
            if (is_draco && type == long_index_type) {
                return fail(ErrorCode::unsupported_format,
                            concat("Draco data with 32-bit indices, which is not read, in mesh ",
                                   mesh, ": save it without Draco compression"),
                            source_.name);
            }
            const auto shape = json_.member(*indices, "type");
            if (shape && json_[*shape].text != "SCALAR")
                return refuse("single numbers are needed for the indices");
        }
        const auto corners = indices ? indices : positions;
        const std::uint64_t count = corners ? count_of(*corners) : 0;
        const double mode = json_.number(primitive, "mode", triangle_mode);
        if (mode == triangle_mode && count % 3 != 0) {
            return refuse("the last triangle is not whole: the number of corners is no multiple of "
                          "three in a primitive");
        }
        GltfPrimitive has = {.vertices = positions ? count_of(*positions) : 0};
        if (mode == triangle_mode) has.triangles = count / 3;
        if (mode == strip_mode || mode == fan_mode) has.triangles = count < 3 ? 0 : count - 2;
        return has;
    }

    [[nodiscard]] std::uint64_t count_of(Id accessor) const
    {
        const double count = json_.number(accessor, "count", 0);
        return count >= 0 ? static_cast<std::uint64_t>(std::min(count, most_count)) : 0;
    }

    [[nodiscard]] std::optional<Id> accessor(Id owner, std::string_view key) const
    {
        const auto reference = json_.member(owner, key);
        if (!reference || json_[*reference].kind != JsonText::Kind::number) return std::nullopt;
        const double number = json_[*reference].number;
        if (!(number >= 0 && number < static_cast<double>(accessors_.size()))) return std::nullopt;
        return accessors_[static_cast<std::size_t>(number)];
    }

    const MeshSource& source_;
    const JsonText& json_;
    std::vector<Id> accessors_;
};

} // namespace

Result<std::vector<GltfPrimitive>> check_gltf_geometry(const MeshSource& source,
                                                       const JsonText& json)
{
    const GeometryCheck check(source, json);
    if (const Status status = check.version(); !status) return tl::unexpected(status.error());
    if (const Status status = check.extensions(); !status) return tl::unexpected(status.error());
    return check.primitives();
}

} // namespace proxima::detail
