#include "bindings.h"
#include "index_methods.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "run.h"
#include "touch.h"
#include "touch_replay.h"
#include "unlocked.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <string>
#include <utility>

namespace proxima::python {

namespace {

/// A renderer, for any thread of Python: one call at a time.
class SharedRenderer {
public:
    /// `scene` is null where the renderer has an index.
    SharedRenderer(std::shared_ptr<SharedScene> scene, HapticRenderer renderer)
        : scene_(std::move(scene)), renderer_(std::move(renderer))
    {}

    [[nodiscard]] const HapticRenderer& renderer() const noexcept { return renderer_; }
    [[nodiscard]] bool has_scene() const noexcept { return scene_ != nullptr; }

    /// Ticks after ticks, without Python's lock. Between them `work` calls what it is given, so that
    /// others can read poses of the scene.
    template <class Work>
    auto exclusively(Work&& work)
    {
        const std::lock_guard one(mutex_);
        if (scene_ == nullptr) return work(renderer_, [] {});
        const std::shared_lock ticks(scene_->ticks);
        return work(renderer_, [this] {
            if (scene_->readers == 0) return;
            scene_->ticks.unlock_shared();
            {
                const std::lock_guard after_them(scene_->gate);
            }
            scene_->ticks.lock_shared();
        });
    }

private:
    std::shared_ptr<SharedScene> scene_;
    HapticRenderer renderer_; // goes before its scene
    std::mutex mutex_;
};

DeviceLimits device_named(const std::string& name)
{
    const auto found = find_device(name);
    if (found) return *found;
    std::string names;
    for (const DeviceLimits& known : known_devices()) names += " " + std::string(known.name);
    refuse("device", "\"" + name + "\" is not known: use one of" + names +
                         ", or numbers as DeviceLimits has them");
}

DeviceLimits limits_of(const py::object& device)
{
    if (py::isinstance<py::str>(device)) return device_named(text_of(device));
    const py::array_t<double> numbers = doubles_of(device, "device");
    if (numbers.ndim() != 1 || numbers.shape(0) != 4) {
        refuse("device", "must be a name or DeviceLimits: max_force, max_stiffness, max_damping, "
                         "workspace_radius");
    }
    DeviceLimits limits;
    limits.max_force = numbers.at(0);
    limits.max_stiffness = numbers.at(1);
    limits.max_damping = numbers.at(2);
    limits.workspace_radius = numbers.at(3);
    if (!(limits.workspace_radius > 0) || !std::isfinite(limits.workspace_radius))
        refuse("device.workspace_radius", "must be above 0 and finite");
    return limits;
}

py::object limits_named(const std::string& name)
{
    const DeviceLimits limits = device_named(name);
    return result_type("DeviceLimits")(limits.max_force, limits.max_stiffness, limits.max_damping,
                                       limits.workspace_radius);
}

Guard guard_named(const std::string& name)
{
    constexpr std::array names = {"off", "observe", "on"};
    const auto* const found = std::ranges::find(names, name);
    if (found == names.end())
        refuse("guard", R"(must be "off", "observe" or "on", is ")" + name + "\"");
    return static_cast<Guard>(found - names.begin());
}

/// The map that fits the box, but for what was given.
WorkspaceMap map_of(const Box& box, const DeviceLimits& limits,
                    std::optional<double> units_per_metre, const py::object& center)
{
    WorkspaceMap map = fit_workspace(box, limits.workspace_radius);
    if (units_per_metre) map.units_per_metre = *units_per_metre;
    if (!center.is_none()) map.center = point_of(center, "center");
    return map;
}

std::unique_ptr<SharedRenderer> make(const py::object& model, const py::object& device,
                                     std::optional<double> units_per_metre,
                                     const py::object& center, const RenderOptions& options)
{
    const DeviceLimits limits = limits_of(device);
    if (py::isinstance<SharedScene>(model)) {
        auto scene = model.cast<SharedScene&>().shared_from_this();
        const WorkspaceMap map = map_of(scene->bounds, limits, units_per_metre, center);
        const std::lock_guard lock(scene->contents);
        HapticRenderer made = value_of(make_haptic_renderer(scene->scene, map, limits, options));
        scene->touched = true;
        return std::make_unique<SharedRenderer>(std::move(scene), std::move(made));
    }
    const MeshIndex index = index_of(model, "a proxima.Mesh, Index or TouchScene");
    const WorkspaceMap map = map_of(bounds_of(index), limits, units_per_metre, center);
    return std::make_unique<SharedRenderer>(
        nullptr,
        run(py::none(), Duration::lengthy, [&](Progress* progress) -> Result<HapticRenderer> {
            if (index.has_signs()) return make_haptic_renderer(index, map, limits, options);
            // Built here, where Ctrl-C stops it.
            const auto with = with_signs(index, {.execution = {.progress = progress}});
            if (!with) return tl::unexpected(with.error());
            return make_haptic_renderer(*with, map, limits, options);
        }));
}

/// Rows, or one row that was given without the dimension that counts them.
struct Rows {
    Rows(const py::object& object, const char* name) : array(doubles_of(object, name))
    {
        single = array.ndim() == 1;
        const auto columns = array.ndim() > 0 ? array.shape(array.ndim() - 1) : 0;
        if (array.ndim() < 1 || array.ndim() > 2 || columns != 3) {
            refuse(name, "must have shape (3,) or (n, 3), has " +
                             py::str(array.attr("shape")).cast<std::string>());
        }
        points = {static_cast<const Vec3*>(static_cast<const void*>(array.data())),
                  static_cast<std::size_t>(array.size()) / 3};
    }

