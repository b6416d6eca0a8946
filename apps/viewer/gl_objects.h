// OpenGL's objects as owners. All need a current context, also to be destroyed.
#pragma once

#include "proxima/result.h"

#include <epoxy/gl.h>
#include <string>
#include <utility>

namespace proxima {

/// One name of an object, deleted by Delete.
template <class Delete>
class GlObject {
public:
    GlObject() = default;
    explicit GlObject(GLuint name) noexcept : name_(name) {}
    GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlObject& operator=(GlObject&& other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }
    GlObject(const GlObject&) = delete;
    GlObject& operator=(const GlObject&) = delete;
    ~GlObject()
    {
        if (name_ != 0) Delete()(name_);
    }

    [[nodiscard]] GLuint name() const noexcept { return name_; }

private:
    GLuint name_ = 0;
};

struct DeleteBuffer {
    void operator()(GLuint name) const { glDeleteBuffers(1, &name); }
};
struct DeleteVertexArray {
    void operator()(GLuint name) const { glDeleteVertexArrays(1, &name); }
};
struct DeleteRenderbuffer {
    void operator()(GLuint name) const { glDeleteRenderbuffers(1, &name); }
};
struct DeleteFramebuffer {
    void operator()(GLuint name) const { glDeleteFramebuffers(1, &name); }
};
struct DeleteTexture {
    void operator()(GLuint name) const { glDeleteTextures(1, &name); }
};
struct DeleteProgram {
    void operator()(GLuint name) const { glDeleteProgram(name); }
};

using GlBuffer = GlObject<DeleteBuffer>;
using GlVertexArray = GlObject<DeleteVertexArray>;
using GlRenderbuffer = GlObject<DeleteRenderbuffer>;
using GlFramebuffer = GlObject<DeleteFramebuffer>;
using GlTexture = GlObject<DeleteTexture>;
using GlProgram = GlObject<DeleteProgram>;

/// A program of the two shaders. Error broken_invariant with the compiler's words.
[[nodiscard]] Result<GlProgram> link_program(const char* vertex_shader,
                                             const char* fragment_shader);

[[nodiscard]] GlBuffer make_buffer();
[[nodiscard]] GlVertexArray make_vertex_array();
[[nodiscard]] GlRenderbuffer make_renderbuffer();
[[nodiscard]] GlFramebuffer make_framebuffer();
[[nodiscard]] GlTexture make_texture();

} // namespace proxima
