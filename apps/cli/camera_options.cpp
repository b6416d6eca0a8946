#include "cli/camera_options.h"

#include "base/file_extension.h"
#include "base/text.h"
#include "cli/figure.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/number_checks.h"
#include "geometry/length.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <utility>

namespace proxima {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

struct NamedView {
    std::string_view name;
    double azimuth = 0; ///< degrees
    double elevation = 0;
};
constexpr std::array named_views = {NamedView{"front", 0, 0},      NamedView{"back", 180, 0},
                                    NamedView{"left", -90, 0},     NamedView{"right", 90, 0},
                                    NamedView{"top", 0, 90},       NamedView{"bottom", 0, -90},
                                    NamedView{"iso", 45, 35.26439}};

std::string view_names()
{
    std::string names;
    for (const NamedView& view : named_views) names += concat(view.name, ", ");
    return names;
}

std::optional<Vec3> parse_vector(const std::string& text)
{
    const auto numbers = parse_finite_numbers(text);
    if (!numbers || numbers->size() != 3) return std::nullopt;
    return Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

/// Azimuth and elevation by a name or two numbers, in radians.
std::optional<Vec2> parse_direction(const std::string& text)
{
    const auto named = std::ranges::find(named_views, text, &NamedView::name);
    if (named != named_views.end()) return degree * Vec2(named->azimuth, named->elevation);
    const auto numbers = parse_finite_numbers(text);
    if (!numbers || numbers->size() != 2 || std::abs((*numbers)[0]) > 360.0 ||
        std::abs((*numbers)[1]) > 90.0)
        return std::nullopt;
    return degree * Vec2((*numbers)[0], (*numbers)[1]);
}

/// "z", "-y" or three numbers, of length 1.
std::optional<Vec3> parse_axis(const std::string& text)
{
    const bool is_negative = text.starts_with('-');
    const std::string name = is_negative ? text.substr(1) : text;
    for (int axis = 0; axis < 3; ++axis)
        if (name == std::string(1, "xyz"[axis])) return (is_negative ? -1 : 1) * Vec3::Unit(axis);
    const auto direction = parse_vector(text);
    if (!direction || !(length_of(*direction) > 0)) return std::nullopt;
    return direction->stableNormalized();
}

std::optional<int> parse_pixels(std::string_view text, int most) noexcept
{
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    if (value < 1 || value > most) return std::nullopt;
    return value;
}

/// An option whose text `read` takes, or else is refused as no `what`.
template <class Read>
CLI::Option* add_text_option(CLI::App& parser, const std::string& name, const std::string& type,
                             const std::string& words, const std::string& what, const Read& read)
{
    return parser
        .add_option_function<std::string>(
            name,
            [name, what, read](const std::string& text) {
                if (!read(text)) throw CLI::ValidationError(name, concat(text, " is no ", what));
            },
            words)
        ->type_name(type);
}

} // namespace

OrbitCamera directed_camera(const CameraChoice& choice)
{
    OrbitCamera camera = choice.camera;
    if (choice.angles) {
        camera.azimuth = choice.angles->x();
        camera.elevation = choice.angles->y();
    }
    camera.up = choice.up.value_or(camera.up);
    camera.zoom = choice.zoom.value_or(camera.zoom);
    return camera;
}

namespace {

Status check_sight(const Vec3& eye, const Vec3& target)
{
    if (length_of(eye - target) > 0.0) return {};
    return fail(ErrorCode::invalid_argument,
                "the eye is where it looks: give another --eye or --target", "--eye");
}

/// That squares of the model's lengths are doubles, or it is one point.
Status check_size(const Box& box)
{
    constexpr double smallest = 1e-150;
    constexpr double largest = 1e150;
    if (box.empty()) return {};
    const double reach = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
    const double extent = box.extent().maxCoeff();
    if (reach <= largest && (extent == 0 || extent >= smallest)) return {};
    return fail(ErrorCode::invalid_mesh, concat("a camera needs models of ", smallest, " to ",
                                                largest, " in size and place: scale this one"));
}

} // namespace

Result<OrbitCamera> placed_camera(const CameraChoice& choice, std::span<const Vec3> points)
{
    Box box;
    for (const Vec3& point : points) box.extend(point);
    if (Status status = check_size(box); !status) return tl::unexpected(status.error());
    const Vec3 middle = box.empty() ? Vec3(Vec3::Zero()) : box.center();
    OrbitCamera camera = directed_camera(choice);
    if (!choice.eye) {
        camera = framed(camera, points, choice.size);
        if (choice.target) camera.target = *choice.target;
        return camera;
    }
    const Vec3 target = choice.target.value_or(middle);
    if (Status status = check_sight(*choice.eye, target); !status)
        return tl::unexpected(status.error());
    return looking(camera, *choice.eye, target);
}

std::vector<Vec3> points_to_frame(const TriangleMesh& mesh)
{
    std::vector<bool> used(mesh.vertex_count());
    for (const TriangleCorners& corners : mesh.triangles())
        for (const std::uint32_t corner : corners) used[corner] = true;
    std::vector<Vec3> points;
    points.reserve(used.size());
    for (std::size_t i = 0; i < used.size(); ++i)
        if (used[i]) points.push_back(mesh.positions()[i]);
    return points;
}

std::optional<ViewSize> parse_view_size(std::string_view text, int most) noexcept
{
    const std::size_t cross = text.find('x');
    if (cross == std::string_view::npos) return std::nullopt;
    const auto width = parse_pixels(text.substr(0, cross), most);
    const auto height = parse_pixels(text.substr(cross + 1), most);
    if (!width || !height) return std::nullopt;
    return ViewSize{*width, *height};
}

void add_size_option(CLI::App& parser, ViewSize& size, const std::string& what, int most)
{
    add_text_option(
        parser, "--size", "WxH",
        concat("Size of ", what, " in pixels (default ", size.width, "x", size.height, ")"),
        concat("size from 1x1 to ", most, "x", most), [&size, most](const std::string& text) {
            const auto given = parse_view_size(text, most);
            if (given) size = *given;
            return given.has_value();
        });
}

CLI::Option* add_direction_option(CLI::App& parser, const std::string& name,
                                  std::optional<Vec2>& angles, const std::string& what)
{
    return add_text_option(
        parser, name, "NAME|AZIMUTH,ELEVATION",
        concat("Where ", what, " is seen from: ", view_names(),
               "or degrees to the right and upward (default 0,20: the front, a little above)"),
        concat("view: it is ", view_names(),
               "or AZIMUTH,ELEVATION in degrees, elevation from -90 to 90"),
        [&angles](const std::string& text) {
            angles = parse_direction(text);
            return angles.has_value();
        });
}

void add_camera_options(CLI::App& parser, CameraChoice& choice, const std::string& what)
{
    CLI::Option* const view = add_direction_option(parser, "--view", choice.angles, what);
    const auto add_point = [&](const char* name, std::optional<Vec3>& point, const char* words) {
        add_text_option(parser, name, "X,Y,Z", words, "point X,Y,Z",
                        [&point](const std::string& text) {
                            point = parse_vector(text);
                            return point.has_value();
                        });
    };
    add_point("--eye", choice.eye,
              "Where the camera stands (default: as far away as lets the model fill the picture)");
    add_point("--target", choice.target,
              "The point in the middle of the picture (default: the model's middle)");
    add_text_option(parser, "--up", "AXIS",
                    "The axis that points up: x, y, z, -x, -y, -z or X,Y,Z (default: y of files, z "
                    "of built-ins)",
                    "axis: it is x, y, z, -x, -y, -z or X,Y,Z", [&choice](const std::string& text) {
                        choice.up = parse_axis(text);
                        return choice.up.has_value();
                    });
    parser
        .add_option_function<double>(
            "--fov",
            [&choice](const double& degrees) { choice.zoom = zoom_of_angle(degree * degrees); },
            "Opening angle of the camera from bottom to top, in degrees (default 35)")
        ->check(number_between(0.1, 170.0))
        ->type_name("DEGREES");
    parser.get_option("--eye")->excludes(view);
}

void add_picture_options(CLI::App& parser, std::string& picture, CameraChoice& choice,
                         const std::string& words)
{
    CLI::Option* const file =
        parser.add_option("--picture", picture, concat(words, ": .png"))->type_name("FILE");
    add_size_option(parser, choice.size, "the picture", most_canvas_pixels);
    add_camera_options(parser, choice, "the picture");
    for (const char* name : {"--size", "--view", "--eye", "--target", "--up", "--fov"})
        parser.get_option(name)->needs(file);
}

Status check_picture(const std::string& path, const CameraChoice& choice)
{
    if (!path.empty()) {
        if (lower_case_extension(path) != ".png")
            return fail(ErrorCode::unsupported_format, "a picture is a .png file", path);
        if (Status status = check_drawing(); !status) return status;
    }
    return choice.eye && choice.target ? check_sight(*choice.eye, *choice.target) : Status();
}

CameraChoice for_model(CameraChoice choice, const std::string& model)
{
    choice.camera.up = up_axis_of_model(model);
    return choice;
}

} // namespace proxima
