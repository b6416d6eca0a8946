#include "arrays.h"

#include "base/text.h"

#include <algorithm>
#include <limits>

namespace proxima::python {

namespace {

/// Doubles in C order at addresses that hold doubles.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast |
                                        py::detail::npy_api::NPY_ARRAY_ALIGNED_>;

std::string shape_text(const py::array& array)
{
    return py::str(array.attr("shape")).cast<std::string>();
}

/// No array that the module takes has more dimensions.
constexpr int most_dimensions = 3;

/// Whether it is of this type, or a list or tuple that has one.
bool has_one(const py::handle& object, const py::handle& type, int depth)
{
    if (py::isinstance<py::array>(object)) return py::isinstance(object, type);
    if (depth == 0 || (PyList_Check(object.ptr()) == 0 && PyTuple_Check(object.ptr()) == 0))
        return false;
    const auto row = py::reinterpret_borrow<py::sequence>(object);
    return std::any_of(row.begin(), row.end(),
                       [&](const py::handle& part) { return has_one(part, type, depth - 1); });
}

/// Whether it is or has a numpy.ma.MaskedArray. There is none unless numpy.ma has been imported.
bool has_mask(const py::handle& object)
{
    const py::str name("numpy.ma");
    const auto masked = py::reinterpret_steal<py::object>(PyImport_GetModule(name.ptr()));
    if (!masked && PyErr_Occurred() != nullptr) throw py::error_already_set();
    return masked && has_one(object, masked.attr("MaskedArray"), most_dimensions);
}

/// What NumPy makes of an object; nothing where it says that this is no array. Refuses masks.
py::array converted(const py::handle& object, const char* name)
{
    if (has_mask(object))
        refuse(name, "must have no mask: hand over the rows that count, or filled() ones");
    const auto& numpy = py::detail::npy_api::get();
    auto array = py::reinterpret_steal<py::array>(numpy.PyArray_FromAny_(
        object.ptr(), nullptr, 0, 0, py::detail::npy_api::NPY_ARRAY_ENSUREARRAY_, nullptr));
    if (array) return array;
    if (PyErr_ExceptionMatches(PyExc_TypeError) == 0 &&
        PyErr_ExceptionMatches(PyExc_ValueError) == 0)
        throw py::error_already_set();
    PyErr_Clear();
    return array;
}

py::array any_array(const py::handle& object, const char* name)
{
    py::array array = converted(object, name);
    if (!array) refuse(name, "must be an array of numbers, is a " + type_name(object));
    return array;
}

[[noreturn]] void refuse_type(const py::array& array, const char* name, const char* wanted)
{
    refuse(name, std::string("must be an array of ") + wanted + ", has dtype " +
                     py::str(array.dtype()).cast<std::string>());
}

void check_shape(const py::array& array, std::size_t columns, const char* name)
{
    if (array.ndim() != 2 || array.shape(1) != static_cast<py::ssize_t>(columns)) {
        refuse(name,
               "must have shape (n, " + std::to_string(columns) + "), has " + shape_text(array));
    }
}

/// Writes rows of `columns` indices each. `row_name` says in the message what a row is.
template <class From>
void copy_indices(const py::array& array, std::size_t columns, const char* name,
                  const char* row_name, std::uint32_t* to)
{
    const auto from = py::array_t<From, py::array::c_style | py::array::forcecast>(array);
    const From* const values = from.data();
    constexpr auto most = std::numeric_limits<std::uint32_t>::max();
    const auto count = static_cast<std::size_t>(from.size());
    for (std::size_t i = 0; i < count; ++i) {
        if (values[i] < 0 || static_cast<std::uint64_t>(values[i]) > most) {
            refuse(name, row_name + std::to_string(i / columns) + " has the vertex index " +
                             std::to_string(values[i]));
        }
        to[i] = static_cast<std::uint32_t>(values[i]);
    }
}

/// Rows of N indices.
template <std::size_t N>
std::vector<std::array<std::uint32_t, N>> indices_of(const py::handle& object, const char* name,
                                                     const char* row_name)
{
    const py::array array = any_array(object, name);
    const char kind = array.dtype().kind();
    const bool empty = array.size() == 0; // an empty list has dtype float64
    if (kind != 'i' && kind != 'u' && !empty) refuse_type(array, name, "integers");
    check_shape(array, N, name);
    std::vector<std::array<std::uint32_t, N>> rows(static_cast<std::size_t>(array.shape(0)));
    std::uint32_t* const to = rows.empty() ? nullptr : rows[0].data();
    if (kind == 'u') {
        copy_indices<std::uint64_t>(array, N, name, row_name, to);
    } else {
        copy_indices<std::int64_t>(array, N, name, row_name, to);
    }
    return rows;
}

bool holds_poses(const py::array& array)
{
    const auto dimensions = array.ndim();
    return dimensions >= 2 && array.shape(dimensions - 1) == 4 &&
           (array.shape(dimensions - 2) == 3 || array.shape(dimensions - 2) == 4);
}

/// Says that nearest rotations were taken, where more than the rounding of floats made them differ.
void warn_of_rotations(double error)
{
    constexpr double rounding_of_floats = 1e-6;
    if (!(error > rounding_of_floats)) return;
    const std::string text =
        concat("poses are up to ", error,
               " (norm of R^T R - I) from rotations: the nearest rotations were used");
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

/// Of 12 numbers, or 16. `error` becomes the largest one of a rotation.
RigidTransform pose_at(std::span<const double> matrix, const std::string& name, double& error)
{
    const bool whole = matrix.size() == 16;
    if (whole && (matrix[12] != 0 || matrix[13] != 0 || matrix[14] != 0 || matrix[15] != 1))
        refuse(name, "the last row must be 0 0 0 1");
    auto pose = make_rigid_transform(matrix.first<12>());
    if (!pose) {
        pose.error().where = name;
        throw Failure(pose.error());
    }
    error = std::max(error, rotation_error(matrix.first<12>()));
    return *pose;
}

} // namespace

py::array_t<double> doubles_of(const py::handle& object, const char* name)
{
    const py::array array = any_array(object, name);
    if (std::string_view("fiu").find(array.dtype().kind()) == std::string_view::npos)
        refuse_type(array, name, "numbers");
    return Doubles(array);
}

PointsArgument::PointsArgument(const py::handle& object, const char* name)
    : array_(doubles_of(object, name))
{
    check_shape(array_, 3, name);
    points_ = {static_cast<const Vec3*>(static_cast<const void*>(array_.data())),
               static_cast<std::size_t>(array_.shape(0))};
}

Vec3 point_of(const py::handle& object, const char* name)
{
    const py::array_t<double> array = doubles_of(object, name);
    if (array.ndim() != 1 || array.shape(0) != 3)
        refuse(name, "must have shape (3,), has " + shape_text(array));
    return Vec3(array.data());
}

Box box_between(const py::handle& lower, const py::handle& upper)
{
    Box box{point_of(lower, "lower"), point_of(upper, "upper")};
    if (box.empty()) refuse("lower", "must be at most upper along each axis, and no NaN");
    return box;
}

std::vector<TriangleCorners> corners_of(const py::handle& object, const char* name)
{
    return indices_of<3>(object, name, "triangle ");
}

std::vector<std::array<std::uint32_t, 2>> segments_of(const py::handle& object, const char* name)
{
    return indices_of<2>(object, name, "segment ");
}

std::vector<std::int64_t> integers_of(const py::handle& object, const char* name,
                                      const char* wanted)
{
    const py::array given = converted(object, name);
    const bool whole = given && (given.dtype().kind() == 'i' || given.dtype().kind() == 'u' ||
                                 given.size() == 0); // an empty list has dtype float64
    if (!whole || given.ndim() > 1) refuse(name, std::string("must be ") + wanted);
    const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> array(given);
    std::vector<std::int64_t> integers(array.data(), array.data() + array.size());
    const bool is_unsigned = given.dtype().kind() == 'u';
    if (is_unsigned && std::ranges::any_of(integers, [](std::int64_t i) { return i < 0; }))
        refuse(name, "has a number of 2^63 or more");
    return integers;
}

Poses poses_of(const py::object& object)
{
    if (object.is_none()) return {{RigidTransform{}}, true};
    const py::array_t<double> array = doubles_of(object, "poses");
    if (!holds_poses(array) || array.ndim() > 3) {
        refuse("poses",
               "must have shape (3, 4), (4, 4), (n, 3, 4) or (n, 4, 4), has " + shape_text(array));
    }
    const auto numbers = static_cast<std::size_t>(4 * array.shape(array.ndim() - 2));
    const auto count = static_cast<std::size_t>(array.size()) / numbers;
    Poses poses{{}, array.ndim() == 2};
    double error = 0;
    for (std::size_t i = 0; i < count; ++i) {
        poses.poses.push_back(pose_at({array.data() + i * numbers, numbers},
                                      poses.single ? "poses" : "pose " + std::to_string(i), error));
    }
    warn_of_rotations(error);
    return poses;
}

RigidTransform pose_of(const py::object& object)
{
    if (object.is_none()) return {};
    const py::array_t<double> array = doubles_of(object, "pose");
    if (!holds_poses(array) || array.ndim() != 2)
        refuse("pose", "must be one pose, of shape (3, 4) or (4, 4), has " + shape_text(array));
    double error = 0;
    RigidTransform pose =
        pose_at({array.data(), static_cast<std::size_t>(array.size())}, "pose", error);
    warn_of_rotations(error);
    return pose;
}

py::array vector_of(const Vec3& vector)
{
    return array_of<double>(std::span(vector.data(), 3));
}

double* write_matrix(const RigidTransform& pose, double* to)
{
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) *to++ = pose.rotation(row, column);
        *to++ = pose.translation[row];
    }
    return to;
}

py::array matrix_of(const RigidTransform& pose)
{
    auto matrix = new_rows<double>(3, 4);
    write_matrix(pose, matrix.mutable_data());
    return matrix;
}

py::array rows_of(std::span<const Vec3> points)
{
    auto array = new_rows<double>(points.size(), 3);
    std::ranges::copy(points, elements_of<Vec3>(array).begin());
    return array;
}

py::array view_of(py::array array)
{
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

} // namespace proxima::python
