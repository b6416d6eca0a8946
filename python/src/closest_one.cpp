// Index.closest_one: one point, without what a bound function and an array of one row would cost.
//
// The method and its answer are plain CPython: the answer holds the library's own struct, and its
// attributes become Python objects when they are asked for.
#include "arrays.h"
#include "bindings.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"

#include <cmath>
#include <exception>
#include <new>
#include <optional>
#include <string>

namespace proxima::python {

namespace {

struct ClosestOne {
    PyObject_HEAD ClosestFeature closest;
};

PyTypeObject* closest_one_type = nullptr;
PyTypeObject* complex_type = nullptr; // numpy.complexfloating, once it was asked for

const ClosestFeature& answer_of(PyObject* self)
{
    return static_cast<ClosestOne*>(static_cast<void*>(self))->closest;
}

PyObject* three_floats(const double* values)
{
    return Py_BuildValue("(ddd)", values[0], values[1], values[2]);
}

PyObject* get_distance(PyObject* self, void*)
{
    return PyFloat_FromDouble(std::sqrt(answer_of(self).squared_distance));
}
PyObject* get_point(PyObject* self, void*)
{
    return three_floats(answer_of(self).point.data());
}
PyObject* get_triangle(PyObject* self, void*)
{
    return PyLong_FromUnsignedLong(to_index(answer_of(self).triangle));
}
PyObject* get_feature_kind(PyObject* self, void*)
{
    return PyLong_FromLong(static_cast<long>(answer_of(self).feature.kind));
}
PyObject* get_feature(PyObject* self, void*)
{
    return PyLong_FromUnsignedLong(answer_of(self).feature.id);
}
PyObject* get_barycentric(PyObject* self, void*)
{
    return three_floats(answer_of(self).barycentric.data());
}

PyObject* represent(PyObject* self)
{
    constexpr const char* kinds[] = {"vertex", "edge", "face"};
    const ClosestFeature& closest = answer_of(self);
    const std::string text =
        "<proxima.ClosestOne: distance " +
        py::str(py::float_(std::sqrt(closest.squared_distance))).cast<std::string>() + ", " +
        kinds[static_cast<std::size_t>(closest.feature.kind)] + " " +
        std::to_string(closest.feature.id) + ", triangle " +
        std::to_string(to_index(closest.triangle)) + ">";
    return PyUnicode_FromStringAndSize(text.data(), static_cast<Py_ssize_t>(text.size()));
}

/// The three doubles of an array of them; nothing for any other object.
const double* row_of(PyObject* object)
{
    const auto& numpy = py::detail::npy_api::get();
    if (Py_TYPE(object) != numpy.PyArray_Type_) return nullptr; // nor for one with a mask
    const auto* const array = py::detail::array_proxy(object);
    const auto* const type = py::detail::array_descriptor_proxy(array->descr);
    const bool fits = array->nd == 1 && array->dimensions[0] == 3 && type->type == 'd' &&
                      type->byteorder == '=' && array->strides[0] == sizeof(double) &&
                      (array->flags & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
    return fits ? static_cast<const double*>(static_cast<const void*>(array->data)) : nullptr;
}

/// Whether it is a complex number of NumPy, of which a conversion would drop the imaginary part.
bool is_complex(PyObject* object)
{
    if (py::isinstance<py::array>(object))
        return py::reinterpret_borrow<py::array>(object).dtype().kind() == 'c';
    if (complex_type == nullptr) {
        py::object type = py::module_::import("numpy").attr("complexfloating");
        complex_type = reinterpret_cast<PyTypeObject*>(type.release().ptr());
    }
    return PyObject_TypeCheck(object, complex_type) != 0;
}

/// A number as a double, NaN where an error is set.
double coordinate_of(PyObject* object, const char* name)
{
    if (PyFloat_Check(object) != 0) return PyFloat_AS_DOUBLE(object);
    if (PyLong_Check(object) == 0 && is_complex(object))
        refuse(name, "must be a real number, is complex");
    const double number = PyFloat_AsDouble(object);
    if (PyErr_Occurred() == nullptr) return number;
    if (PyErr_ExceptionMatches(PyExc_OverflowError) == 0) return nan;
    PyErr_Clear();
    refuse(name, "is beyond the largest double");
}

/// The point of the arguments (x, y, z) or (point,); nothing where an error is set.
std::optional<Vec3> point_of_arguments(PyObject* const* arguments, Py_ssize_t count)
{
    if (count == 3) {
        constexpr const char* names[] = {"x", "y", "z"};
        Vec3 point;
        for (int k = 0; k < 3; ++k) {
            point[k] = coordinate_of(arguments[k], names[k]);
            if (std::isnan(point[k]) && PyErr_Occurred() != nullptr) return std::nullopt;
        }
        return point;
    }
    if (count == 1) {
        if (const double* const row = row_of(arguments[0])) return Vec3(row);
        return point_of(arguments[0], "point");
    }
    PyErr_SetString(PyExc_TypeError, "closest_one() takes x, y and z, or one point of shape (3,)");
    return std::nullopt;
}

/// The index in a bound object of exactly the class Index or one derived from it; null in one that __new__ made.
const MeshIndex* index_of(PyObject* self)
{
    const auto* const instance =
        static_cast<const py::detail::instance*>(static_cast<const void*>(self));
    if (!instance->simple_layout) // of a class with other bound bases, too
        return py::handle(self).cast<const MeshIndex*>();
    return static_cast<const MeshIndex*>(instance->simple_value_holder[0]);
}

PyObject* find_closest(PyObject* self, PyObject* const* arguments, Py_ssize_t count)
{
    const std::optional<Vec3> point = point_of_arguments(arguments, count);
    if (!point) return nullptr;
    const MeshIndex* const index = index_of(self);
    if (index == nullptr) {
        PyErr_SetString(PyExc_TypeError, without_value);
        return nullptr;
    }
    const std::optional<ClosestFeature> closest = closest_feature(*index, *point);
    if (!closest) refuse("point", "is not finite");
    PyObject* const answer = closest_one_type->tp_alloc(closest_one_type, 0);
    if (answer == nullptr) return nullptr;
    new (&static_cast<ClosestOne*>(static_cast<void*>(answer))->closest) ClosestFeature(*closest);
    return answer;
}

/// No C++ exception may leave to the interpreter.
PyObject* find_closest_safely(PyObject* self, PyObject* const* arguments, Py_ssize_t count)
{
    try {
        return find_closest(self, arguments, count);
    } catch (py::error_already_set& error) {
        error.restore();
    } catch (const Failure& failure) {
        set_error(failure);
    } catch (const std::bad_alloc&) {
        PyErr_NoMemory();
    } catch (const py::builtin_exception& error) {
        error.set_error();
    } catch (const std::exception& error) {
        PyErr_SetString(PyExc_RuntimeError, error.what());
    }
    return nullptr;
}

PyMethodDef closest_one_method = {
    "closest_one",
    reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&find_closest_safely)),
    METH_FASTCALL,
    R"(closest_one(x, y, z) or closest_one(point)

The closest point of the mesh to one point, as ClosestOne: for loops that cannot ask for many at once. `point` is an
array or sequence of shape (3,). The same answer as closest(). Raises InvalidInput where the point is not finite.)"};

} // namespace

