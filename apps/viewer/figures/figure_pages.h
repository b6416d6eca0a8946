// Figures as files: pictures, drawings, and the sheet that shows all of them.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/figures/thesis_figure.h"
#include "viewer/renderer.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// The drawing, or the panels under their titles in rows. Errors as Renderer::render.
[[nodiscard]] Result<Image> figure_picture(const FigureContent& content, Renderer& renderer);

/// A figure that was written.
struct FigurePage {
    std::string number;
    std::string title;
    std::string caption;
    std::vector<std::string> files; ///< names in the folder, the picture first
    double seconds = 0.0;
};

/// "figure_3_14" for "3.14".
[[nodiscard]] std::string figure_file_stem(std::string_view number);

/// Makes the figure, with the models of that folder, and writes it into the other: .png, and .svg where it is a flat drawing.
/// Errors: what making and drawing it say, file_not_writable, cancelled.
[[nodiscard]] Result<FigurePage> write_figure_page(const ThesisFigure& figure,
                                                   const std::filesystem::path& folder,
                                                   Renderer& renderer, const Execution& context,
                                                   const std::string& models = {});

/// An HTML page of pictures, captions, the command that makes each, and what is missing.
[[nodiscard]] std::string figure_sheet(std::span<const FigurePage> pages,
                                       std::span<const MissingFigure> missing);

} // namespace proxima
