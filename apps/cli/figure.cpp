#include "cli/figure.h"

#include "base/file_extension.h"
#include "base/output_file.h"
#include "cli/figure_library.h"
#include "cli/program_library.h"

#include <stdexcept>

namespace proxima {
namespace {

Result<const FigureDrawing*> open_drawing()
{
    static const Result<SharedLibrary> library =
        open_program_library("figure", "the library that draws figures",
                             "it is a part of the program: install it again");
    if (!library) return tl::unexpected(library.error());
    GetFigureDrawing* get = nullptr;
    SymbolTable symbols(*library);
    symbols.need(get, figure_drawing_name);
    if (Status found = symbols.finish("it is of another version"); !found)
        return tl::unexpected(found.error());
    return get();
}

/// Opened at the first call. Without it an installation is not whole, so that no function here has an error for it.
const FigureDrawing& drawing()
{
    static const Result<const FigureDrawing*> opened = open_drawing();
    if (!opened) throw std::runtime_error(describe(opened.error()));
    return **opened;
}

} // namespace

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
