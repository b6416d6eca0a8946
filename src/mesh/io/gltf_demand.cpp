#include "mesh/io/gltf_demand.h"

#include "base/memory_budget.h"
#include "base/text.h"
#include "mesh/io/json_text.h"

#include <algorithm>
#include <cmath>

namespace proxima::detail {

namespace {

using Id = JsonText::Id;

// Bytes that assimp 5.2 allocates for one of each, rounded up.
constexpr double bytes_of_attribute = 32;    // a vector or colour, and its copy while it is read
constexpr double bytes_of_bone_weight = 96;  // four joints and weights of a vertex
constexpr double bytes_of_corner = 24;       // a third of a triangle
constexpr double bytes_of_loose_corner = 96; // of faces that are points, lines or strips
constexpr double bytes_of_matrix = 64;
constexpr double bytes_of_key = 64; // of an animation
constexpr double bytes_of_mesh = 3000;
constexpr double bytes_of_node = 3000;
constexpr double bytes_of_bone = 3000;
constexpr double bytes_of_image = 3000;
constexpr double bytes_of_material = 20000;

constexpr int max_node_depth = 1000;
constexpr double longest_file = 0x1p40;

/// The items of "accessors", "nodes" and so on.
using Section = std::vector<Id>;

class Demand {
public:
    Demand(const MeshSource& source, const JsonText& json)
        : source_(source), json_(json), accessors_(section("accessors")),
          views_(section("bufferViews")), nodes_(section("nodes")), meshes_(section("meshes")),
          skins_(section("skins"))
    {}

    /// In bytes; not finite where no number is enough.
    Result<double> bytes()
    {
        measure_accessors_and_skins();
        measure_meshes();
        if (auto status = measure_nodes(); !status) return tl::unexpected(status.error());
        double all = loose_bytes() + scene_bytes();
        for (const double mesh : mesh_bytes_) all += mesh;
        return all;
    }

private:
    [[nodiscard]] Section section(std::string_view key) const
    {
        return list(JsonText::root(), key);
    }

    [[nodiscard]] std::optional<std::size_t> find(const Section& section, Id reference) const
    {
        const JsonText::Value& value = json_[reference];
        if (value.kind == JsonText::Kind::number && value.number >= 0 &&
            value.number < static_cast<double>(section.size())) {
            return static_cast<std::size_t>(value.number);
        }
        return std::nullopt;
    }

    // The children of a member, if the member exists.
    [[nodiscard]] std::vector<Id> list(Id id, std::string_view key) const
    {
        const auto found = json_.member(id, key);
        return found ? json_.children(*found) : std::vector<Id>{};
    }

    // A missing number demands nothing. A negative number demands more than any file has.
    [[nodiscard]] double amount(Id id, std::string_view key) const
    {
        const double number = json_.number(id, key, 0);
        return number >= 0 ? number : HUGE_VAL;
    }

    [[nodiscard]] double accessor_count(Id reference) const
    {
        const auto found = find(accessors_, reference);
        return found ? counts_[*found] : 0;
    }

    // Everything that belongs to neither a mesh nor a node.
    [[nodiscard]] double loose_bytes() const
    {
        double all = 0;
        for (const Id buffer : section("buffers")) all += amount(buffer, "byteLength");
        for (const Section* section : {&views_, &accessors_}) {
            for (const Id item : *section) {
                // Larger values would overflow when offsets are added.
                for (const std::string_view key : {"byteOffset", "byteLength", "byteStride"}) {
                    if (amount(item, key) > longest_file) all = HUGE_VAL;
                }
            }
        }
        for (const Id accessor : accessors_) {
            // A sparse accessor is expanded to all of its zeros.
            const bool is_sparse = json_.member(accessor, "sparse").has_value();
            all += is_sparse ? amount(accessor, "count") * bytes_of_matrix : 0;
        }
        for (const Id image : section("images")) all += bytes_of_image + view_bytes(image);
        all += static_cast<double>(section("materials").size()) * bytes_of_material;
        for (const Id animation : section("animations")) all += animation_bytes(animation);
        return all;
    }

