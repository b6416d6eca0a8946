#include "cli/figure_library.h"

#include "cli/printable.h"
#include "proxima/export.h"

#include <algorithm>
#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <cmath>
#include <memory>
#include <new>
#include <numbers>
#include <pango/pangocairo.h>

namespace proxima {
namespace {

template <auto Function>
struct Release {
    template <class Object>
    void operator()(Object* object) const
    {
        Function(object);
    }
};
using Surface = std::unique_ptr<cairo_surface_t, Release<cairo_surface_destroy>>;
using Pen = std::unique_ptr<cairo_t, Release<cairo_destroy>>;
using Layout = std::unique_ptr<PangoLayout, Release<g_object_unref>>;

/// cairo says only afterwards that something went wrong with its memory.
void check_memory(cairo_status_t status)
{
    if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
}

/// Text that Pango takes: what is no printable UTF-8 is a question mark.
std::string drawable(std::string_view text)
{
    std::string result;
    for (std::size_t position = 0; position < text.size();) {
        const std::size_t length = utf8_length(text.substr(position));
        result += length == 0 ? "?" : text.substr(position, length);
        position += std::max<std::size_t>(length, 1);
    }
    return result;
}

/// A line of text for capitals of this height. The same on every surface: lengths are not rounded
/// to pixels.
Layout make_layout(cairo_t* pen, std::string_view text, double size)
{
    constexpr double capital = 0.729; // of the size of DejaVu Sans
    Layout layout(pango_cairo_create_layout(pen));
    PangoContext* const context = pango_layout_get_context(layout.get());
    const std::unique_ptr<cairo_font_options_t, Release<cairo_font_options_destroy>> options(
        cairo_font_options_create());
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
    cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
    pango_cairo_context_set_font_options(context, options.get());
    pango_context_set_round_glyph_positions(context, FALSE);
    const std::unique_ptr<PangoFontDescription, Release<pango_font_description_free>> font(
        pango_font_description_new());
    pango_font_description_set_family(font.get(), "DejaVu Sans,sans");
    pango_font_description_set_absolute_size(font.get(), size / capital * PANGO_SCALE);
    pango_layout_set_font_description(layout.get(), font.get());
    pango_layout_set_single_paragraph_mode(layout.get(), TRUE);
    const std::string words = drawable(text);
    pango_layout_set_text(layout.get(), words.data(), static_cast<int>(words.size()));
    return layout;
}

double length_of(const Layout& layout)
{
    PangoRectangle extents;
    pango_layout_get_extents(layout.get(), nullptr, &extents);
    return pango_units_to_double(extents.width);
}

void set_color(cairo_t* pen, unsigned color, double opacity = 1.0)
{
    const auto channel = [&](unsigned shift) { return (color >> shift & 0xFFU) / 255.0; };
    cairo_set_source_rgba(pen, channel(16), channel(8), channel(0), opacity);
}

void draw_text(cairo_t* pen, const FigureText& text)
{
    const Layout layout = make_layout(pen, text.text, text.style.size);
    const double length = length_of(layout);
    const double before = text.style.anchor == TextAnchor::start    ? 0.0
                          : text.style.anchor == TextAnchor::middle ? 0.5 * length
                                                                    : length;
    cairo_save(pen);
    cairo_translate(pen, text.at.x(), text.at.y());
    if (text.style.turn == TextTurn::upward) cairo_rotate(pen, -0.5 * std::numbers::pi);
    cairo_move_to(pen, -before, -pango_units_to_double(pango_layout_get_baseline(layout.get())));
    set_color(pen, text.style.color);
    pango_cairo_show_layout(pen, layout.get());
    cairo_restore(pen);
}

void draw(cairo_t* pen, const Figure& figure)
{
    cairo_set_antialias(pen, CAIRO_ANTIALIAS_NONE); // no seams between boxes that touch
    for (const FigureBox& box : figure.boxes) {
        const Vec2 size = box.upper - box.lower;
        cairo_rectangle(pen, box.lower.x(), box.lower.y(), size.x(), size.y());
        set_color(pen, box.color, box.opacity);
        cairo_fill(pen);
    }
    cairo_set_antialias(pen, CAIRO_ANTIALIAS_DEFAULT);
    for (const FigurePolygon& polygon : figure.polygons) {
        for (const Vec2& corner : polygon.corners) cairo_line_to(pen, corner.x(), corner.y());
        set_color(pen, polygon.color);
        cairo_fill(pen);
    }
    cairo_set_line_cap(pen, CAIRO_LINE_CAP_ROUND);
    for (const FigureLine& line : figure.lines) {
        cairo_move_to(pen, line.from.x(), line.from.y());
        cairo_line_to(pen, line.to.x(), line.to.y());
        set_color(pen, line.color);
        cairo_set_line_width(pen, line.width);
        cairo_stroke(pen);
    }
    for (const FigureText& text : figure.texts) draw_text(pen, text);
}

/// The part of a picture that a figure is drawn over, four bytes a pixel as cairo has them.
class Overlay {
public:
    Overlay(Image& image, const Figure& figure, int left, int top)
        : image_(image), left_(std::max(left, 0)), top_(std::max(top, 0)),
          width_(std::min(left + figure.width, image.width) - left_),
          height_(std::min(top + figure.height, image.height) - top_)
    {}

