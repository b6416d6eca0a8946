#include "viewer/egl_context.h"
#include "viewer/gl_scene.h"
#include "viewer/renderer.h"

#include <algorithm>
#include <fmt/core.h>

namespace proxima {
namespace {

/// A framebuffer with its storage, of one sample a pixel or more.
struct Target {
    GlFramebuffer frame;
    GlRenderbuffer color;
    GlRenderbuffer depth;
};

Target make_target(ViewSize size, GLsizei samples)
{
    Target target = {make_framebuffer(), make_renderbuffer(), make_renderbuffer()};
    glBindFramebuffer(GL_FRAMEBUFFER, target.frame.name());
    glBindRenderbuffer(GL_RENDERBUFFER, target.color.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_SRGB8_ALPHA8, size.width,
                                     size.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              target.color.name());
    glBindRenderbuffer(GL_RENDERBUFFER, target.depth.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, size.width,
                                     size.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                              target.depth.name());
    return target;
}

Image read_pixels(ViewSize size)
{
    Image image{size.width, size.height, {}};
    const std::size_t row = 3 * static_cast<std::size_t>(size.width);
    std::vector<std::uint8_t> upside_down(row * static_cast<std::size_t>(size.height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.data());
    image.bytes.resize(upside_down.size());
    for (std::size_t y = 0; y < static_cast<std::size_t>(size.height); ++y) {
        const auto from =
            upside_down.begin() +
            static_cast<std::ptrdiff_t>(row * (static_cast<std::size_t>(size.height) - 1 - y));
        std::copy_n(from, row, image.bytes.begin() + static_cast<std::ptrdiff_t>(row * y));
    }
    return image;
}

class OpenglRenderer final : public Renderer {
public:
    OpenglRenderer(EglContext context, GlPainter painter, GLint most_samples, GLint most_pixels)
        : context_(std::move(context)), painter_(std::move(painter)),
          samples_(std::min(most_samples, wanted_samples)), most_pixels_(most_pixels)
    {}

    Result<Image> render(const DrawnScene& scene, const OrbitCamera& camera, ViewSize size) override
    {
        if (Status status = context_.make_current(); !status) return tl::unexpected(status.error());
        if (std::max(size.width, size.height) > most_pixels_) {
            return fail(ErrorCode::limit_exceeded,
                        fmt::format("OpenGL draws pictures of at most {} pixels a side here",
                                    most_pixels_));
        }
        const Target fine = make_target(size, samples_);
        if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
            return fail(ErrorCode::unsupported_format, "there is no sRGB framebuffer", "OpenGL");
        painter_.draw(GlScene(scene), camera, size);
        const Target plain = make_target(size, 0);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, fine.frame.name());
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, plain.frame.name());
        glBlitFramebuffer(0, 0, size.width, size.height, 0, 0, size.width, size.height,
                          GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, plain.frame.name());
        Image image = read_pixels(size);
        if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
            return fail(ErrorCode::broken_invariant, fmt::format("OpenGL error {:#x}", error),
                        "OpenGL");
        }
        return image;
    }

private:
    static constexpr GLint wanted_samples = 4;

    // Destroyed last: the painter's shaders need it.
    EglContext context_;
    GlPainter painter_;
    GLint samples_;
    GLint most_pixels_;
};

} // namespace

Result<std::unique_ptr<Renderer>> make_opengl_renderer()
{
    auto context = EglContext::create();
    if (!context) return tl::unexpected(context.error());
    auto painter = GlPainter::create();
    if (!painter) return tl::unexpected(painter.error());
    GLint samples = 0;
    GLint pixels = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &samples);
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &pixels);
    return std::make_unique<OpenglRenderer>(std::move(*context), std::move(*painter), samples,
                                            pixels);
}

} // namespace proxima
