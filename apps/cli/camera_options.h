// The camera of a command's pictures, by options that all of them have in the same words.
#pragma once

#include "cli/camera.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace proxima {

/// What is known of a camera before there is something to see: what somebody asked for, else the
/// direction, up axis and zoom of `camera`.
struct CameraChoice {
    OrbitCamera camera = {};
    std::optional<Vec2> angles = {}; ///< azimuth and elevation, radians
    std::optional<Vec3> eye = {};    ///< instead of angles
    std::optional<Vec3> target = {};
    std::optional<Vec3> up = {}; ///< of length 1
    std::optional<double> zoom = {};
    ViewSize size = {}; ///< of the picture

    [[nodiscard]] bool has_any() const noexcept { return angles || eye || target || up || zoom; }
};

/// With what was asked for but eye and target.
[[nodiscard]] OrbitCamera directed_camera(const CameraChoice& choice);

/// The camera for these points. Without an eye it stands so far away that they fill the picture,
/// without a target it looks at their middle. Errors: invalid_argument where the eye is the target,
/// invalid_mesh where squares of lengths would leave the range of doubles.
[[nodiscard]] Result<OrbitCamera> placed_camera(const CameraChoice& choice,
                                                std::span<const Vec3> points);

/// The vertices that triangles use, for placed_camera. O(mesh).
[[nodiscard]] std::vector<Vec3> points_to_frame(const TriangleMesh& mesh);

/// The longest side of a picture whose every pixel is sampled several times, and of another.
inline constexpr int most_canvas_pixels = 8192;
inline constexpr int most_pixels = 16384;

/// "1024x768", both from 1 to `most`; else nothing.
[[nodiscard]] std::optional<ViewSize> parse_view_size(std::string_view text, int most) noexcept;

/// --size WxH, `what` has this size.
void add_size_option(CLI::App& parser, ViewSize& size, const std::string& what, int most);

/// An option for azimuth and elevation alone.
CLI::Option* add_direction_option(CLI::App& parser, const std::string& name,
                                  std::optional<Vec2>& angles, const std::string& what);

/// --view, --eye, --target, --up and --fov of the camera that `what` is seen by.
void add_camera_options(CLI::App& parser, CameraChoice& choice, const std::string& what);

/// --picture FILE, and what needs it: --size and the options of the camera. `words` say what is
/// drawn.
void add_picture_options(CLI::App& parser, std::string& picture, CameraChoice& choice,
                         const std::string& words);

/// Errors, of what can be told without the mesh: unsupported_format for a picture that is no .png
/// file, those of check_drawing (the legend), invalid_argument for an eye at its target. No name is right.
[[nodiscard]] Status check_picture(const std::string& path, const CameraChoice& choice);

/// The choice with the model's up axis where none was asked for.
[[nodiscard]] CameraChoice for_model(CameraChoice choice, const std::string& model);

} // namespace proxima
