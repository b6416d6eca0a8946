#include "viewer/window/view_window.h"

namespace proxima {

Status run_window(Viewer& /*viewer*/, const WindowOptions& /*options*/)
{
    return fail(ErrorCode::unsupported_format,
                "this program was built without a window: scripts/view in Proxima's sources "
                "installs what is missing (libglfw3-dev, libimgui-dev, libepoxy-dev, libegl-dev), "
                "builds it again and opens it; or write a picture with --picture");
}

void wake_window() {}

} // namespace proxima
