// How long a picture takes that the window draws: OpenGL by software, without a display.
//
//     view_bench [--frames N] [--width N] [--height N] [--mesh NAME]... [--hardware]
//
// Each mesh is loaded as the viewer loads it, uploaded once, and drawn from all round, a frame
// after the other, each until all of it is drawn: with one sample a pixel, as a window without a
// graphics card draws what moves, and with four, as it draws what rests.
#include "bench_program.h"
#include "viewer/egl_context.h"
#include "viewer/gl_layers.h"
#include "viewer/gl_target.h"
#include "viewer/scene_shapes.h"
#include "viewer/view_models.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

namespace proxima::bench {
namespace {

struct BenchOptions {
    int frames = 60;
    int width = 1024;
    int height = 768;
    bool hardware = false;
    std::vector<std::string> meshes;
};

struct Painted {
    GlPainter painter;
    GlTarget target;
    GlTarget window; ///< stands for a window's framebuffer, into which pictures are copied
    GlLayers layers;
};

double milliseconds_since(std::chrono::steady_clock::time_point begin)
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

/// Of every frame of a way round the model, ascending.
Result<std::vector<double>> draw_round(Painted& painted, const ViewModel& model,
                                       const BenchOptions& options, int samples)
{
    const ViewSize size = {.width = options.width, .height = options.height};
    const OrbitCamera front =
        framed({.elevation = 0.35, .up = model.up, .zoom = 2.2}, corners(model.box), size);
    if (Status status = painted.window.bind(size, 1); !status)
        return tl::unexpected(status.error());
    GLint window = 0;
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &window);
    std::vector<double> times;
    for (int frame = 0; frame < options.frames; ++frame) {
        OrbitCamera camera = front;
        camera.azimuth = 2.0 * std::numbers::pi * frame / options.frames;
        const auto begin = std::chrono::steady_clock::now();
        const std::vector<SceneLayer> layers = {{.scene = model.smooth}};
        if (Status status = painted.layers.show(layers); !status)
            return tl::unexpected(status.error());
        if (Status status = painted.target.bind(size, samples); !status)
            return tl::unexpected(status.error());
        painted.painter.draw(painted.layers.layers(), {}, camera, size);
        painted.target.show(static_cast<GLuint>(window), 0, 0);
        glFinish();
        if (frame > 0) times.push_back(milliseconds_since(begin)); // the first one uploads
    }
    std::ranges::sort(times);
    return times;
}

Status run_mesh(Painted& painted, const std::string& name, const BenchOptions& options)
{
    const auto models = load_view_models(std::vector<std::string>{name}, Primitives::triangles, {});
    if (!models) return tl::unexpected(models.error());
    const ViewModel& model = *models->front();
    const std::size_t uploads = painted.layers.uploads();
    const std::size_t bytes = painted.layers.uploaded_bytes();
    for (const int samples : {1, 4}) {
        const auto times = draw_round(painted, model, options, samples);
        if (!times) return tl::unexpected(times.error());
        const std::size_t last = times->size() - 1;
        (void)std::printf("%-20s %9zu %8d %10.1f %10.1f %10.1f\n", name.c_str(),
                          model.mesh.triangle_count(), samples, (*times)[last / 2],
                          (*times)[last * 95 / 100], times->back());
    }
    (void)std::printf("%-20s uploaded %zu times, %.1f MB\n", "", painted.layers.uploads() - uploads,
                      1e-6 * static_cast<double>(painted.layers.uploaded_bytes() - bytes));
    return {};
}

Status run(const BenchOptions& options)
{
    if (!options.hardware) ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    const auto context = EglContext::create();
    if (!context) return tl::unexpected(context.error());
    auto painter = GlPainter::create();
    if (!painter) return tl::unexpected(painter.error());
    auto target = GlTarget::create();
    if (!target) return tl::unexpected(target.error());
    auto window = GlTarget::create();
    if (!window) return tl::unexpected(window.error());
    const auto* const renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    (void)std::printf("%s, %u processors, %d x %d, %d frames round each mesh, ms a frame\n\n",
                      renderer == nullptr ? "unknown" : renderer,
                      std::thread::hardware_concurrency(), options.width, options.height,
                      options.frames);
    (void)std::printf("%-20s %9s %8s %10s %10s %10s\n", "mesh", "triangles", "samples", "median",
                      "95 of 100", "longest");
    Painted painted = {std::move(*painter), std::move(*target), std::move(*window), {}};
    for (const std::string& mesh : options.meshes)
        if (Status status = run_mesh(painted, mesh, options); !status) return status;
    return {};
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "How long the viewer's pictures take by software",
        [&](CLI::App& app) {
            app.add_option("--frames", options.frames, "Of each mesh and kind")
                ->check(CLI::Range(2, 100000))
                ->capture_default_str();
            app.add_option("--width", options.width, "Pixels")->check(CLI::Range(1, 8192));
            app.add_option("--height", options.height, "Pixels")->check(CLI::Range(1, 8192));
            app.add_option("--mesh", options.meshes,
                           "A file or a built-in instead of the usual meshes")
                ->allow_extra_args(false);
            app.add_flag("--hardware", options.hardware,
                         "By the graphics card, where there is one");
        },
        [&] {
            if (options.meshes.empty()) {
                options.meshes = {"torus:250x200", "spaceship:100000"};
                if (const char* const own = std::getenv("PROXIMA_BENCH_MESH"); own != nullptr)
                    options.meshes.emplace_back(own);
            }
            const proxima::Status status = proxima::bench::run(options);
            if (!status) (void)std::fprintf(stderr, "%s\n", describe(status.error()).c_str());
            return status ? 0 : 1;
        });
}