    py::array_t<double> array;
    std::span<const Vec3> points;
    bool single = false;
};

py::object step(SharedRenderer& self, const py::object& positions, const py::object& velocities,
                double seconds, const py::object& progress)
{
    const Rows from(positions, "position");
    std::optional<Rows> speeds;
    if (!velocities.is_none()) {
        speeds.emplace(velocities, "velocity");
        if (speeds->points.size() != from.points.size() || speeds->single != from.single)
            refuse("velocity", "must have the shape of position");
    }
    if (!(seconds > 0) || !std::isfinite(seconds)) refuse("seconds", "must be above 0 and finite");
    TouchColumns columns(from.points.size(), self.has_scene());
    run(progress, duration_of(from.points.size()), [&](Progress* watched) -> Status {
        if (watched != nullptr) watched->begin_stage("touching", from.points.size());
        return self.exclusively([&](HapticRenderer& renderer, const auto& give_way) -> Status {
            DeviceState state;
            for (std::size_t i = 0; i < from.points.size(); ++i) {
                give_way();
                state.pose.translation = from.points[i];
                if (speeds) state.velocity = speeds->points[i];
                columns.set(i, renderer.tick(state, seconds));
                if (watched == nullptr) continue;
                if (watched->cancelled()) {
                    return fail(ErrorCode::cancelled,
                                "touching was cancelled after " + std::to_string(i + 1) + " ticks");
                }
                watched->advance(1);
            }
            return {};
        });
    });
    return columns.result(from.single);
}

void reset(SharedRenderer& self)
{
    const Unlocked unlocked;
    self.exclusively([](HapticRenderer& renderer, const auto& /*give_way*/) { renderer.reset(); });
}

py::dict options_of(const SharedRenderer& self)
{
    const RenderOptions& own = self.renderer().options();
    py::dict options;
    options["stiffness"] = own.force.stiffness;
    options["damping"] = own.force.damping;
    options["proxy_radius"] = own.proxy_radius;
    options["static_friction"] = own.static_friction;
    options["dynamic_friction"] = own.dynamic_friction;
    return options;
}

} // namespace

