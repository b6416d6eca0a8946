#include "viewer/figures/figure_pages.h"

#include "cli/stopwatch.h"
#include "proxima/execution.h"
#include "viewer/figures/figure_colors.h"

#include <algorithm>
#include <fmt/core.h>

namespace proxima {
namespace {

/// On the page pictures are as wide as this at most: type grows with wider ones.
constexpr double page_width = 1100.0;
constexpr double title_size = 17.0;
constexpr int gap = 12;

struct DrawnPanel {
    std::string title;
    Image image;
};

Result<DrawnPanel> draw(const FigurePanel& panel, Renderer& renderer)
{
    if (const auto* const picture = std::get_if<PicturePanel>(&panel); picture != nullptr)
        return DrawnPanel{picture->title, picture->image};
    const auto& scene = std::get<ScenePanel>(panel);
    auto image = renderer.render(scene.scene, scene.camera, scene.size);
    if (!image) return tl::unexpected(image.error());
    return DrawnPanel{scene.title, std::move(*image)};
}

void paste(Image& onto, const Image& image, int left, int top)
{
    const auto row_bytes = 3 * static_cast<std::ptrdiff_t>(image.width);
    for (int y = 0; y < image.height; ++y) {
        const std::ptrdiff_t from = row_bytes * y;
        const std::ptrdiff_t to = 3 * (static_cast<std::ptrdiff_t>(onto.width) * (top + y) + left);
        std::copy_n(image.bytes.begin() + from, row_bytes, onto.bytes.begin() + to);
    }
}

std::string html_text(std::string_view text)
{
    std::string result;
    for (const char letter : text) {
        if (letter == '&') {
            result += "&amp;";
        } else if (letter == '<') {
            result += "&lt;";
        } else if (letter == '>') {
            result += "&gt;";
        } else {
            result += letter;
        }
    }
    return result;
}

} // namespace

Result<Image> figure_picture(const FigureContent& content, Renderer& renderer)
{
    if (content.drawing) return figure_image(*content.drawing);
    std::vector<DrawnPanel> panels;
    int width = 0;
    int height = 0;
    for (const FigurePanel& panel : content.panels) {
        auto drawn = draw(panel, renderer);
        if (!drawn) return tl::unexpected(drawn.error());
        width = std::max(width, drawn->image.width);
        height = std::max(height, drawn->image.height);
        panels.push_back(std::move(*drawn));
    }
    const int count = static_cast<int>(panels.size());
    const int columns = std::max(1, std::min(content.columns, count));
    const int rows = (count + columns - 1) / columns;
    const int sheet_width = columns * width + (columns + 1) * gap;
    double type = std::max(1.0, sheet_width / page_width);
    for (const DrawnPanel& panel : panels)
        type = std::min(type, 0.96 * width / text_length(panel.title, title_size));
    // What a single panel shows is said below the picture.
    const int title_height = count == 1 ? gap : static_cast<int>(2.7 * title_size * type);
    Figure sheet{.width = sheet_width, .height = rows * (height + title_height) + gap};
    const auto left = [&](int i) { return gap + (i % columns) * (width + gap); };
    const auto top = [&](int i) { return title_height + (i / columns) * (height + title_height); };
    for (int i = 0; i < count && count > 1; ++i) {
        sheet.texts.push_back({{left(i) + 0.5 * width, top(i) - 15.0 * type},
                               panels[static_cast<std::size_t>(i)].title,
                               {title_size * type, figure_colors::ink, TextAnchor::middle}});
    }
    Image image = figure_image(sheet);
    for (int i = 0; i < count; ++i)
        paste(image, panels[static_cast<std::size_t>(i)].image, left(i), top(i));
    return image;
}

std::string figure_file_stem(std::string_view number)
{
    std::string stem = fmt::format("figure_{}", number);
    std::ranges::replace(stem, '.', '_');
    return stem;
}

Result<FigurePage> write_figure_page(const ThesisFigure& figure,
                                     const std::filesystem::path& folder, Renderer& renderer,
                                     const Execution& context, const std::string& models)
{
    const Stopwatch watch;
    const auto content = make_figure(figure, context, models);
    if (!content) return tl::unexpected(content.error());
    FigurePage page{std::string(figure.number), std::string(figure.title), content->caption, {}, 0};
    const auto image = figure_picture(*content, renderer);
    if (!image) return tl::unexpected(image.error());
    const auto name = [&](const char* extension) {
        return page.files.emplace_back(figure_file_stem(figure.number) + extension);
    };
    if (Status status = write_png(*image, folder / name(".png"), context.progress); !status)
        return tl::unexpected(status.error());
    if (content->drawing) {
        const Status status =
            write_figure(*content->drawing, folder / name(".svg"), context.progress);
        if (!status) return tl::unexpected(status.error());
    }
    page.seconds = watch.seconds();
    return page;
}

std::string figure_sheet(std::span<const FigurePage> pages, std::span<const MissingFigure> missing)
{
    std::string html = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Figures of the thesis, made by Proxima</title>
<style>
body { font-family: sans-serif; color: #222; max-width: 1100px; margin: 2em auto; padding: 0 1em; }
figure { margin: 3em 0; }
img { max-width: 100%; border: 1px solid #ddd; }
figcaption { margin-top: 0.6em; line-height: 1.45; }
code { background: #f1f3f6; padding: 0.1em 0.35em; }
</style>
</head>
<body>
<h1>Figures of the thesis, made by Proxima</h1>
<p>Every picture is computed from data of this library by the command below it; the numbers in the
captions are those of the run that made this page.</p>
)";
    for (const FigurePage& page : pages) {
        html += fmt::format("<figure id=\"{0}\">\n<a href=\"{1}\"><img src=\"{1}\" "
                            "alt=\"Figure {0}: {2}\"></a>\n<figcaption><b>Figure {0}. {2}.</b> "
                            "{3}<br><code>proxima figures --out DIR --only {0}</code>",
                            page.number, page.files.front(), html_text(page.title),
                            html_text(page.caption));
        for (std::size_t i = 1; i < page.files.size(); ++i)
            html += fmt::format(" <a href=\"{0}\">{0}</a>", page.files[i]);
        html += "</figcaption>\n</figure>\n";
    }
    if (!missing.empty()) html += "<h2>Not made</h2>\n<ul>\n";
    for (const MissingFigure& figure : missing) {
        html += fmt::format("<li><b>Figure {}. {}.</b> {}</li>\n", figure.number,
                            html_text(figure.title), html_text(figure.reason));
    }
    if (!missing.empty()) html += "</ul>\n";
    return html + "</body>\n</html>\n";
}

} // namespace proxima
