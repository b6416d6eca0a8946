// Touch: what scenes and renderers of Python share.
#pragma once

#include "arrays.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/touch_scene.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <pybind11/pybind11.h>
#include <shared_mutex>
#include <vector>

namespace proxima::python {

/// A scene and the renderers that touch it, each of which keeps it alive. Its methods keep Python's
/// lock, so that one at a time changes it.
struct SharedScene : std::enable_shared_from_this<SharedScene> {
    explicit SharedScene(const Box& box) : bounds(box), scene(box) {}

    Box bounds;
    TouchScene scene;
    std::vector<TouchBody> bodies; ///< by object: those added or exchanged last
    bool touched = false;          ///< a renderer was made: no objects are added any more
    std::shared_mutex ticks;       ///< held by renderers while they tick, and by who reads poses
    std::atomic<int> readers = 0;  ///< of poses, for whom renderers give way after a tick
    std::mutex gate;               ///< held by the reader at hand: renderers wait for it
    /// Held by who reads poses, without Python's lock, and by who adds objects and renderers, with it. Its
    /// holders wait for nothing.
    std::mutex contents;
};

/// A material of four numbers, or nothing for None.
[[nodiscard]] std::optional<SurfaceMaterial> material_of(const py::object& material);

/// The texture that a proxima.Texture describes; none for None.
[[nodiscard]] std::optional<SurfaceTexture> texture_of(const py::object& texture);

/// Cancelled by Ctrl-C.
[[nodiscard]] TouchBody body_of(const MeshIndex& index, const TouchBodyOptions& options);

/// The columns of proxima.Touch.
class TouchColumns {
public:
    /// For as many ticks. `objects` says whether contacts name objects of a scene.
    TouchColumns(std::size_t ticks, bool objects);

    /// Without Python's lock.
    void set(std::size_t row, const RenderTick& tick);

    /// The answer: rows, or the only one.
    [[nodiscard]] py::object result(bool single) const;

private:
    bool objects_;
    py::array_t<double> force_;
    py::array_t<double> proxy_;
    py::array_t<double> anchor_;
    py::array_t<double> normal_;
    py::array_t<double> depth_;
    py::array_t<std::uint8_t> hold_;
    py::array_t<std::uint8_t> fault_;
    py::array_t<bool> placed_;
    py::array_t<bool> squeezed_;
    std::vector<std::int64_t> first_{0};
    std::vector<ContactPoint> contacts_;
};

} // namespace proxima::python