void bind_touch_renderer(py::module_& module)
{
    const RenderOptions usual;
    py::class_<SharedRenderer>(
        module, "TouchRenderer",
        R"(From where a haptic device is to the force that it gets, tick by tick.

TouchRenderer(model, *, device="omni", units_per_metre=None, center=None, stiffness=500, damping=1, proxy_radius=0,
              static_friction=0.4, dynamic_friction=0.3, guard="on", texture=None, shading=False)

    model             a Mesh, an Index or a TouchScene
    device            "touch", "omni", "desktop", "falcon", "omega" or "delta", or DeviceLimits
    units_per_metre   units of the model in a metre of the device; None fits the model into the device's workspace
    center            (3,) floats, the point of the model at the device's origin; None is the middle of the model
    stiffness         N/m, damping in N s/m: at most the device's
    proxy_radius      m; 0 is a point
    static_friction   of what has no Material, as stiffness and damping; dynamic_friction at most that
    guard             "on": walls that swing are damped, then softened; "observe" or "off"
    texture           a Texture, of what has none of its own
    shading           True: forces lean towards the smooth normals of objects that were added with shading

A position p of the device is center + units_per_metre p of the model. The proxy never passes a triangle, and a spring
pulls the device to it. Calls of several threads wait for one another. An application that needs a thousand ticks a
second whatever else happens runs them in C++: see `proxima touch`. Raises InvalidInput for numbers out of range.)")
        .def(py::init([](const py::object& model, const py::object& device,
                         std::optional<double> units_per_metre, const py::object& center,
                         double stiffness, double damping, double proxy_radius,
                         double static_friction, double dynamic_friction, const std::string& guard,
                         const py::object& texture, bool shading) {
                 RenderOptions options;
                 options.force.stiffness = stiffness;
                 options.force.damping = damping;
                 options.proxy_radius = proxy_radius;
                 options.static_friction = static_friction;
                 options.dynamic_friction = dynamic_friction;
                 options.guard = guard_named(guard);
                 if (const auto own = texture_of(texture)) options.texture = *own;
                 options.shading = shading ? ForceShading::on : ForceShading::off;

                 return make(model, device, units_per_metre, center, options);
             }),
             py::arg("model"), py::kw_only(), py::arg("device") = "omni",
             py::arg("units_per_metre") = py::none(), py::arg("center") = py::none(),
             py::arg("stiffness") = usual.force.stiffness, py::arg("damping") = usual.force.damping,
             py::arg("proxy_radius") = usual.proxy_radius,
             py::arg("static_friction") = usual.static_friction,
             py::arg("dynamic_friction") = usual.dynamic_friction, py::arg("guard") = "on",
             py::arg("texture") = py::none(), py::arg("shading") = false)
        .def("step", &step, py::arg("position"), py::arg("velocity") = py::none(),
             py::arg("seconds") = 1e-3, py::kw_only(), py::arg("progress") = py::none(),
             R"(Ticks, one after the other, as a Touch.

    position  (3,) or (n, 3) floats, of the device in metres, one for each tick
    velocity  of the same shape, in m/s, for damping; None is 0
    seconds   of a tick

A few microseconds a tick, without Python's lock. A position that is not finite is replaced by the last one, and the force
fades. Cancelling leaves the renderer after the ticks that were done.)")
        .def("reset", &reset,
             "Starts anew: the next tick places the proxy, and the force ramps up from 0.")
        .def_static("replay", &replay, py::arg("path"), py::arg("model"), py::kw_only(),
                    py::arg("progress") = py::none(),
                    R"(Feels a session again that `proxima touch --record` wrote, as a Replay.

    path   of the .pxt file
    model  the Mesh or Index that was touched; of a scene a list, in the order of its objects

Forces have the bits of the session: Replay.differences counts ticks that do not. Raises FileMissing, or InvalidInput for a
damaged file, another model, and sessions of tools.)")
        .def_property_readonly(
            "units_per_metre",
            [](const SharedRenderer& self) { return self.renderer().map().units_per_metre; },
            "float: units of the model in a metre of the device.")
        .def_property_readonly(
            "center",
            [](const SharedRenderer& self) {
                const Vec3& center = self.renderer().map().center;
                return py::array(array_of<double>(std::span<const double>(center.data(), 3)));
            },
            "(3,) float64: the model's point at the middle of the workspace.")
        .def_property_readonly("options", &options_of,
                               "dict: stiffness, damping, radius and friction as the device limits "
                               "them.")
        .def("__repr__", [](const SharedRenderer& self) {
            return std::string("<proxima.TouchRenderer of ") +
                   (self.has_scene() ? "a scene" : "a mesh") + ", " +
                   std::to_string(self.renderer().options().force.stiffness) + " N/m>";
        });
    module.def("device_limits", &limits_named, py::arg("name"),
               "The DeviceLimits of a known device, as its maker states them.");
}

} // namespace proxima::python
