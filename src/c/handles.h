// What the opaque pointers of the C interface point to, and how its functions report errors.
#pragma once

#include "proxima/c/proxima.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>

struct proxima_mesh {
    proxima::TriangleMesh mesh;
};
struct proxima_index {
    proxima::MeshIndex index;
};
struct proxima_progress {
    proxima::Progress progress;
};
struct proxima_body {
    proxima::TouchBody body;
};
struct proxima_scene {
    std::shared_ptr<proxima::TouchScene> scene;
};
struct proxima_renderer {
    std::shared_ptr<proxima::TouchScene> scene; ///< outlives the renderer
    proxima::HapticRenderer renderer;
};

namespace proxima::c {

/// Keeps the message for proxima_error_message(), and gives the status.
proxima_status failed(const Error& error) noexcept;
/// Keeps a message for the exception that a handler has caught, and gives its status.
proxima_status failed_by_exception() noexcept;
/// Refuses more than `most` elements, before any is read. `limit` begins the message.
proxima_status check_count(std::size_t count, std::size_t most, const char* limit) noexcept;
/// Keeps this message about an argument, and gives PROXIMA_INVALID_ARGUMENT.
proxima_status refused(const char* message) noexcept;

/// What `work` returns, or the status of what it throws.
template <class Work>
proxima_status guarded(Work&& work) noexcept
{
    try {
        return std::forward<Work>(work)();
    } catch (...) {
        return failed_by_exception();
    }
}

/// Whether one of them is NULL: then refused() was called.
template <class... Pointers>
bool any_null(const Pointers*... pointers) noexcept
{
    if ((... && (pointers != nullptr))) return false;
    refused("a pointer is NULL that must not be");
    return true;
}

/// The status of a function that returns nothing else.
inline proxima_status status_of(const Status& status) noexcept
{
    return status ? PROXIMA_OK : failed(status.error());
}

/// Nothing where the number of threads is out of range: then refused() was called.
std::optional<Execution> execution_of(const proxima_execution* execution) noexcept;

inline Vec3 vector_of(const double* numbers) noexcept
{
    return {numbers[0], numbers[1], numbers[2]};
}
inline void copy_to(double* numbers, const Vec3& vector) noexcept
{
    for (int i = 0; i < 3; ++i) numbers[i] = vector[i];
}

/// `count` packed points as the library takes them. Throws std::length_error where they are more than
/// there can be.
std::span<const Vec3> points_of(const double* points, std::size_t count);

/// Error invalid_argument where the matrix is not rigid; NULL is the identity.
Result<RigidTransform> pose_of(const double* matrix);

} // namespace proxima::c
