#include "cli/figure.h"

#include "base/file_extension.h"
#include "base/output_file.h"
#include "cli/canvas.h"
#include "cli/names.h"

#include <fmt/core.h>

namespace proxima {
namespace {

/// Text as XML has it; what is no printable UTF-8 is a question mark.
std::string xml_text(std::string_view text)
{
    std::string result;
    for (std::size_t position = 0; position < text.size();) {
        const std::size_t length = utf8_length(text.substr(position));
        const std::string_view letter = text.substr(position, std::max<std::size_t>(length, 1));
        position += letter.size();
        if (length == 0) {
            result += '?';
        } else if (letter == "&") {
            result += "&amp;";
        } else if (letter == "<") {
            result += "&lt;";
        } else if (letter == ">") {
            result += "&gt;";
        } else {
            result += letter;
        }
    }
    return result;
}

const char* anchor_name(TextAnchor anchor)
{
    switch (anchor) {
    case TextAnchor::middle:
        return "middle";
    case TextAnchor::end:
        return "end";
    case TextAnchor::start:
        break;
    }
    return "start";
}

} // namespace

std::string figure_svg(const Figure& figure)
{
    std::string svg =
        fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
                    "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\">\n"
                    "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
                    figure.width, figure.height);
    for (const FigureBox& box : figure.boxes) {
        const Vec2 size = box.upper - box.lower;
        svg += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
                           "fill=\"#{:06x}\"/>\n",
                           box.lower.x(), box.lower.y(), size.x(), size.y(), box.color);
    }
    for (const FigurePolygon& polygon : figure.polygons) {
        svg += "<polygon points=\"";
        for (const Vec2& corner : polygon.corners)
            svg += fmt::format("{:.2f},{:.2f} ", corner.x(), corner.y());
        svg += fmt::format("\" fill=\"#{:06x}\"/>\n", polygon.color);
    }
    for (const FigureLine& line : figure.lines) {
        svg += fmt::format(
            "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" "
            "stroke=\"#{:06x}\" stroke-width=\"{:.2f}\" stroke-linecap=\"round\"/>\n",
            line.from.x(), line.from.y(), line.to.x(), line.to.y(), line.color, line.width);
    }
    for (const FigureText& text : figure.texts) {
        // Capitals are about 0.72 of a font's size.
        const std::string turn =
            text.style.turn == TextTurn::upward
                ? fmt::format(" transform=\"rotate(-90 {:.2f} {:.2f})\"", text.at.x(), text.at.y())
                : "";
        svg += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{:.1f}\" fill=\"#{:06x}\" "
                           "text-anchor=\"{}\"{}>{}</text>\n",
                           text.at.x(), text.at.y(), text.style.size / 0.72, text.style.color,
                           anchor_name(text.style.anchor), turn, xml_text(text.text));
    }
    return svg + "</svg>\n";
}

Image figure_image(const Figure& figure)
{
    Canvas canvas(figure.width, figure.height);
    // Nearer and nearer, so that what comes later covers what was there.
    double nearness = 1.0;
    for (const FigureBox& box : figure.boxes) {
        nearness += 1.0;
        const Color color = srgb(box.color);
        const auto corner = [&](double x, double y) -> ScreenVertex {
            return {{x, y, nearness}, color};
        };
        const ScreenVertex a = corner(box.lower.x(), box.lower.y());
        const ScreenVertex b = corner(box.upper.x(), box.lower.y());
        const ScreenVertex c = corner(box.upper.x(), box.upper.y());
        const ScreenVertex d = corner(box.lower.x(), box.upper.y());
        canvas.draw_triangle({a, b, c});
        canvas.draw_triangle({a, c, d});
    }
    for (const FigurePolygon& polygon : figure.polygons) {
        nearness += 1.0;
        const Color color = srgb(polygon.color);
        const auto corner = [&](std::size_t i) -> ScreenVertex {
            return {{polygon.corners[i].x(), polygon.corners[i].y(), nearness}, color};
        };
        for (std::size_t i = 2; i < polygon.corners.size(); ++i)
            canvas.draw_triangle({corner(0), corner(i - 1), corner(i)});
    }
    nearness += 1.0;
    for (const FigureLine& line : figure.lines) {
        canvas.draw_line({line.from.x(), line.from.y(), nearness},
                         {line.to.x(), line.to.y(), nearness}, srgb(line.color),
                         {.width = line.width});
    }
    for (const FigureText& text : figure.texts)
        draw_text(canvas, text.text, text.at.x(), text.at.y(), text.style);
    return canvas.image();
}

Status write_figure(const Figure& figure, const std::string& path, Progress* progress)
{
    const std::string extension = lower_case_extension(path);
    if (extension == ".png") return write_png(figure_image(figure), path, progress);
    if (extension != ".svg") {
        return fail(ErrorCode::unsupported_format, "unknown extension: figures are .svg or .png",
                    path);
    }
    const std::string text = figure_svg(figure);
    auto output = OutputFile::create(path, {progress, text.size()});
    if (!output) return tl::unexpected(output.error());
    if (Status status = output->write(text); !status) return status;
    return output->commit();
}

} // namespace proxima
