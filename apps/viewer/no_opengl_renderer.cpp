#include "viewer/renderer.h"

namespace proxima {

Result<std::unique_ptr<Renderer>> make_opengl_renderer()
{
    return fail(ErrorCode::unsupported_format,
                "this program was built without OpenGL: install libepoxy-dev and libegl-dev and "
                "build it again, or draw by software");
}

} // namespace proxima
