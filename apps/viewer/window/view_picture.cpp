#include "viewer/window/view_picture.h"

#include <algorithm>
#include <epoxy/gl.h>
#include <utility>

namespace proxima {
namespace {

bool same_camera(const OrbitCamera& a, const OrbitCamera& b)
{
    return a.target == b.target && a.distance == b.distance && a.azimuth == b.azimuth &&
           a.elevation == b.elevation && a.up == b.up && a.zoom == b.zoom;
}

bool same_layer(const SceneLayer& a, const SceneLayer& b)
{
    const auto same_color = [&] {
        return a.color.has_value() == b.color.has_value() &&
               (!a.color || (*a.color == *b.color).all());
    };
    const auto same_cut = [&] {
        return a.cut.has_value() == b.cut.has_value() &&
               (!a.cut || (a.cut->normal == b.cut->normal && a.cut->offset == b.cut->offset));
    };
    return a.scene == b.scene && a.pose.rotation == b.pose.rotation &&
           a.pose.translation == b.pose.translation && a.opacity == b.opacity && same_color() &&
           same_cut();
}

} // namespace

Result<ViewPicture> ViewPicture::create(std::string_view renderer)
{
    auto painter = GlPainter::create();
    if (!painter) return tl::unexpected(painter.error());
    auto target = GlTarget::create();
    if (!target) return tl::unexpected(target.error());
    const bool draws_slowly = renderer.find("llvmpipe") != std::string_view::npos ||
                              renderer.find("softpipe") != std::string_view::npos;
    return ViewPicture(std::move(*painter), std::move(*target), draws_slowly);
}

/// Whether both show the same layers from the same camera. They may differ in samples per pixel.
bool ViewPicture::same_view(const Drawn& a, const Drawn& b)
{
    return a.size.width == b.size.width && a.size.height == b.size.height && a.theme == b.theme &&
           same_camera(a.camera, b.camera) && std::ranges::equal(a.layers, b.layers, same_layer);
}

Status ViewPicture::draw(const Viewer& viewer, ViewSize size)
{
    constexpr int fine = 4;
    Drawn wanted = {viewer.layers(), viewer.camera(), size, viewer.theme(), fine};
    const bool moves = !same_view(wanted, drawn_);
    if (moves) last_move_ = Clock::now();
    if (draws_slowly_) {
        constexpr std::chrono::milliseconds rest(200);
        const bool is_still = !moves && Clock::now() - last_move_ > rest;
        if (!is_still && !(drawn_.samples == fine && !moves)) wanted.samples = 1;
    }
    needs_refining_ = wanted.samples != fine && !viewer.is_moving();
    if (!moves && wanted.samples == drawn_.samples) return {};
    const auto begin = Clock::now();
    if (Status status = layers_.show(wanted.layers); !status) return status;
    if (Status status = target_.bind(size, wanted.samples); !status) return status;
    painter_.draw(layers_.layers(), viewer.backdrop(), wanted.camera, size);
    if (is_measured_) {
        glFinish();
        if (wanted.samples == 1 || !draws_slowly_)
            frame_seconds_ = std::chrono::duration<double>(Clock::now() - begin).count();
    }
    drawn_ = std::move(wanted);
    return {};
}

} // namespace proxima
