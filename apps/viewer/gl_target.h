// Where a picture is drawn before it is shown: a framebuffer of several samples a pixel and sRGB
// colours, which a window's own may not have.
#pragma once

#include "cli/camera.h"
#include "viewer/gl_objects.h"

namespace proxima {

/// All members need a current context.
class GlTarget {
public:
    /// Error unsupported_format, broken_invariant (the shader).
    [[nodiscard]] static Result<GlTarget> create();

    /// Binds storage of that size and number of samples, 1 or more.
    [[nodiscard]] Status bind(ViewSize size, int samples);

    /// Copies the picture to the framebuffer `to`, its lower left corner at (x, y) there.
    void show(GLuint to, int x, int y) const;

private:
    GlProgram copy_;
    GlVertexArray nothing_;
    GlFramebuffer fine_;
    GlRenderbuffer fine_color_;
    GlRenderbuffer depth_;
    GlFramebuffer plain_;
    GlTexture plain_color_;
    ViewSize size_ = {.width = 0, .height = 0};
    int samples_ = 0;
};

} // namespace proxima
