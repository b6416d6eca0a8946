#include "scene.h"
#include "arrays.h"
#include "proxima/mesh_index.h"
#include "run.h"

#include <limits>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// An Index, or a sequence of them.
std::vector<MeshIndex> shapes_of(const py::object& object)
{
    if (py::isinstance<MeshIndex>(object)) return {object.cast<const MeshIndex&>()};
    if (!py::isinstance<py::sequence>(object))
        refuse_object(object, "shapes", "one proxima.Index or a list of them");
    std::vector<MeshIndex> shapes;
    for (const py::handle& item : py::reinterpret_borrow<py::sequence>(object)) {
        if (!py::isinstance<MeshIndex>(item)) {
            refuse_object(item, ("shapes[" + std::to_string(shapes.size()) + "]").c_str(),
                          "a proxima.Index");
        }
        shapes.push_back(item.cast<const MeshIndex&>());
    }
    return shapes;
}

std::vector<RigidTransform> placements_of(const py::object& poses)
{
    if (poses.is_none()) refuse("poses", "must have shape (n, 3, 4) or (n, 4, 4), is None");
    return poses_of(poses).poses;
}

/// One number for all instances, or one for each; nothing where None is given.
std::vector<std::uint32_t> numbers_of(const py::object& object, const char* name,
                                      std::size_t instances)
{
    if (object.is_none()) return {};
    const auto given = integers_of(object, name, "an integer, or one for each pose");
    if (given.size() != instances && given.size() != 1) {
        refuse(name, "must be one, or one for each of " + std::to_string(instances) +
                         " poses, are " + std::to_string(given.size()));
    }
    std::vector<std::uint32_t> numbers(instances);
    for (std::size_t i = 0; i < instances; ++i) {
        const std::int64_t number = given[given.size() == 1 ? 0 : i];
        if (number < 0 || number > std::numeric_limits<std::uint32_t>::max()) {
            refuse(name, "must be from 0 to 4294967295, that of instance " + std::to_string(i) +
                             " is " + std::to_string(number));
        }
        numbers[i] = static_cast<std::uint32_t>(number);
    }
    return numbers;
}

Scene scene_of_shapes(const py::object& shapes, const py::object& poses, const py::object& shape,
                      const py::object& layers, Integer threads, const py::object& progress)
{
    const std::vector<MeshIndex> indexes = shapes_of(shapes);
    const std::vector<RigidTransform> placed = placements_of(poses);
    const std::size_t count = placed.size();
    const auto which = numbers_of(shape, "shape", count);
    const auto seen_on = numbers_of(layers, "layers", count);
    std::vector<Instance> instances(count);
    for (std::size_t i = 0; i < count; ++i) {
        instances[i].pose = placed[i];
        if (!which.empty()) instances[i].shape = which[i];
        if (!seen_on.empty()) instances[i].layers = seen_on[i];
    }
    const Threads thread_count = threads_of(threads);
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return build_scene(indexes, instances, {{.threads = thread_count, .progress = watched}});
    });
}

Scene moved_scene(const Scene& self, const py::object& poses, Integer threads,
                  const py::object& progress)
{
    const std::vector<RigidTransform> placed = placements_of(poses);
    const Threads thread_count = threads_of(threads);
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return move_instances(self, placed, {{.threads = thread_count, .progress = watched}});
    });
}

/// Calls body(i, id) for all instances.
template <class Body>
void for_instances(const Scene& scene, const Body& body)
{
    for (std::size_t i = 0; i < scene.instance_count(); ++i)
        body(i, scene.instance(InstanceId{static_cast<std::uint32_t>(i)}));
}

py::array poses_array(const Scene& self)
{
    py::array_t<double> array(std::vector{static_cast<py::ssize_t>(self.instance_count()),
                                          py::ssize_t{3}, py::ssize_t{4}});
    double* to = array.mutable_data();
    for_instances(self, [&](std::size_t /*i*/, const Instance& instance) {
        to = write_matrix(instance.pose, to);
    });
    return array;
}

py::array shape_array(const Scene& self)
{
    auto array = new_array<std::int32_t>(self.instance_count());
    for_instances(self, [to = array.mutable_data()](std::size_t i, const Instance& instance) {
        to[i] = static_cast<std::int32_t>(instance.shape);
    });
    return array;
}

py::array layers_array(const Scene& self)
{
    auto array = new_array<std::uint32_t>(self.instance_count());
    for_instances(self, [to = array.mutable_data()](std::size_t i, const Instance& instance) {
        to[i] = instance.layers;
    });
    return array;
}

