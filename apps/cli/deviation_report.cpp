#include "cli/deviation_report.h"

#include "base/output_file.h"
#include "base/progress.h"
#include "base/text.h"
#include "cli/canvas.h"
#include "cli/legend.h"
#include "cli/picture_scene.h"
#include "cli/plot.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <fmt/core.h>

namespace proxima {

namespace {

constexpr std::array distance_colors = {0x440154U, 0x3B528BU, 0x21918CU, 0x5EC962U, 0xFDE725U};
constexpr std::array signed_colors = {0x2166ACU, 0x92C5DEU, 0xF7F7F7U, 0xF4A582U, 0xB2182BU};

unsigned color_between(unsigned one, unsigned other, double part)
{
    unsigned mixed = 0;
    for (const unsigned shift : {16U, 8U, 0U}) {
        const double from = one >> shift & 255U;
        const double to = other >> shift & 255U;
        mixed |= static_cast<unsigned>(std::lround(from + part * (to - from))) << shift;
    }
    return mixed;
}

template <class Unsigned>
void append_little_endian(std::string& text, Unsigned value)
{
    for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
        text += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 255U);
}

/// A row for each bin.
std::string shares_csv(const DeviationHistogram& histogram)
{
    std::string csv = "from,to";
    for (const std::string& name : histogram.names) csv += "," + name;
    csv += '\n';
    const std::size_t bins = histogram.shares.front().size();
    const double width = histogram.end / static_cast<double>(bins);
    for (std::size_t i = 0; i < bins; ++i) {
        csv += fmt::format("{:.17g},{:.17g}", width * static_cast<double>(i),
                           width * static_cast<double>(i + 1));
        for (const std::vector<double>& shares : histogram.shares)
            csv += fmt::format(",{:.17g}", shares[i]);
        csv += '\n';
    }
    return csv;
}

Figure shares_figure(const DeviationHistogram& histogram, const std::string& title)
{
    const std::size_t bins = histogram.shares.front().size();
    const double width = histogram.end / static_cast<double>(bins);
    double most = 0;
    for (const std::vector<double>& shares : histogram.shares)
        most = std::max(most, *std::ranges::max_element(shares));
    // In percent, up to a number that gives round steps, and some room.
    const double top = 5 * std::ceil(21 * most);
    PlotWords words{.title = title, .x = "distance", .y = "share of the area, percent"};
    for (const std::string& name : histogram.names) words.series.push_back(name);
    Plot plot(linear_scale(histogram.end > 0 ? histogram.end : 1), linear_scale(std::max(top, 5.0)),
              words);
    for (std::size_t series = 0; series < histogram.shares.size(); ++series) {
        double before = 0;
        for (std::size_t i = 0; i <= bins; ++i) {
            const double x = width * static_cast<double>(i);
            const double height = i < bins ? 100 * histogram.shares[series][i] : 0;
            plot.figure.lines.push_back(
                {plot.at(x, before), plot.at(x, height), plot_color(series), 3});
            if (i < bins) {
                plot.figure.lines.push_back(
                    {plot.at(x, height), plot.at(x + width, height), plot_color(series), 3});
            }
            before = height;
        }
    }
    return std::move(plot.figure);
}

} // namespace

unsigned deviation_color(const VertexDeviations& deviations, double distance)
{
    const auto& colors = deviations.is_signed ? signed_colors : distance_colors;
    double part = deviations.largest > 0 ? distance / deviations.largest : 0;
    if (deviations.is_signed) part = 0.5 + 0.5 * part;
    const double at = std::clamp(part, 0.0, 1.0) * static_cast<double>(colors.size() - 1);
    const std::size_t low = std::min(static_cast<std::size_t>(at), colors.size() - 2);
    return color_between(colors[low], colors[low + 1], at - static_cast<double>(low));
}

