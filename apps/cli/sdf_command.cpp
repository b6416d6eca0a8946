// proxima sdf: the signed distances of a mesh at all points of a regular grid, as a file for NumPy, VTK or
// OpenVDB.
#include "base/file_extension.h"
#include "base/memory_budget.h"
#include "base/output_file.h"
#include "base/text.h"
#include "cli/closest_searcher.h"
#include "cli/commands.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/npy_header.h"
#include "cli/stopwatch.h"
#include "cli/vdb_file.h"
#include "octree/vtk_xml.h"
#include "proxima/distance_field.h"
#include "proxima/mesh_io.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

enum class FieldFormat : std::uint8_t { none, npy, vti, vdb };

struct SdfOptions {
    std::string model;
    GridOptions grid;
    double band = HUGE_VAL;
    bool gradients = false;
    bool methods = false;
    std::string out;
    std::uint64_t budget_mb = 0;
};

/// A field in memory.
struct Field {
    PointGrid grid;
    std::vector<double> distances;
    std::vector<Vec3> gradients;
    std::vector<SignMethod> methods;
};

/// As many zeros, with a look at requests to stop: gigabytes take seconds.
template <class T>
Status make_room(std::vector<T>& values, std::size_t count, const Session& session)
{
    constexpr std::size_t block = std::size_t{1} << 20U;
    values.reserve(count);
    while (values.size() < count) {
        if (Status status = session.check_running(); !status) return status;
        values.resize(std::min(count, values.size() + block));
    }
    return {};
}

/// By extension.
Result<FieldFormat> format_of(const std::string& path)
{
    if (path.empty()) return FieldFormat::none;
    const std::string extension = lower_case_extension(path);
    if (extension == ".npy") return FieldFormat::npy;
    if (extension == ".vti") return FieldFormat::vti;
    if (extension == ".vdb") {
        const auto writer = vdb_writer(path); // before the long work
        return writer ? Result<FieldFormat>(FieldFormat::vdb) : tl::unexpected(writer.error());
    }
    return fail(ErrorCode::unsupported_format,
                concat("the extension ", extension, " is none of .npy, .vti and .vdb"), path);
}

/// The box of the mesh that the index is of.
Result<Box> box_of(const MeshIndex& index)
{
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    return bounding_box(*mesh);
}

Result<Field> make_field(const MeshIndex& index, const SdfOptions& options, FieldFormat format,
                         Session& session)
{
    const auto box = box_of(index);
    if (!box) return tl::unexpected(box.error());
    const auto grid = grid_around(*box, options.grid);
    if (!grid) return tl::unexpected(grid.error());
    const std::uint64_t each = sizeof(double) + (options.gradients ? sizeof(Vec3) : 0) +
                               (options.methods ? sizeof(SignMethod) : 0);
    MemoryBudget budget;
    if (options.budget_mb != 0) budget.bytes = options.budget_mb * 1'000'000;
    const std::uint64_t file_bytes = format == FieldFormat::vdb ? vdb_bytes(*grid) : 0;
    if (Status status = check_budget(budget, each * grid->point_count() + file_bytes,
                                     concat("a grid of ", grid->size[0], " x ", grid->size[1],
                                            " x ", grid->size[2], " points"),
                                     "take a coarser one, leave out arrays or raise --budget-mb");
        !status)
        return tl::unexpected(status.error());
    Field field;
    field.grid = *grid;
    const std::size_t count = grid->point_count();
    Status room = make_room(field.distances, count, session);
    if (room && options.gradients) room = make_room(field.gradients, count, session);
    if (room && options.methods) room = make_room(field.methods, count, session);
    if (!room) return tl::unexpected(room.error());
    const ProgressBar shown(session.progress(), session.bar());
    if (Status status = distance_field(
            index, field.grid,
            {.distances = field.distances, .gradients = field.gradients, .methods = field.methods},
            {.band = options.band, .execution = session.execution()});
        !status)
        return tl::unexpected(status.error());
    return field;
}

