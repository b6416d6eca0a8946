#include "proxima/touch_scene.h"
#include "bindings.h"
#include "index_methods.h"
#include "proxima/mesh_index.h"
#include "run.h"
#include "touch.h"
#include "unlocked.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace proxima::python {

namespace {

std::shared_ptr<SharedScene> make_scene(const py::object& bounds)
{
    const PointsArgument corners(bounds, "bounds");
    if (corners.size() != 2) refuse("bounds", "must be lowest and highest corner, (2, 3)");
    const Box box{corners.points()[0], corners.points()[1]};
    const Vec3 extent = box.upper - box.lower;
    if (!extent.allFinite() || !(extent.array() > 0).all())
        refuse("bounds", "must be finite and not flat, the lowest corner first");
    return std::make_shared<SharedScene>(box);
}

ObjectId object_numbered(const SharedScene& self, Integer object)
{
    const std::size_t count = self.scene.object_count();
    if (object.value < 0 || static_cast<std::uint64_t>(object.value) >= count) {
        refuse("object", "must be below " + std::to_string(count) + ", the number of objects, is " +
                             std::to_string(object.value));
    }
    return ObjectId{static_cast<std::uint32_t>(object.value)};
}

TouchBodyOptions body_options(const py::object& material, const py::object& texture, bool shading)
{
    return {.material = material_of(material),
            .texture = texture_of(texture),
            .shading = shading ? ForceShading::on : ForceShading::off};
}

std::uint32_t add(SharedScene& self, const py::object& model, const py::object& pose,
                  const py::object& material, const py::object& texture, bool shading)
{
    const RigidTransform where = pose_of(pose);
    const TouchBody body = body_of(index_of(model, "a proxima.Mesh or Index"),
                                   body_options(material, texture, shading));
    if (self.touched) refuse("scene", "add all objects before the first TouchRenderer is made");
    const std::lock_guard lock(self.contents);
    const ObjectId object = value_of(self.scene.add(body, where));
    self.bodies.push_back(body);
    return to_index(object);
}

void move_object(SharedScene& self, Integer object, const py::object& pose, double seconds,
                 const py::object& velocity, const py::object& spin, double coast_seconds)
{
    const ObjectMotion motion{.pose = pose_of(pose),
                              .seconds = seconds,
                              .velocity = point_of(velocity, "velocity"),
                              .spin = point_of(spin, "spin"),
                              .coast_seconds = coast_seconds};
    value_of(self.scene.move(object_numbered(self, object), motion));
}

void exchange(SharedScene& self, Integer object, const py::object& model,
              const py::object& material, const py::object& texture, bool shading)
{
    const TouchBody body = body_of(index_of(model, "a proxima.Mesh or Index"),
                                   body_options(material, texture, shading));
    const ObjectId id = object_numbered(self, object);
    value_of(self.scene.exchange(id, body));
    self.bodies[to_index(id)] = body;
}

void deform(SharedScene& self, Integer object, const py::object& vertices, double seconds)
{
    const PointsArgument positions(vertices, "vertices");
    const ObjectId id = object_numbered(self, object);
    const TouchBody bent =
        value_of(refit_touch_body(self.bodies[to_index(id)], positions.points()));
    value_of(self.scene.deform(id, bent, seconds));
}

void set_material(SharedScene& self, Integer object, const py::object& material, double seconds)
{
    const auto numbers = material_of(material);
    if (!numbers) refuse("material", "must be a Material");
    value_of(self.scene.set_material(object_numbered(self, object), *numbers, seconds));
}

py::array pose(SharedScene& self, Integer object)
{
    RigidTransform now;
    {
        const ObjectId id = object_numbered(self, object);
        const Unlocked unlocked; // a tick under way is waited for
        const std::lock_guard first(self.gate);
        ++self.readers;
        {
            const std::scoped_lock lock(self.ticks, self.contents);
            now = self.scene.pose(id);
        }
        --self.readers;
    }
    return matrix_of(now);
}

} // namespace

std::optional<SurfaceMaterial> material_of(const py::object& material)
{
    if (material.is_none()) return std::nullopt;
    const py::array_t<double> numbers = doubles_of(material, "material");
    if (numbers.ndim() != 1 || numbers.shape(0) != 4)
        refuse("material", "must be a Material: stiffness, damping, static and dynamic friction");
    return SurfaceMaterial{numbers.at(0), numbers.at(1), numbers.at(2), numbers.at(3)};
}