Status write_deviation_ply(const TriangleMesh& mesh, const VertexDeviations& deviations,
                           const std::string& path, Progress* progress)
{
    constexpr std::size_t vertex_bytes = 4 * sizeof(double) + 3;
    constexpr std::size_t triangle_bytes = 3 * sizeof(std::uint32_t) + 1;
    auto file = OutputFile::create(path, {progress, vertex_bytes * mesh.vertex_count() +
                                                        triangle_bytes * mesh.triangle_count()});
    if (!file) return tl::unexpected(file.error());
    std::string block =
        concat("ply\nformat binary_little_endian 1.0\ncomment distances of proxima deviation\n"
               "element vertex ",
               mesh.vertex_count(),
               "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
               "property uchar green\nproperty uchar blue\nproperty double quality\nelement face ",
               mesh.triangle_count(), "\nproperty list uchar uint vertex_indices\nend_header\n");
    constexpr std::size_t block_bytes = 1 << 16;
    const auto hand_on = [&](bool all) -> Status {
        if (block.size() < block_bytes && !all) return {};
        Status status = file->write(block);
        block.clear();
        return status;
    };
    for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
        for (const double coordinate : mesh.positions()[i])
            append_little_endian(block, std::bit_cast<std::uint64_t>(coordinate));
        const unsigned color = deviation_color(deviations, deviations.distances[i]);
        for (const unsigned shift : {16U, 8U, 0U})
            append_little_endian(block, static_cast<std::uint8_t>(color >> shift & 255U));
        append_little_endian(block, std::bit_cast<std::uint64_t>(deviations.distances[i]));
        if (Status status = hand_on(false); !status) return status;
    }
    for (const TriangleCorners& corners : mesh.triangles()) {
        append_little_endian(block, std::uint8_t{3});
        for (const std::uint32_t corner : corners) append_little_endian(block, corner);
        if (Status status = hand_on(false); !status) return status;
    }
    if (Status status = hand_on(true); !status) return status;
    return file->commit();
}

Result<Image> draw_deviation(const TriangleMesh& mesh, const VertexDeviations& deviations,
                             const CameraChoice& view, Progress* progress)
{
    auto canvas =
        make_canvas(view.size.width, view.size.height, {srgb(0xFBFCFE), srgb(0xE3E8EF)}, progress);
    if (!canvas) return tl::unexpected(canvas.error());
    const auto camera = placed_camera(view, points_to_frame(mesh));
    if (!camera) return tl::unexpected(camera.error());
    const auto color_of = [&](TriangleId id) {
        double sum = 0;
        for (const std::uint32_t corner : mesh.triangles()[to_index(id)])
            sum += deviations.distances[corner];
        return srgb(deviation_color(deviations, sum / 3));
    };
    draw_mesh(*canvas, View(*camera, view.size), mesh, color_of, progress);
    canvas->darken_creases(14.0, 0.45F);
    Image image = canvas->image();
    if (is_cancelled(progress)) return cancelled("drawing");
    Legend legend{.title = "distance", .entries = {}};
    for (int i = 4; i >= 0; --i) {
        const double part = deviations.is_signed ? 0.5 * i - 1 : 0.25 * i;
        const double distance = part * deviations.largest;
        legend.entries.push_back(
            {deviation_color(deviations, distance), fmt::format("{:.4g}", distance)});
    }
    draw_legend(image, legend);
    return image;
}

std::string histogram_text(const DeviationHistogram& histogram)
{
    constexpr double bar = 40;
    const std::vector<double>& shares = histogram.shares.front();
    const double most = std::max(*std::ranges::max_element(shares), 1e-300);
    const double width = histogram.end / static_cast<double>(shares.size());
    std::string text = fmt::format("share of the area by distance, {}\n", histogram.names.front());
    for (std::size_t i = 0; i < shares.size(); ++i) {
        const auto length = static_cast<std::size_t>(std::lround(bar * shares[i] / most));
        text += fmt::format("  to {:<12.6g} {:7.3f} %  {}\n", width * static_cast<double>(i + 1),
                            100 * shares[i], std::string(length, '#'));
    }
    return text;
}

Status write_deviation_histogram(const DeviationHistogram& histogram, const std::string& title,
                                 const std::string& path, Progress* progress)
{
    return write_plot([&] { return shares_csv(histogram); },
                      [&] { return shares_figure(histogram, title); }, path, progress);
}

} // namespace proxima
