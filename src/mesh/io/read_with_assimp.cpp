#include "mesh/io/read_with_assimp.h"

#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "mesh/io/gltf_demand.h"
#include "mesh/io/scene_files.h"
#include "mesh/io/text_cursor.h"
#include "mesh/io/three_ds_faces.h"

#include <algorithm>
#include <assimp/Importer.hpp>
#include <assimp/scene.h>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace proxima::detail {

namespace {

using Transform = Eigen::Matrix4d;

Transform transform_of(const aiNode& node)
{
    const aiMatrix4x4& m = node.mTransformation;
    Transform transform;
    transform << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
        m.d3, m.d4;
    return transform;
}

std::uint32_t glb_number(std::string_view text, std::size_t position)
{
    std::uint32_t value = 0;
    for (std::size_t i = 4; i > 0; --i) {
        value = value << 8U | static_cast<unsigned char>(text[position + i - 1]);
    }
    return value;
}

// Assimp trusts the lengths of a GLB's parts and allocates that much. This checks them first.
//
//     "glTF" | version | length of all | then parts: length, kind, content
Status check_glb_lengths(const MeshSource& source)
{
    const std::string_view text = source.text;
    constexpr std::size_t header_bytes = 12;
    constexpr std::size_t part_header_bytes = 8;
    const auto number = [&](std::size_t position) { return glb_number(text, position); };
    if (text.size() < header_bytes + part_header_bytes || !text.starts_with("glTF")) {
        return fail(ErrorCode::malformed_file, "this is no GLB file: its header is missing",
                    source.name);
    }
    if (number(8) != text.size()) {
        return fail(ErrorCode::malformed_file,
                    concat("the header promises ", number(8), " bytes, the file has ", text.size(),
                           ": it is cut off or damaged"),
                    source.name);
    }
    if (number(4) != 2) {
        return fail(
            ErrorCode::unsupported_format,
            concat("it is of GLB version ", number(4), ", only version 2 is read: convert it"),
            source.name);
    }
    for (std::size_t position = header_bytes; position < text.size();) {
        const std::size_t left = text.size() - position;
        if (left < part_header_bytes || number(position) > left - part_header_bytes) {
            return fail(ErrorCode::malformed_file,
                        "a part is longer than what is left of the file: it is damaged",
                        source.at_byte(text.data() + position));
        }
        position += part_header_bytes + number(position);
    }
    return {};
}

// The JSON of a glTF, or of a GLB whose lengths are right.
std::string_view json_of(const MeshSource& source, MeshFormat format)
{
    constexpr std::size_t glb_json_begin = 20;
    if (format == MeshFormat::glb) {
        return source.text.substr(glb_json_begin, glb_number(source.text, 12));
    }
    return without_byte_order_mark(source.text);
}

/// Tells of a glTF's primitives.
Result<std::vector<GltfPrimitive>> check_before_reading(const MeshSource& source, MeshFormat format,
                                                        MemoryBudget budget)
{
    if (format == MeshFormat::three_ds) {
        if (const auto status = check_3ds_faces(source); !status)
            return tl::unexpected(status.error());
        return {};
    }
    if (format == MeshFormat::glb) {
        if (auto status = check_glb_lengths(source); !status) return tl::unexpected(status.error());
    }
    const std::string_view json = json_of(source, format);
    // Assimp passes what its glTF readers do not recognise to readers that are not safe.
    const std::size_t first = json.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || json[first] != '{') {
        return fail(ErrorCode::malformed_file,
                    concat("this is no ", format_name(format), " file: it has no JSON object"),
                    source.name);
    }
    return check_gltf_demand(source, json, budget);
}

// One mesh of the scene at one position.
struct Instance {
    const aiMesh* mesh = nullptr;
    Transform transform;
};

