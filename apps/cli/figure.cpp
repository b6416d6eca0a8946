#include "cli/figure.h"

#include "base/file_extension.h"
#include "base/output_file.h"
#include "cli/figure_library.h"
#include "cli/program_library.h"

#include <stdexcept>

namespace proxima {
namespace {

/// Opened at the first call.
const Result<LibraryFunction<GetFigureDrawing>>& drawing_library()
{
    static const auto library = open_function<GetFigureDrawing>(
        program_library("figure", "the library that draws figures",
                        "it is a part of the program: install it again"),
        figure_drawing_name);
    return library;
}

const FigureDrawing& drawing()
{
    const auto& library = drawing_library();
    if (!library) throw std::runtime_error(describe(library.error()));
    return *library->call();
}

} // namespace

Status check_drawing()
{
    const auto& library = drawing_library();
    return library ? Status() : tl::unexpected(library.error());
}

double text_length(std::string_view text, double size)
{
    return drawing().text_length(text, size);
}

Image figure_image(const Figure& figure)
{
    const auto count =
        static_cast<std::size_t>(figure.width) * static_cast<std::size_t>(figure.height);
    Image image{figure.width, figure.height, std::vector<std::uint8_t>(3 * count, 0xFF)};
    draw_over(image, figure, 0, 0);
    return image;
}

void draw_over(Image& image, const Figure& figure, int left, int top)
{
    drawing().draw_over(image, figure, left, top);
}

Status write_figure(const Figure& figure, const std::string& path, Progress* progress)
{
    const std::string extension = lower_case_extension(path);
    if (extension == ".png") return write_png(figure_image(figure), path, progress);
    if (extension != ".svg" && extension != ".pdf") {
        return fail(ErrorCode::unsupported_format,
                    "unknown extension: figures are .png, .svg or .pdf", path);
    }
    const std::string bytes = drawing().document(figure, extension == ".pdf");
    auto output = OutputFile::create(path, {progress, bytes.size()});
    if (!output) return tl::unexpected(output.error());
    if (Status status = output->write(bytes); !status) return status;
    return output->commit();
}

} // namespace proxima