py::array bounds_of_scene(const Scene& self)
{
    py::array_t<double> array(std::vector{static_cast<py::ssize_t>(self.instance_count()),
                                          py::ssize_t{2}, py::ssize_t{3}});
    const auto corners = elements_of<Vec3>(array);
    for (std::size_t i = 0; i < self.instance_count(); ++i) {
        const Box box = self.bounds(InstanceId{static_cast<std::uint32_t>(i)});
        corners[2 * i] = box.lower;
        corners[2 * i + 1] = box.upper;
    }
    return array;
}

py::tuple shapes_tuple(const Scene& self)
{
    py::tuple shapes(self.shape_count());
    for (std::size_t i = 0; i < shapes.size(); ++i)
        shapes[i] = py::cast(self.shape(static_cast<std::uint32_t>(i)));
    return shapes;
}

std::string represent_scene(const Scene& self)
{
    return "<proxima.Scene: " + std::to_string(self.instance_count()) + " instances of " +
           std::to_string(self.shape_count()) + " shapes, " + std::to_string(self.bytes()) +
           " bytes>";
}

} // namespace

std::uint32_t layers_of(const py::object& object, const char* name)
{
    const auto given = integers_of(object, name, "an integer");
    constexpr std::int64_t most = all_layers;
    if (given.size() != 1 || given[0] < 0 || given[0] > most)
        refuse(name, "must be one integer from 0 to 4294967295");
    return static_cast<std::uint32_t>(given[0]);
}

py::array instances_of(std::span<const InstanceId> ids)
{
    return array_of<std::int32_t>(ids);
}

void bind_scene(py::module_& module)
{
    py::class_<Scene> scene(
        module, "Scene",
        R"(Many placed instances of indexes: what a ray hits, what is closest, what meets.

Scene(shapes, poses, shape=None, layers=None, *, threads=0, progress=None)

    shapes  an Index, or a list of them, which instances share
    poses   (n, 3, 4) or (n, 4, 4) floats, rigid, row-major (R | t): where instances are
    shape   (n,) integers: which of the shapes each is; None: the first
    layers  (n,) integers, bits of a mask: a query sees an instance where they have a bit in common; None: all bits

Instances are numbered as their poses are. Answers are those of asking all instances one by one, bit for bit. Immutable; any
number of threads may query it. About 0.6 us of work and 250 bytes per instance, at most 2^24 instances. Ctrl-C stops building and
batches. Raises InvalidInput for a shape that is not there and a pose that is not rigid.)");
    scene
        .def(py::init(&scene_of_shapes), py::arg("shapes"), py::arg("poses"),
             py::arg("shape") = py::none(), py::arg("layers") = py::none(), py::kw_only(),
             py::arg("threads") = 0, py::arg("progress") = py::none())
        .def(
            "move", &moved_scene, py::arg("poses"), py::kw_only(), py::arg("threads") = 0,
            py::arg("progress") = py::none(),
            R"(The Scene with the same instances elsewhere, sooner than a new one; this one stays as it is.

    poses  (n, 3, 4) or (n, 4, 4) floats, one for each instance

Queries are slower the farther neighbours moved apart: then build anew.)")
        .def_property_readonly("shapes", &shapes_tuple, "tuple of Index: what instances share.")
        .def_property_readonly("poses", &poses_array,
                               "(n, 3, 4) float64: where instances are, a new array.")
        .def_property_readonly("shape", &shape_array,
                               "(n,) int32: which of the shapes each instance is, a new array.")
        .def_property_readonly("layers", &layers_array,
                               "(n,) uint32: the layers of each instance, a new array.")
        .def_property_readonly("bounds", &bounds_of_scene,
                               "(n, 2, 3) float64: lowest and highest corner of a box about each "
                               "instance, some percent larger than needed; inf and -inf for an "
                               "empty index. A new array.")
        .def_property_readonly("instance_count", &Scene::instance_count,
                               "int: how many instances there are.")
        .def_property_readonly("nbytes", &Scene::bytes,
                               "int: bytes of its own arrays, without the shapes.")
        .def("__repr__", &represent_scene)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def("__reduce__", [](const py::object& self) {
            return py::make_tuple(self.attr("__class__"),
                                  py::make_tuple(self.attr("shapes"), self.attr("poses"),
                                                 self.attr("shape"), self.attr("layers")));
        });
    bind_scene_queries(scene);
    bind_scene_pairs(scene);
}

} // namespace proxima::python
