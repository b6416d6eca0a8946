#include "viewer/gl_objects.h"

#include <array>

namespace proxima {
namespace {

constexpr GLsizei log_size = 1000;

Status compile(GLuint program, GLenum kind, const char* text)
{
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    std::array<char, log_size> log = {};
    if (compiled == GL_FALSE) glGetShaderInfoLog(shader, log_size, nullptr, log.data());
    glAttachShader(program, shader);
    glDeleteShader(shader); // once the program lets go of it
    if (compiled == GL_FALSE) return fail(ErrorCode::broken_invariant, log.data(), "OpenGL shader");
    return {};
}

} // namespace

Result<GlProgram> link_program(const char* vertex_shader, const char* fragment_shader)
{
    GlProgram program(glCreateProgram());
    if (Status status = compile(program.name(), GL_VERTEX_SHADER, vertex_shader); !status)
        return tl::unexpected(status.error());
    if (Status status = compile(program.name(), GL_FRAGMENT_SHADER, fragment_shader); !status)
        return tl::unexpected(status.error());
    glLinkProgram(program.name());
    GLint linked = GL_FALSE;
    glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
    if (linked == GL_FALSE) {
        std::array<char, log_size> log = {};
        glGetProgramInfoLog(program.name(), log_size, nullptr, log.data());
        return fail(ErrorCode::broken_invariant, log.data(), "OpenGL program");
    }
    return program;
}

GlBuffer make_buffer()
{
    GLuint name = 0;
    glGenBuffers(1, &name);
    return GlBuffer(name);
}

GlVertexArray make_vertex_array()
{
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return GlVertexArray(name);
}

GlRenderbuffer make_renderbuffer()
{
    GLuint name = 0;
    glGenRenderbuffers(1, &name);
    return GlRenderbuffer(name);
}

GlTexture make_texture()
{
    GLuint name = 0;
    glGenTextures(1, &name);
    return GlTexture(name);
}

GlFramebuffer make_framebuffer()
{
    GLuint name = 0;
    glGenFramebuffers(1, &name);
    return GlFramebuffer(name);
}

} // namespace proxima