    [[nodiscard]] bool empty() const { return width_ <= 0 || height_ <= 0; }

    /// Draws with the figure's corner at (left, top) of the picture.
    void draw(const Figure& figure, int left, int top)
    {
        const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_, height_));
        check_memory(cairo_surface_status(surface.get()));
        std::uint8_t* const bytes = cairo_image_surface_get_data(surface.get());
        const auto row_bytes =
            static_cast<std::size_t>(cairo_image_surface_get_stride(surface.get()));
        const auto each_pixel = [&](const auto& act) {
            for (int y = 0; y < height_; ++y) {
                for (int x = 0; x < width_; ++x) {
                    const std::size_t first = 3 * (static_cast<std::size_t>(top_ + y) *
                                                       static_cast<std::size_t>(image_.width) +
                                                   static_cast<std::size_t>(left_ + x));
                    // Blue, green, red: little-endian, as all machines that this runs on.
                    act(&image_.bytes[first], bytes + row_bytes * static_cast<std::size_t>(y) +
                                                  4 * static_cast<std::size_t>(x));
                }
            }
        };
        each_pixel([](const std::uint8_t* rgb, std::uint8_t* bgr) {
            std::reverse_copy(rgb, rgb + 3, bgr);
        });
        cairo_surface_mark_dirty(surface.get());
        const Pen pen(cairo_create(surface.get()));
        cairo_translate(pen.get(), left - left_, top - top_);
        proxima::draw(pen.get(), figure);
        check_memory(cairo_status(pen.get()));
        cairo_surface_flush(surface.get());
        each_pixel([](std::uint8_t* rgb, const std::uint8_t* bgr) {
            std::reverse_copy(bgr, bgr + 3, rgb);
        });
    }

private:
    Image& image_;
    int left_;
    int top_;
    int width_;
    int height_;
};

/// .svg or .pdf.
std::string document(const Figure& figure, bool is_pdf)
{
    constexpr double points_per_pixel = 0.75;
    const double scale = is_pdf ? points_per_pixel : 1.0;
    std::string bytes;
    const auto append = [](void* to, const unsigned char* data, unsigned length) {
        static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), length);
        return CAIRO_STATUS_SUCCESS;
    };
    const auto create =
        is_pdf ? cairo_pdf_surface_create_for_stream : cairo_svg_surface_create_for_stream;
    const Surface surface(create(append, &bytes, scale * figure.width, scale * figure.height));
    if (!is_pdf) cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
    const Pen pen(cairo_create(surface.get()));
    cairo_scale(pen.get(), scale, scale);
    set_color(pen.get(), 0xFFFFFF);
    cairo_paint(pen.get());
    draw(pen.get(), figure);
    cairo_surface_finish(surface.get());
    check_memory(cairo_status(pen.get()));
    check_memory(cairo_surface_status(surface.get()));
    return bytes;
}

double measure(std::string_view text, double size)
{
    const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
    const Pen pen(cairo_create(surface.get()));
    return length_of(make_layout(pen.get(), text, size));
}

void draw_on(Image& image, const Figure& figure, int left, int top)
{
    Overlay overlay(image, figure, left, top);
    if (!overlay.empty()) overlay.draw(figure, left, top);
}

} // namespace
} // namespace proxima

extern "C" PROXIMA_EXPORT proxima::GetFigureDrawing proxima_figure_drawing;

const proxima::FigureDrawing* proxima_figure_drawing() noexcept
{
    static constexpr proxima::FigureDrawing drawing{proxima::measure, proxima::draw_on,
                                                    proxima::document};
    return &drawing;
}
