#include "viewer/window/view_files.h"

#include "base/text.h"
#include "cli/image.h"
#include "cli/legend.h"
#include "viewer/layers_glb.h"
#include "viewer/renderer.h"

#include <utility>

namespace proxima {

void ViewFiles::begin(std::string path)
{
    path_ = std::move(path);
    news_ = concat("writing ", path_);
    problem_.clear();
}

void ViewFiles::write_picture(const Viewer& viewer, ViewSize size, std::string path)
{
    if (is_busy()) return;
    begin(std::move(path));
    writing_.start(
        [layers = viewer.layers(), backdrop = viewer.backdrop(), camera = viewer.camera(), size,
         legend = viewer.legend(), path = path_](Progress& progress) -> Status {
            auto image = make_software_renderer(&progress)->render(flattened(layers, backdrop),
                                                                   camera, size);
            if (!image) return tl::unexpected(image.error());
            draw_legend(*image, legend);
            return write_png(*image, path, &progress);
        },
        wake_);
}

void ViewFiles::write_model(const Viewer& viewer, std::string path)
{
    if (is_busy()) return;
    begin(std::move(path));
    writing_.start(
        [layers = viewer.layers(), backdrop = viewer.backdrop(), path = path_](Progress& progress) {
            return export_scene(flattened(layers, backdrop), path, &progress);
        },
        wake_);
}

bool ViewFiles::follow()
{
    if (!writing_.is_finished()) return false;
    const Status written = writing_.take();
    news_ = written ? concat("wrote ", path_) : std::string();
    problem_ = written ? std::string() : describe(written.error());
    return true;
}

Status ViewFiles::finish()
{
    return is_busy() ? writing_.take() : Status{};
}

void ViewFiles::forget_news()
{
    news_.clear();
    problem_.clear();
}

} // namespace proxima
