#include "viewer/egl_context.h"

#include <array>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <utility>

namespace proxima {
namespace {

tl::unexpected<Error> no_opengl(const char* what)
{
    return fail(ErrorCode::unsupported_format,
                std::string(what) + ": install Mesa (libegl-mesa0, libgl1-mesa-dri), or draw by "
                                    "software",
                "OpenGL");
}

} // namespace

Result<EglContext> EglContext::create()
{
    // Without libEGL the next question would end the process.
    if (!epoxy_has_egl() || !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base") ||
        !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
        return no_opengl("this machine cannot draw without a display");
    }
    EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE)
        return no_opengl("EGL does not start");
    constexpr std::array<EGLint, 9> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                                  3,
                                                  EGL_CONTEXT_MINOR_VERSION,
                                                  3,
                                                  EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                  EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                  EGL_CONTEXT_OPENGL_DEBUG,
                                                  EGL_TRUE,
                                                  EGL_NONE};
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return no_opengl("EGL has no OpenGL");
    EGLContext context =
        eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT) return no_opengl("there is no OpenGL 3.3");
    EglContext result(display, context);
    if (Status status = result.make_current(); !status) return tl::unexpected(status.error());
    return result;
}

EglContext::EglContext(EglContext&& other) noexcept
    : display_(other.display_), context_(std::exchange(other.context_, EGL_NO_CONTEXT))
{}

EglContext::~EglContext()
{
    if (context_ == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
}

Status EglContext::make_current() const
{
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_FALSE) return {};
    return no_opengl("the OpenGL context cannot be made current");
}

} // namespace proxima