Status write_npy(const Field& field, const std::string& path, Progress* progress)
{
    const auto bytes = std::as_bytes(std::span(field.distances));
    auto file = OutputFile::create(path, {progress, bytes.size()});
    if (!file) return tl::unexpected(file.error());
    const auto [x, y, z] = field.grid.size;
    const std::array<std::uint64_t, 3> shape = {x, y, z};
    if (Status status = file->write(npy_header(shape, NpyOrder::columns_first)); !status)
        return status;
    if (Status status = file->write(bytes); !status) return status;
    return file->commit();
}

Status write_vti(const Field& field, const std::string& path, Progress* progress)
{
    const PointGrid& grid = field.grid;
    const std::string extent =
        concat("0 ", grid.size[0] - 1, " 0 ", grid.size[1] - 1, " 0 ", grid.size[2] - 1);
    VtkXml xml("ImageData", "1.0");
    xml.text(fmt::format("<ImageData WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\">\n"
                         "<Piece Extent=\"{}\">\n<PointData Scalars=\"distance\">\n",
                         extent, grid.origin.x(), grid.origin.y(), grid.origin.z(), grid.spacing,
                         grid.spacing, grid.spacing, extent));
    xml.array("Float64", R"(Name="distance")", std::as_bytes(std::span(field.distances)));
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    if (!field.gradients.empty()) {
        xml.array("Float64", R"(Name="gradient" NumberOfComponents="3")",
                  std::as_bytes(std::span(field.gradients)));
    }
    if (!field.methods.empty())
        xml.array("UInt8", R"(Name="sign_method")", std::as_bytes(std::span(field.methods)));
    xml.text("</PointData>\n</Piece>\n</ImageData>\n");
    return xml.write(path, progress);
}

Status write_field(const Field& field, FieldFormat format, const SdfOptions& options,
                   Session& session)
{
    Progress* const progress = &session.progress();
    if (format == FieldFormat::npy) return write_npy(field, options.out, progress);
    if (format == FieldFormat::vti) return write_vti(field, options.out, progress);
    return write_vdb(field.grid, field.distances, options.band, options.out, progress);
}

/// What a field is like.
struct FieldCounts {
    double least = HUGE_VAL;
    double most = -HUGE_VAL;
    std::uint64_t inside = 0;
    std::uint64_t beyond = 0; ///< of the band

    FieldCounts(const Field& field, double band)
    {
        for (const double distance : field.distances) {
            least = std::min(least, distance);
            most = std::max(most, distance);
            inside += distance < 0 ? 1 : 0;
            beyond += std::isfinite(band) && std::abs(distance) == band ? 1 : 0;
        }
    }
};

