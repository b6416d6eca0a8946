// The figures of the thesis, made anew from what the library computes.
//
//     for (const ThesisFigure& figure : thesis_figures()) {
//         const auto drawn = make_figure(figure, {.progress = &progress});    // what it shows
//         const auto image = figure_picture(*drawn, renderer);         // figure_pages.h
//     }
#pragma once

#include "cli/camera.h"
#include "cli/figure.h"
#include "cli/image.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/scene.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace proxima {

/// A scene and who looks at it.
struct ScenePanel {
    std::string title;
    DrawnScene scene;
    OrbitCamera camera;
    ViewSize size;
};

/// A picture that is there already.
struct PicturePanel {
    std::string title;
    Image image;
};

using FigurePanel = std::variant<ScenePanel, PicturePanel>;

/// What a figure shows: a flat drawing, or panels in rows.
struct FigureContent {
    std::string caption; ///< its numbers are those of this run
    std::optional<Figure> drawing = {};
    std::vector<FigurePanel> panels = {};
    int columns = 3; ///< of panels
};

struct ThesisFigure {
    std::string_view number; ///< "3.14"
    std::string_view title;
    Result<FigureContent> (*make)(const Execution& context) = nullptr;
    /// In place of `make` where it shows models of files, which are in that folder or are not.
    Result<FigureContent> (*make_of_models)(const Execution& context,
                                            const std::string& folder) = nullptr;
};

/// A figure of the thesis that is not made, and why.
struct MissingFigure {
    std::string_view number;
    std::string_view title;
    std::string_view reason;
};

/// \param models folder of the scanned models that the thesis shows; those that are not there are
/// replaced by others, and the caption says so
[[nodiscard]] Result<FigureContent>
make_figure(const ThesisFigure& figure, const Execution& context, const std::string& models = {});

/// All, in the thesis's order.
[[nodiscard]] std::span<const ThesisFigure> thesis_figures();
[[nodiscard]] std::span<const MissingFigure> missing_figures();

} // namespace proxima