/// Refuses a scene with a mesh that is no primitive of the file: none has as many triangles and at least as
/// many vertices. assimp leaves out triangles of vertices that are not there, and may leave out vertices
/// of no triangle.
Status check_primitives(const MeshSource& source, const aiScene& scene,
                        const std::vector<GltfPrimitive>& primitives)
{
    for (const aiMesh* mesh : std::span(scene.mMeshes, scene.mNumMeshes)) {
        const std::span faces(mesh->mFaces, mesh->mNumFaces);
        const auto triangles = static_cast<std::uint64_t>(
            std::ranges::count_if(faces, [](const aiFace& face) { return face.mNumIndices >= 3; }));
        // One without positions has nothing to lose.
        if (mesh->mNumVertices == 0) continue;
        const auto most =
            std::ranges::upper_bound(primitives, triangles, {}, &GltfPrimitive::triangles);
        if (most != primitives.begin() && std::prev(most)->triangles == triangles &&
            std::prev(most)->vertices >= mesh->mNumVertices)
            continue;
        return fail(ErrorCode::malformed_file,
                    concat("mesh ", mesh->mName.C_Str(), " has ", mesh->mNumVertices,
                           " vertices and ", triangles,
                           " triangles: no primitive has as many. Triangles that name vertices "
                           "that are not there are missing, or its Draco data has others"),
                    source.name);
    }
    return {};
}

class SceneReader {
public:
    /// `to_file`: from the scene's coordinates to the file's.
    SceneReader(const MeshSource& source, const ReadOptions& options, const aiScene& scene,
                Transform to_file)
        : source_(source), options_(options), scene_(scene), to_file_(std::move(to_file)),
          mesh_(source, options)
    {}

    Result<TriangleMesh> read(Vertices vertices)
    {
        if (!find_instances()) return tl::unexpected(error_);
        // Counts everything before taking anything: one mesh may be instanced a million times.
        std::uint64_t vertex_count = 0;
        std::uint64_t face_count = 0;
        for (const Instance& instance : instances_) {
            vertex_count += instance.mesh->mNumVertices;
            face_count += instance.mesh->mNumFaces;
        }
        if (!mesh_.reserve_vertices(vertex_count) || !mesh_.reserve_triangles(face_count)) {
            return tl::unexpected(mesh_.error());
        }
        for (const Instance& instance : instances_) {
            if (is_cancelled(options_.execution.progress))
                return cancelled("reading", source_.name);
            if (!add(instance)) return tl::unexpected(error_);
        }
        return mesh_.finish(vertices);
    }

private:
    bool find_instances()
    {
        struct Pending {
            const aiNode* node = nullptr;
            Transform parent;
        };
        std::vector<Pending> pending{{scene_.mRootNode, to_file_}};
        while (!pending.empty()) {
            const Pending next = pending.back();
            pending.pop_back();
            const Transform transform = next.parent * transform_of(*next.node);
            for (unsigned i = 0; i < next.node->mNumMeshes; ++i) {
                const unsigned mesh = next.node->mMeshes[i];
                if (mesh >= scene_.mNumMeshes) {
                    return refuse(concat("a node uses mesh ", mesh, " of ", scene_.mNumMeshes));
                }
                instances_.push_back({scene_.mMeshes[mesh], transform});
            }
            // Pushes the last child first, so that meshes come in the order of the file.
            for (unsigned i = next.node->mNumChildren; i > 0; --i) {
                pending.push_back({next.node->mChildren[i - 1], transform});
            }
        }
        return true;
    }

