#include "cli/plot_file.h"

#include "base/file_extension.h"
#include "base/output_file.h"

namespace proxima {

Status check_plot_format(const std::string& path)
{
    const std::string extension = lower_case_extension(path);
    if (extension == ".csv" || extension == ".svg" || extension == ".png") return {};
    return fail(ErrorCode::unsupported_format, "unknown extension: plots are .csv, .svg or .png",
                path);
}

Status write_plot(const std::string& csv, const Figure& figure, const std::string& path,
                  Progress* progress)
{
    if (Status status = check_plot_format(path); !status) return status;
    if (lower_case_extension(path) != ".csv") return write_figure(figure, path, progress);
    auto output = OutputFile::create(path, {progress, csv.size()});
    if (!output) return tl::unexpected(output.error());
    if (Status status = output->write(csv); !status) return status;
    return output->commit();
}

} // namespace proxima
