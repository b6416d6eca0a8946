// The models' picture in the window: drawn anew only where it differs, with many samples a pixel
// where that is cheap or once nothing moves.
#pragma once

#include "viewer/gl_layers.h"
#include "viewer/gl_target.h"
#include "viewer/viewer.h"

#include <chrono>
#include <string_view>
#include <vector>

namespace proxima {

class ViewPicture {
public:
    /// `renderer` is OpenGL's name of itself. Errors: those of GlPainter and GlTarget. \pre a
    /// context is current, here and in all members
    [[nodiscard]] static Result<ViewPicture> create(std::string_view renderer);

    /// What the viewer shows, in pixels. Error limit_exceeded: the graphics system has no memory.
    [[nodiscard]] Status draw(const Viewer& viewer, ViewSize size);

    /// Onto the window, its lower left corner at (x, 0) there.
    void show(int x) const { target_.show(0, x, 0); }

    /// Whether the picture that rests is still to be drawn as finely as it can be.
    [[nodiscard]] bool needs_refining() const noexcept { return needs_refining_; }
    /// Measured, all being drawn: of the last picture that people see while it moves.
    [[nodiscard]] double frame_seconds() const noexcept { return frame_seconds_; }
    /// From now on frames are measured, which waits for each.
    void measure() noexcept { is_measured_ = true; }

    [[nodiscard]] std::size_t uploads() const noexcept { return layers_.uploads(); }
    [[nodiscard]] std::size_t uploaded_bytes() const noexcept { return layers_.uploaded_bytes(); }

private:
    using Clock = std::chrono::steady_clock;

    /// What decides how the picture looks.
    struct Drawn {
        std::vector<SceneLayer> layers;
        OrbitCamera camera;
        ViewSize size;
        Theme theme = Theme::light;
        int samples = 0;
    };

    ViewPicture(GlPainter painter, GlTarget target, bool draws_slowly)
        : painter_(std::move(painter)), target_(std::move(target)), draws_slowly_(draws_slowly)
    {}

    static bool same_view(const Drawn& a, const Drawn& b);

    GlPainter painter_;
    GlTarget target_;
    GlLayers layers_;
    Drawn drawn_;
    bool draws_slowly_;
    bool needs_refining_ = false;
    bool is_measured_ = false;
    double frame_seconds_ = 0.0;
    Clock::time_point last_move_ = Clock::now();
};

} // namespace proxima