void bind_closest_one(py::module_& module)
{
    static PyGetSetDef attributes[] = {
        {"distance", &get_distance, nullptr, "float, in the mesh's unit", nullptr},
        {"point", &get_point, nullptr, "the closest point, three floats", nullptr},
        {"triangle", &get_triangle, nullptr, "int, the lowest triangle that has the feature",
         nullptr},
        {"feature_kind", &get_feature_kind, nullptr, "int: 0 vertex, 1 edge, 2 face", nullptr},
        {"feature", &get_feature, nullptr, "int, the id of the vertex, edge or triangle", nullptr},
        {"barycentric", &get_barycentric, nullptr, "of the point in the triangle, three floats",
         nullptr},
        {nullptr, nullptr, nullptr, nullptr, nullptr}};
    static PyType_Slot slots[] = {
        {Py_tp_getset, static_cast<void*>(attributes)},
        {Py_tp_repr, reinterpret_cast<void*>(&represent)},
        {Py_tp_doc, const_cast<char*>("The closest point of a mesh to one point.")},
        {0, nullptr}};
    static PyType_Spec spec = {"proxima.ClosestOne", sizeof(ClosestOne), 0,
                               Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};
    auto type = py::reinterpret_steal<py::object>(PyType_FromSpec(&spec));
    if (!type) throw py::error_already_set();
    module.attr("ClosestOne") = type;
    closest_one_type = reinterpret_cast<PyTypeObject*>(type.release().ptr());
    const py::object index = module.attr("Index");
    index.attr("closest_one") = py::reinterpret_steal<py::object>(
        PyDescr_NewMethod(reinterpret_cast<PyTypeObject*>(index.ptr()), &closest_one_method));
}

} // namespace proxima::python