std::optional<SurfaceTexture> texture_of(const py::object& texture)
{
    if (texture.is_none()) return std::nullopt;
    if (!py::isinstance(texture, result_type("Texture")))
        refuse_object(texture, "texture", "a proxima.Texture");
    const auto number = [&](const char* name) {
        try {
            return texture.attr(name).cast<double>();
        } catch (const py::cast_error&) {
            refuse(std::string("texture.") + name, "must be a number");
        }
    };
    constexpr std::array names = {"none", "grating", "dimples", "noise"};
    const std::string bump = text_of(py::str(texture.attr("bump")));
    const auto* const shape = std::ranges::find(names, bump);
    if (shape == names.end()) {
        refuse("texture.bump",
               R"(must be "none", "grating", "dimples" or "noise", is ")" + bump + "\"");
    }
    SurfaceTexture made;
    made.bump.shape = static_cast<BumpShape>(shape - names.begin());
    made.bump.amplitude = number("amplitude");
    made.bump.wavelength = number("wavelength");
    made.bump.direction = point_of(texture.attr("direction"), "texture.direction");
    made.viscosity = number("viscosity");
    made.stick_slip = {number("stick_slip_stiffness"), number("stick_slip_force")};
    made.tap = {number("tap_gain"), number("tap_frequency"), number("tap_decay")};
    return made;
}

TouchBody body_of(const MeshIndex& index, const TouchBodyOptions& options)
{
    return run(py::none(), Duration::lengthy, [&](Progress* watched) {
        TouchBodyOptions own = options;
        own.execution.progress = watched;
        return build_touch_body(index, own);
    });
}

void bind_touch_scene(py::module_& module)
{
    const auto zero = py::make_tuple(0.0, 0.0, 0.0);
    py::class_<SharedScene, std::shared_ptr<SharedScene>>(
        module, "TouchScene",
        R"(Objects to touch, which move and change while they are touched.

TouchScene(bounds)

    bounds  (2, 3) floats, lowest and highest corner of a box that objects never leave, in the scene's unit

All objects together are one surface. Up to 64 objects and 8 renderers, each of which keeps the scene alive. Any thread may
call any method. What is said takes effect in the next tick of a TouchRenderer.)")
        .def(py::init(&make_scene), py::arg("bounds"))
        .def(
            "add", &add, py::arg("model"), py::arg("pose") = py::none(), py::kw_only(),
            py::arg("material") = py::none(), py::arg("texture") = py::none(),
            py::arg("shading") = false,
            R"(Adds a Mesh or an Index in a rigid pose (3, 4) or (4, 4), and returns its number, from 0.

    material  a Material; None: what the renderer's options say
    texture   a Texture; None: the renderer's
    shading   True: with smooth normals, for renderers with shading

Before the first renderer is made. A mesh takes about 5 us per triangle. Raises InvalidInput for an object that leaves the
bounds, a pose that is not rigid, and numbers out of range.)")
        .def("move", &move_object, py::arg("object"), py::arg("pose"), py::kw_only(),
             py::arg("seconds") = 0.0, py::arg("velocity") = zero, py::arg("spin") = zero,
             py::arg("coast_seconds") = 0.0,
             R"(Moves an object to a pose (3, 4) or (4, 4) within a time; 0 is at once. Its
origin goes straight, and it turns evenly about one axis: centre the vertices of a mesh that is far
from its origin, or it swings aside.

    velocity       (3,) floats per second: of its origin from then on, for coast_seconds
    spin           (3,) floats, radians per second about the scene's axes, at most 1e4 each, likewise

Raises InvalidInput where it would leave the bounds.)")
        .def("exchange", &exchange, py::arg("object"), py::arg("model"), py::kw_only(),
             py::arg("material") = py::none(), py::arg("texture") = py::none(),
             py::arg("shading") = false,
             "Gives an object another Mesh or Index, with what add() takes; costs and errors as "
             "add().")
        .def(
            "deform", &deform, py::arg("object"), py::arg("vertices"), py::kw_only(),
            py::arg("seconds") = 0.0,
            R"(Moves the vertices of an object to (V, 3) floats, in the object's frame, evenly within a time.

The proxy stays where it touches. About 50 ns per triangle. Raises InvalidInput for another number of vertices, NaN, or
vertices outside of the bounds.)")
        .def("set_material", &set_material, py::arg("object"), py::arg("material"), py::kw_only(),
             py::arg("seconds") = 0.0,
             "Changes the Material of an object evenly within a time, so that the force does not "
             "jump.")
        .def("pose", &pose, py::arg("object"),
             "(3, 4) float64: where an object is in the last tick of the first renderer, (R | t).")
        .def_property_readonly(
            "object_count", [](const SharedScene& self) { return self.scene.object_count(); },
            "int: how many objects were added.")
        .def("__repr__", [](const SharedScene& self) {
            return "<proxima.TouchScene: " + std::to_string(self.scene.object_count()) +
                   " objects>";
        });
}

} // namespace proxima::python
