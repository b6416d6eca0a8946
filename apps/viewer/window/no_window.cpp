#include "viewer/window/view_window.h"

namespace proxima {

Status run_window(Viewer& /*viewer*/, const WindowOptions& /*options*/)
{
    return fail(ErrorCode::unsupported_format,
                "this program was built without a window: install libglfw3-dev, libimgui-dev, "
                "libepoxy-dev and libegl-dev (scripts/install_packages viewer) and build it again, "
                "or write a picture with --snapshot");
}

void wake_window() {}

} // namespace proxima