    bool add(const Instance& instance)
    {
        const aiMesh& mesh = *instance.mesh;
        const auto first = static_cast<std::uint32_t>(mesh_.vertex_count());
        const Eigen::Matrix3d linear = instance.transform.topLeftCorner<3, 3>();
        const Vec3 translation = instance.transform.topRightCorner<3, 1>();
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            const aiVector3D& v = mesh.mVertices[i];
            if (!mesh_.add_vertex(linear * Vec3(v.x, v.y, v.z) + translation)) {
                return refused_by_mesh();
            }
        }
        const auto column = [&](int i) { return Displacement{Vec3::Zero(), linear.col(i)}; };
        // A mirroring transform reverses orientation, so the corners change their order.
        const bool mirrored = determinant_sign(column(0), column(1), column(2)) < 0;
        std::vector<std::uint32_t> corners;
        for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
            const aiFace& face = mesh.mFaces[i];
            if (face.mNumIndices < 3) continue;
            if (face.mNumIndices > max_face_corners) {
                return refuse(concat("face ", i, " has ", face.mNumIndices,
                                     " corners, the limit is ", max_face_corners));
            }
            corners.clear();
            for (unsigned corner = 0; corner < face.mNumIndices; ++corner) {
                const unsigned index =
                    face.mIndices[mirrored ? face.mNumIndices - 1 - corner : corner];
                if (index >= mesh.mNumVertices) {
                    return refuse(concat("face ", i, " of mesh ", mesh.mName.C_Str(),
                                         " uses vertex ", index, " of ", mesh.mNumVertices));
                }
                corners.push_back(first + index);
            }
            if (!mesh_.add_face(corners)) return refused_by_mesh();
        }
        return true;
    }

    bool refuse(std::string message)
    {
        error_ = {ErrorCode::malformed_file, std::move(message), source_.name};
        return false;
    }

    bool refused_by_mesh()
    {
        error_ = mesh_.error();
        return false;
    }

    const MeshSource& source_;
    const ReadOptions& options_;
    const aiScene& scene_;
    Transform to_file_;
    MeshAssembler mesh_;
    std::vector<Instance> instances_;
    Error error_;
};

/// Assimp turns what a 3DS file holds so that its z axis becomes y: here it is turned back.
Transform to_file_of(MeshFormat format)
{
    if (format != MeshFormat::three_ds) return Transform::Identity();
    Transform turn;
    turn << 1, 0, 0, 0, //
        0, 0, -1, 0,    //
        0, 1, 0, 0,     //
        0, 0, 0, 1;
    return turn;
}

const char* hint_of(MeshFormat format) noexcept
{
    if (format == MeshFormat::three_ds) return "3ds";
    return format == MeshFormat::gltf ? "gltf" : "glb";
}

} // namespace

Result<TriangleMesh> read_with_assimp(const MeshSource& source, const std::filesystem::path& folder,
                                      MeshFormat format, const ReadOptions& options,
                                      Vertices vertices)
{
    MeshSource for_assimp = source;
    if (format == MeshFormat::gltf) for_assimp.text = json_of(source, format);
    ReadProgress progress(options.execution.progress, source.text);
    const auto primitives = check_before_reading(source, format, options.execution.budget);
    if (!primitives) return tl::unexpected(primitives.error());
    try {
        // No post-processing: assimp joins vertices and finds degenerate triangles by tolerances.
        Assimp::Importer importer;
        // Names in the scene are relative to it: assimp is not told its folder.
        // A name that no file has: a scene may refer to one called scene.gltf.
        const std::string scene_name = concat("\x01scene.", hint_of(format));
        auto owned_files =
            std::make_unique<SceneFiles>(for_assimp, scene_name, folder, options.execution.budget);
        const SceneFiles& files = *owned_files;
        importer.SetIOHandler(owned_files.release()); // the importer deletes it
        constexpr unsigned no_steps = 0;
        const aiScene* scene = importer.ReadFile(scene_name, no_steps);
        if (files.error()) return tl::unexpected(*files.error());
        if (scene == nullptr || scene->mRootNode == nullptr ||
            (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0U) {
            const std::string_view reason = importer.GetErrorString();
            // assimp keeps no more than the text of what its readers throw.
            if (reason.find("bad_alloc") != std::string_view::npos) throw std::bad_alloc();
            return fail(ErrorCode::malformed_file,
                        reason.empty()
                            ? concat("this ", format_name(format), " file has no mesh in its scene")
                            : concat("this is no complete ", format_name(format),
                                     " file, assimp says: ", reason),
                        source.name);
        }
        if (format != MeshFormat::three_ds) {
            if (const auto status = check_primitives(source, *scene, *primitives); !status)
                return tl::unexpected(status.error());
        }
        if (!progress.may_continue(source.text.data() + source.text.size())) {
            return cancelled("reading", source.name);
        }
        return SceneReader(source, options, *scene, to_file_of(format)).read(vertices);
    } catch (const std::bad_alloc&) {
        throw; // is no flaw of the file
    } catch (const std::exception& exception) {
        return fail(ErrorCode::malformed_file,
                    concat("assimp cannot read this file: ", exception.what()), source.name);
    }
}

} // namespace proxima::detail
