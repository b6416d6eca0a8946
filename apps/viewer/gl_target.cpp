#include "viewer/gl_target.h"

#include <algorithm>

namespace proxima {
namespace {

constexpr const char* copy_vertices = R"(#version 330 core
out vec2 position;
void main() {
    position = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
    gl_Position = vec4(2.0 * position - 1.0, 0.0, 1.0);
})";

// Sampling gives light; the window takes what sRGB makes of it.
constexpr const char* copy_colors = R"(#version 330 core
in vec2 position;
uniform sampler2D picture;
out vec4 color;
void main() {
    vec3 light = texture(picture, position).rgb;
    vec3 low = 12.92 * light;
    vec3 high = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
    color = vec4(mix(high, low, lessThan(light, vec3(0.0031308))), 1.0);
})";

} // namespace

Result<GlTarget> GlTarget::create()
{
    GlTarget target;
    auto copy = link_program(copy_vertices, copy_colors);
    if (!copy) return tl::unexpected(copy.error());
    target.copy_ = std::move(*copy);
    target.nothing_ = make_vertex_array();
    target.fine_ = make_framebuffer();
    target.fine_color_ = make_renderbuffer();
    target.depth_ = make_renderbuffer();
    target.plain_ = make_framebuffer();
    target.plain_color_ = make_texture();
    return target;
}

Status GlTarget::bind(ViewSize size, int samples)
{
    GLint most = 1;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    samples = std::clamp(samples, 1, std::max(1, static_cast<int>(most)));
    if (size.width == size_.width && size.height == size_.height && samples == samples_) {
        glBindFramebuffer(GL_FRAMEBUFFER, fine_.name());
        return {};
    }
    size_ = {.width = 0, .height = 0}; // until all of it is there
    const GLsizei storage = samples > 1 ? samples : 0;
    glBindTexture(GL_TEXTURE_2D, plain_color_.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, size.width, size.height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glBindFramebuffer(GL_FRAMEBUFFER, plain_.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, plain_color_.name(),
                           0);
    glBindFramebuffer(GL_FRAMEBUFFER, fine_.name());
    glBindRenderbuffer(GL_RENDERBUFFER, fine_color_.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, storage, GL_SRGB8_ALPHA8, size.width,
                                     size.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              fine_color_.name());
    glBindRenderbuffer(GL_RENDERBUFFER, depth_.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, storage, GL_DEPTH_COMPONENT24, size.width,
                                     size.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return fail(ErrorCode::unsupported_format, "there is no sRGB framebuffer", "OpenGL");
    size_ = size;
    samples_ = samples;
    return {};
}

void GlTarget::show(GLuint to, int x, int y) const
{
    glBindFramebuffer(GL_READ_FRAMEBUFFER, fine_.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, plain_.name());
    glBlitFramebuffer(0, 0, size_.width, size_.height, 0, 0, size_.width, size_.height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, to);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glViewport(x, y, size_.width, size_.height);
    glUseProgram(copy_.name());
    glUniform1i(glGetUniformLocation(copy_.name(), "picture"), 0);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, plain_color_.name());
    glBindVertexArray(nothing_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
}

} // namespace proxima
