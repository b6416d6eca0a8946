#include "viewer/window/window_state.h"

#include "viewer/facts_json.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace proxima {
namespace {

using Json = nlohmann::ordered_json;

Json of(const Vec3& v)
{
    return {v.x(), v.y(), v.z()};
}

Json of(const Viewer& viewer, const WindowState& state)
{
    // Handles as they are seen, in the window's coordinates.
    const View view(viewer.camera(), {state.view_width, state.view_height});
    Json handles = Json::array();
    for (const Vec3& handle : viewer.handles()) {
        const ScreenPoint at = view.project(handle);
        handles.push_back({{"x", state.view_x + at.x}, {"y", at.y}, {"at", of(handle)}});
    }
    return handles;
}

} // namespace

Status write_window_state(const std::string& path, const WindowState& state, const Viewer& viewer,
                          const std::vector<WidgetBounds>& widgets)
{
    Json controls = Json::object();
    for (const WidgetBounds& widget : widgets) {
        controls[widget.name] = {{"value", widget.value},   {"x", widget.x},
                                 {"y", widget.y},           {"width", widget.width},
                                 {"height", widget.height}, {"needs", widget.needs}};
    }
    const auto progress = viewer.progress();
    const OrbitCamera& camera = viewer.camera();
    const Json json = {{"frames", state.frames},
                       {"frame_seconds", state.frame_seconds},
                       {"window", {state.width, state.height}},
                       {"view", {state.view_x, 0, state.view_width, state.view_height}},
                       {"scale", state.scale},
                       {"files", state.files_open},
                       {"models", viewer.models().size()},
                       {"panel", viewer.panel().name()},
                       {"settled", viewer.is_settled()},
                       {"stage", progress != nullptr ? progress->stage() : ""},
                       {"fraction", progress != nullptr ? progress->fraction() : 0.0},
                       {"problem", state.problem},
                       {"news", state.news},
                       {"controls", controls},
                       {"facts", facts_json(viewer.facts())},
                       {"handles", of(viewer, state)},
                       {"picked", viewer.picked()
                                      ? Json(static_cast<std::uint32_t>(viewer.picked()->triangle))
                                      : Json(nullptr)},
                       {"camera",
                        {{"target", of(camera.target)},
                         {"distance", camera.distance},
                         {"azimuth", camera.azimuth},
                         {"elevation", camera.elevation}}},
                       {"uploads", state.uploads},
                       {"uploaded_bytes", state.uploaded_bytes},
                       {"gl_messages", state.gl_messages},
                       {"renderer", state.renderer}};
    // Renamed into place, so that nobody reads a part of it; not forced to the disk, which would
    // take longer than a frame.
    const std::string fresh = path + ".new";
    std::ofstream file(fresh, std::ios::trunc);
    file << json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    file.close();
    std::error_code error;
    if (file) std::filesystem::rename(fresh, path, error);
    if (!file || error)
        return fail(ErrorCode::file_not_writable, "the window's state cannot be written", path);
    return {};
}

} // namespace proxima
