// NumPy arrays in and out of the library.
#pragma once

#include "errors.h"
#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <pybind11/numpy.h>
#include <span>
#include <string>
#include <vector>

namespace proxima::python {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// An array as doubles in C order: itself where it is that, else a copy. Floats and integers of any
/// size, byte order and layout, and lists of such numbers; nothing else.
[[nodiscard]] py::array_t<double> doubles_of(const py::handle& object, const char* name);

/// Points or directions in C order.
class PointsArgument {
public:
    /// `object` has shape (n, 3).
    PointsArgument(const py::handle& object, const char* name);

    [[nodiscard]] std::span<const Vec3> points() const noexcept { return points_; }
    [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }

private:
    py::array_t<double> array_;
    std::span<const Vec3> points_;
};

/// A point or direction of shape (3,).
[[nodiscard]] Vec3 point_of(const py::handle& object, const char* name);

/// The box between two corners of shape (3,), which may be infinite.
[[nodiscard]] Box box_between(const py::handle& lower, const py::handle& upper);

/// Corner indices of shape (n, 3), of any integers.
[[nodiscard]] std::vector<TriangleCorners> corners_of(const py::handle& object, const char* name);

/// Indices of the two ends of segments, of shape (n, 2), of any integers.
[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> segments_of(const py::handle& object,
                                                                    const char* name);

/// Integers of shape (n,), or a number. `wanted` says in the message what they must be.
[[nodiscard]] std::vector<std::int64_t> integers_of(const py::handle& object, const char* name,
                                                    const char* wanted = "integers of shape (n,)");

/// Rigid poses, row-major (R | t).
struct Poses {
    std::vector<RigidTransform> poses;
    bool single = false; ///< given without the dimension that counts them
};

/// Of None (one that moves nothing), or an array of shape (3, 4), (4, 4), (n, 3, 4) or (n, 4, 4).
[[nodiscard]] Poses poses_of(const py::object& object);

/// One of these: None, or an array of shape (3, 4) or (4, 4).
[[nodiscard]] RigidTransform pose_of(const py::object& object);

/// An array without values.
template <class T>
[[nodiscard]] py::array_t<T> new_array(std::size_t size)
{
    return py::array_t<T>(static_cast<py::ssize_t>(size));
}
template <class T>
[[nodiscard]] py::array_t<T> new_rows(std::size_t size, std::size_t columns)
{
    return py::array_t<T>(
        std::vector{static_cast<py::ssize_t>(size), static_cast<py::ssize_t>(columns)});
}

/// A point or direction as an array of shape (3,).
[[nodiscard]] py::array vector_of(const Vec3& vector);

/// Writes a pose as 12 numbers, row-major (R | t). Returns where they end.
double* write_matrix(const RigidTransform& pose, double* to);

/// A pose as an array of shape (3, 4).
[[nodiscard]] py::array matrix_of(const RigidTransform& pose);

/// Points as an array of shape (n, 3).
[[nodiscard]] py::array rows_of(std::span<const Vec3> points);

/// The elements of a C-ordered array as another type of the same layout.
template <class As, class T>
[[nodiscard]] std::span<As> elements_of(py::array_t<T>& array)
{
    static_assert(sizeof(As) % sizeof(T) == 0 && alignof(As) <= alignof(T));
    return {static_cast<As*>(static_cast<void*>(array.mutable_data())),
            static_cast<std::size_t>(array.nbytes()) / sizeof(As)};
}

/// A read-only array of an object's own memory, which the array keeps alive.
[[nodiscard]] py::array view_of(py::array array);

/// An array with the values.
template <class T, class From>
[[nodiscard]] py::array_t<T> array_of(std::span<const From> values)
{
    auto array = new_array<T>(values.size());
    T* to = array.mutable_data();
    for (const From& value : values) *to++ = static_cast<T>(value);
    return array;
}

} // namespace proxima::python