    [[nodiscard]] double view_bytes(Id image) const
    {
        const auto reference = json_.member(image, "bufferView");
        const auto found = reference ? find(views_, *reference) : std::nullopt;
        return found ? amount(views_[*found], "byteLength") : 0;
    }

    // Every channel keeps the keys of its sampler.
    [[nodiscard]] double animation_bytes(Id animation) const
    {
        const Section samplers = list(animation, "samplers");
        std::vector<double> key_bytes;
        double all = 0;
        for (const Id sampler : samplers) {
            double keys = 0;
            for (const std::string_view key : {"input", "output"}) {
                const auto accessor = json_.member(sampler, key);
                if (accessor) keys += accessor_count(*accessor);
            }
            key_bytes.push_back(keys * bytes_of_key);
            all += key_bytes.back();
        }
        for (const Id channel : list(animation, "channels")) {
            all += bytes_of_bone;
            const auto reference = json_.member(channel, "sampler");
            const auto found = reference ? find(samplers, *reference) : std::nullopt;
            if (found) all += key_bytes[*found];
        }
        return all;
    }

    // Once each, for as many references as a file likes.
    void measure_accessors_and_skins()
    {
        for (const Id accessor : accessors_) counts_.push_back(amount(accessor, "count"));
        for (const Id skin : skins_) {
            const auto matrices = json_.member(skin, "inverseBindMatrices");
            skin_bytes_.push_back(static_cast<double>(list(skin, "joints").size()) * bytes_of_bone +
                                  (matrices ? accessor_count(*matrices) * bytes_of_matrix : 0));
        }
    }

    void measure_meshes()
    {
        for (const Id mesh : meshes_) {
            const std::vector<Id> primitives = list(mesh, "primitives");
            double all = 0;
            for (const Id primitive : primitives) all += primitive_bytes(primitive);
            mesh_bytes_.push_back(all);
            primitive_counts_.push_back(static_cast<double>(primitives.size()));
        }
    }

    // An accessor is copied as often as primitives refer to it.
    [[nodiscard]] double primitive_bytes(Id primitive) const
    {
        double vertices = 0;
        double attributes = 0;
        for (const Id attribute : list(primitive, "attributes")) {
            const std::string_view name = json_[attribute].key;
            const bool is_bone = name.starts_with("JOINT") || name.starts_with("WEIGHT");
            const double count = accessor_count(attribute);
            vertices = std::max(vertices, count);
            attributes += count * (is_bone ? bytes_of_bone_weight : bytes_of_attribute);
        }
        const auto indices = json_.member(primitive, "indices");
        const double corners = indices ? accessor_count(*indices) : vertices;
        constexpr double triangles = 4;
        const bool is_loose = json_.number(primitive, "mode", triangles) != triangles;
        double all = bytes_of_mesh + attributes +
                     corners * (is_loose ? bytes_of_loose_corner : bytes_of_corner);
        // A morph target is a modified copy of the mesh.
        for (const Id target : list(primitive, "targets")) {
            all += bytes_of_mesh + attributes;
            for (const Id moved : json_.children(target)) {
                all += accessor_count(moved) * bytes_of_attribute;
            }
        }
        return all;
    }

