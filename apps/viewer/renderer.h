// The interface of renderers, which draw scenes into pictures.
#pragma once

#include "cli/camera.h"
#include "cli/image.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/scene.h"

#include <memory>

namespace proxima {

/// Draws scenes into pictures. Not thread safe.
class Renderer {
public:
    Renderer() = default;
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;
    virtual ~Renderer() = default;

    /// Draws opaque surfaces by depth, then translucent ones and lines from far to near.
    /// Errors: cancelled, budget_exceeded, and those of the graphics system.
    [[nodiscard]] virtual Result<Image> render(const DrawnScene& scene, const OrbitCamera& camera,
                                               ViewSize size) = 0;
};

/// Draws without any graphics system, the same bits on every machine; four samples a pixel.
[[nodiscard]] std::unique_ptr<Renderer> make_software_renderer(const Progress* progress = nullptr);

/// Draws by OpenGL 3.3 without a display; its graphics system is the machine's, so bits differ from
/// machine to machine. Error unsupported_format where the program was built without it, or the
/// machine has no such OpenGL.
[[nodiscard]] Result<std::unique_ptr<Renderer>> make_opengl_renderer();

} // namespace proxima