Status run_sdf(const SdfOptions& options, Session& session)
{
    const auto format = format_of(options.out);
    if (!format) return tl::unexpected(format.error());
    if (Status status = session.check_outputs({options.out}); !status) return status;
    const auto searcher = make_closest_searcher(options.model, {.is_signed = true}, session);
    if (!searcher) return tl::unexpected(searcher.error());
    const Stopwatch watch;
    const auto field = make_field(searcher->index, options, *format, session);
    if (!field) return at_model(field.error(), options.model);
    const double seconds = watch.seconds();
    const FieldCounts counts(*field, options.band);
    const auto [x, y, z] = field->grid.size;
    const Vec3& origin = field->grid.origin;
    const auto points = static_cast<double>(field->grid.point_count());
    session.print(fmt::format("{}: {} triangles\n"
                              "{} x {} x {} points from ({:.9g}, {:.9g}, {:.9g}), {:.6g} apart, in "
                              "{:.3f} s, {:.0f} ns each\n"
                              "distances {:.6g} to {:.6g}; inside {} points{}\n",
                              options.model, searcher->index.triangle_count(), x, y, z, origin.x(),
                              origin.y(), origin.z(), field->grid.spacing, seconds,
                              1e9 * seconds / points, counts.least, counts.most, counts.inside,
                              std::isfinite(options.band)
                                  ? fmt::format(", beyond the band {}", counts.beyond)
                                  : std::string()));
    if (*format != FieldFormat::none) {
        if (Status status = write_field(*field, *format, options, session); !status) return status;
        session.print(fmt::format("wrote {}\n", options.out));
    }
    nlohmann::ordered_json band;
    if (std::isfinite(options.band)) band = options.band;
    return session.write_json({{"model", options.model},
                               {"triangles", searcher->index.triangle_count()},
                               {"size", {x, y, z}},
                               {"origin", {origin.x(), origin.y(), origin.z()}},
                               {"spacing", field->grid.spacing},
                               {"band", band},
                               {"least", counts.least},
                               {"most", counts.most},
                               {"inside", counts.inside},
                               {"beyond", counts.beyond},
                               {"build_seconds", searcher->build_seconds},
                               {"seconds", seconds},
                               {"ns_per_point", 1e9 * seconds / points}});
}

/// A finite number above `least`, or from it up.
CLI::Option* add_number_option(CLI::App& parser, const char* name, double& number, bool may_be_zero,
                               const std::string& description)
{
    return parser.add_option_function<std::string>(
        name,
        [name, &number, may_be_zero](const std::string& text) {
            const auto numbers = parse_finite_numbers(text);
            if (!numbers || numbers->size() != 1 || numbers->front() < 0 ||
                (numbers->front() == 0 && !may_be_zero)) {
                throw CLI::ValidationError(name, concat(text, " is no finite number ",
                                                        may_be_zero ? "from 0 up" : "above 0"));
            }
            number = numbers->front();
        },
        description);
}

} // namespace

Command add_sdf_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "sdf", "Fill a regular grid with signed distances from a mesh, negative inside");
    const auto options = std::make_shared<SdfOptions>();
    add_model_option(*parser, options->model, ModelKinds::meshes_and_indexes);
    CLI::Option* const resolution = parser
                                        ->add_option("--resolution", options->grid.resolution,
                                                     "Points along the longest side of the grid")
                                        ->check(CLI::Range(2U, 1U << 20U))
                                        ->capture_default_str()
                                        ->type_name("N");
    add_number_option(*parser, "--spacing", options->grid.spacing, false,
                      "Instead: the distance between points, in the mesh's unit")
        ->excludes(resolution)
        ->type_name("H");
    add_number_option(*parser, "--margin", options->grid.margin, true,
                      "How far the grid reaches beyond the mesh's box, in the box's longest sides "
                      "(default: 0.05)")
        ->type_name("M");
    add_number_option(*parser, "--band", options->band, false,
                      "Farther points are not searched for and get this distance with its sign")
        ->type_name("W");
    parser->add_flag("--gradients", options->gradients,
                     "With the direction in which the distance grows, in a .vti file");
    parser->add_flag("--methods", options->methods, "With how each sign was found, in a .vti file");
    add_budget_option(*parser, options->budget_mb,
                      "Memory for the grid, in 10^6 bytes (default: 3/4 of the machine's)");
    parser
        ->add_option("--out", options->out,
                     "Write the grid: .npy, an array of float64 by x, y, z; .vti, an image of VTK "
                     "and ParaView; .vdb, a level set of OpenVDB, where the program was built "
                     "with it")
        ->type_name("FILE");
    parser->callback([options] {
        if ((options->gradients || options->methods) &&
            lower_case_extension(options->out) != ".vti") {
            throw CLI::ValidationError(options->gradients ? "--gradients" : "--methods",
                                       "it goes with --out FILE.vti");
        }
    });
    return {parser, [options](Session& session) { return run_sdf(*options, session); }};
}

} // namespace proxima
