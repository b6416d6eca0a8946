// Reading and writing mesh files.
//
//     auto mesh = read_mesh("bunny.obj");
//     if (!mesh) { std::cerr << describe(mesh.error()); ... }   // bunny.obj:12: vertex 9 ... of 8
//     auto status = write_mesh(*mesh, "bunny.ply");
//
// OBJ, PLY, STL, OFF and XYZ are read in double precision: vertices and faces keep the order of the
// file. Points and lines become triangles without area (mesh_of_points in triangle_mesh.h): those of
// XYZ files always, those of OBJ, PLY and OFF files where ReadOptions::primitives says so.
// 3DS, glTF and GLB, whose numbers are float32, are read by assimp where the library was built with
// PROXIMA_WITH_ASSIMP.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace PROXIMA_EXPORT proxima {

enum class MeshFormat : std::uint8_t { obj, ply, stl, off, xyz, three_ds, gltf, glb };

/// Short name for messages: "OBJ", "3DS".
[[nodiscard]] std::string_view format_name(MeshFormat format) noexcept;

/// The format that the extension of `path` stands for, in any letter case.
[[nodiscard]] std::optional<MeshFormat> format_of_path(const std::filesystem::path& path);

/// ".obj, .ply, .stl, ...": the extensions that format_of_path knows.
[[nodiscard]] std::string known_mesh_extensions();

/// Whether vertices at exactly the same position become one. by_format: for STL, which has no
/// indices, and for 3DS, which repeats vertices along its smoothing groups.
enum class Weld : std::uint8_t { by_format, never, exact_positions };

/// What is read of a file. points_and_lines: in the order of the file, points as triangles (v, v, v)
/// and each segment of a line as (v, w, w): `p` and `l` of OBJ, the element "edge" of PLY, faces of
/// one or two corners of OFF. Where a file of these formats has nothing but vertices, each is a point.
/// Changes nothing for STL, 3DS and glTF.
enum class Primitives : std::uint8_t { triangles, points_and_lines };

struct ReadOptions {
    Weld weld = Weld::by_format;
    Primitives primitives = Primitives::triangles;
    /// Stages "loading file", "reading mesh": steps are bytes; budget: file, mesh and scratch.
    Execution execution = {};
};

/// Reads the mesh of a file, its format told by the extension. All objects and groups become one
/// mesh; normals, texture coordinates, colours and unknown PLY elements are passed over, and so are
/// points and lines where options.primitives does not ask for them. An XYZ file has a point on each
/// line, three numbers and any that follow, which are passed over. Polygons of n corners become n - 2
/// triangles: a fan where that is right, ears where it is not; degenerate triangles are kept. NaN and
/// infinite coordinates are values here; checked_bounding_box() refuses them later. A file whose records end early, promise more than
/// there is, or are followed by something that does not belong to them is refused. An OBJ that ends between two lines
/// looks whole, and assimp may drop triangles of a glTF. Errors: file_not_found, unsupported_format, malformed_file (with file and line, or
/// byte), limit_exceeded (a face of more than 2^20 corners, or a concave one of more than 2^14),
/// budget_exceeded (before the memory is taken), cancelled.
[[nodiscard]] Result<TriangleMesh> read_mesh(const std::filesystem::path& path,
                                             const ReadOptions& options = {});

/// The same from memory, with "OBJ data" and the like as the name in messages. A glTF that refers
/// to other files is refused.
[[nodiscard]] Result<TriangleMesh> read_mesh_from_memory(std::span<const std::byte> bytes,
                                                         MeshFormat format,
                                                         const ReadOptions& options = {});

enum class PlyEncoding : std::uint8_t { ascii, binary };
enum class StlEncoding : std::uint8_t { ascii, binary };

struct WriteOptions {
    PlyEncoding ply = PlyEncoding::binary; ///< binary: little-endian, float64
    StlEncoding stl = StlEncoding::binary; ///< binary: float32, the format has no other
    Execution execution = {};              ///< stage "writing mesh", steps are triangles
};

/// Writes OBJ, PLY, STL or OFF, told by the extension: whole or not at all.
/// Positions read back to the same bits, except through binary STL, which rounds to float32. STL
/// keeps neither vertex order nor unused vertices. Errors: unsupported_format, file_not_writable,
/// limit_exceeded (a finite coordinate that binary STL would turn into infinity), cancelled.
[[nodiscard]] Status write_mesh(const TriangleMesh& mesh, const std::filesystem::path& path,
                                const WriteOptions& options = {});

} // namespace proxima