    // For each node its height above its leaves and the bytes of its subtree. A node with two
    // parents counts twice.
    Status measure_nodes()
    {
        enum class State : std::uint8_t { fresh, open, done };
        struct Visit {
            std::size_t node = 0;
            std::vector<std::size_t> children;
            std::size_t next = 0;
        };
        std::vector<State> states(nodes_.size(), State::fresh);
        std::vector<int> heights(nodes_.size(), 1);
        node_bytes_.assign(nodes_.size(), 0);
        std::vector<Visit> path;
        const auto enter = [&](std::size_t node) {
            states[node] = State::open;
            node_bytes_[node] = own_bytes(nodes_[node]);
            path.push_back({node, references(nodes_[node], "children", nodes_), 0});
        };
        for (std::size_t start = 0; start < nodes_.size(); ++start) {
            if (states[start] == State::fresh) enter(start);
            while (!path.empty()) {
                Visit& visit = path.back();
                if (visit.next == visit.children.size()) {
                    states[visit.node] = State::done;
                    path.pop_back();
                    continue;
                }
                const std::size_t child = visit.children[visit.next];
                if (states[child] == State::open) {
                    return fail(ErrorCode::malformed_file, "a node is its own descendant",
                                source_.name);
                }
                if (states[child] == State::fresh) {
                    enter(child); // and come back here when it is done
                    continue;
                }
                ++visit.next;
                node_bytes_[visit.node] += node_bytes_[child];
                heights[visit.node] = std::max(heights[visit.node], heights[child] + 1);
                if (heights[visit.node] > max_node_depth) {
                    return fail(
                        ErrorCode::limit_exceeded,
                        concat("its nodes lie more than ", max_node_depth, " deep in each other"),
                        source_.name);
                }
            }
        }
        return {};
    }

    [[nodiscard]] std::vector<std::size_t> references(Id id, std::string_view key,
                                                      const Section& section) const
    {
        std::vector<std::size_t> found;
        for (const Id reference : list(id, key)) {
            if (const auto index = find(section, reference)) found.push_back(*index);
        }
        return found;
    }

    // The bytes of a node without its children. Each mesh with a skin gets all of the skin's bones.
    [[nodiscard]] double own_bytes(Id node) const
    {
        const auto skin_reference = json_.member(node, "skin");
        const auto skin = skin_reference ? find(skins_, *skin_reference) : std::nullopt;
        const auto mesh_reference = json_.member(node, "mesh");
        const auto mesh = mesh_reference ? find(meshes_, *mesh_reference) : std::nullopt;
        double all = bytes_of_node;
        if (mesh) all += primitive_counts_[*mesh] * sizeof(unsigned);
        if (mesh && skin) all += primitive_counts_[*mesh] * skin_bytes_[*skin];
        return all;
    }

    // The demand of the scene that needs most.
    [[nodiscard]] double scene_bytes() const
    {
        double most = 0;
        for (const Id scene : section("scenes")) {
            double all = 0;
            for (const std::size_t node : references(scene, "nodes", nodes_)) {
                all += node_bytes_[node];
            }
            most = std::max(most, all);
        }
        return most;
    }

    const MeshSource& source_;
    const JsonText& json_;
    Section accessors_;
    Section views_;
    Section nodes_;
    Section meshes_;
    Section skins_;
    std::vector<double> counts_;     ///< by accessor
    std::vector<double> skin_bytes_; ///< of a mesh that has the skin
    std::vector<double> mesh_bytes_;
    std::vector<double> primitive_counts_;
    std::vector<double> node_bytes_;
};

} // namespace

Result<std::vector<GltfPrimitive>> check_gltf_demand(const MeshSource& source,
                                                     std::string_view json, MemoryBudget budget)
{
    const auto text = JsonText::parse(source, json, budget);
    if (!text) return tl::unexpected(text.error());
    const auto bytes = Demand(source, *text).bytes();
    if (!bytes) return tl::unexpected(bytes.error());
    const auto limit = static_cast<double>(budget_bytes(budget));
    if (!(*bytes <= limit)) {
        return fail(ErrorCode::budget_exceeded,
                    concat("its scene may need ", *bytes / 1e6,
                           " MB while it is read, the budget is ", limit / 1e6,
                           " MB: raise it, or decimate or convert the mesh"),
                    source.name);
    }
    return check_gltf_geometry(source, *text);
}

} // namespace proxima::detail
