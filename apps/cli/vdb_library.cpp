#include "cli/vdb_library.h"

#include "base/output_file.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/export.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#include <ostream>
#include <streambuf>
#include <utility>

namespace proxima {

namespace {

using Tree = openvdb::FloatTree;
using Leaf = Tree::LeafNodeType;

/// What a library writes to a stream goes to an output file.
class FileBuffer final : public std::streambuf {
public:
    explicit FileBuffer(OutputFile& file) noexcept : file_(file) {}
    [[nodiscard]] const Status& status() const noexcept { return status_; }

private:
    std::streamsize xsputn(const char* text, std::streamsize size) override
    {
        if (status_) status_ = file_.write(std::string_view(text, static_cast<std::size_t>(size)));
        return status_ ? size : 0;
    }
    int_type overflow(int_type letter) override
    {
        const char text = traits_type::to_char_type(letter);
        return xsputn(&text, 1) == 1 ? letter : traits_type::eof();
    }

    OutputFile& file_;
    Status status_;
};

/// Fills the voxels of one leaf, or leaves them to the background.
class LeafFiller {
public:
    LeafFiller(const PointGrid& grid, std::span<const double> distances, double band) noexcept
        : grid_(grid), distances_(distances), band_(band)
    {}

    void fill(Tree& tree, const std::array<std::uint32_t, 3>& first)
    {
        const openvdb::Coord begin(static_cast<int>(first[0]), static_cast<int>(first[1]),
                                   static_cast<int>(first[2]));
        bool uniform = true; // beyond the band, on one side
        bool inside = false;
        visit(first, [&](std::uint32_t i, std::uint32_t j, std::uint32_t k, double distance) {
            const bool is_first = i == first[0] && j == first[1] && k == first[2];
            if (is_first) inside = distance < 0;
            uniform = uniform && !is_active(distance) && (distance < 0) == inside;
        });
        if (uniform && !inside) return;
        if (uniform && is_whole(first)) {
            tree.addTile(1, begin, -static_cast<float>(band_), false);
            return;
        }
        Leaf& leaf = *tree.touchLeaf(begin);
        visit(first, [&](std::uint32_t i, std::uint32_t j, std::uint32_t k, double distance) {
            const openvdb::Coord voxel(static_cast<int>(i), static_cast<int>(j),
                                       static_cast<int>(k));
            if (is_active(distance)) {
                leaf.setValueOn(voxel, static_cast<float>(distance));
            } else {
                leaf.setValueOff(voxel, static_cast<float>(distance));
            }
        });
    }

private:
    [[nodiscard]] bool is_active(double distance) const noexcept
    {
        return !(std::abs(distance) == band_);
    }

    [[nodiscard]] bool is_whole(const std::array<std::uint32_t, 3>& first) const noexcept
    {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (first[axis] + Leaf::DIM > grid_.size[axis]) return false;
        return true;
    }

    template <class Visit>
    void visit(const std::array<std::uint32_t, 3>& first, Visit&& visit) const
    {
        const auto end = [&](std::size_t axis) {
            return std::min(first[axis] + Leaf::DIM, grid_.size[axis]);
        };
        for (std::uint32_t k = first[2]; k < end(2); ++k) {
            for (std::uint32_t j = first[1]; j < end(1); ++j) {
                for (std::uint32_t i = first[0]; i < end(0); ++i)
                    visit(i, j, k, distances_[grid_.position(i, j, k)]);
            }
        }
    }

    const PointGrid& grid_;
    std::span<const double> distances_;
    double band_;
};

/// Error where voxels cannot be numbered, or floats do not hold the distances.
Status check_range(const PointGrid& grid, std::span<const double> distances,
                   const std::string& path)
{
    if (std::ranges::max(grid.size) > std::numeric_limits<openvdb::Int32>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    "a .vdb has at most 2^31 - 1 points along an axis: take a coarser grid", path);
    }
    const double spacing = grid.spacing;
    double most = 0;
    for (const double distance : distances) most = std::max(most, std::abs(distance));
    constexpr double largest = std::numeric_limits<float>::max();
    constexpr double smallest = std::numeric_limits<float>::min();
    if (most <= largest && spacing >= smallest && spacing <= largest) return {};
    return fail(ErrorCode::limit_exceeded,
                concat("distances up to ", most, " on a grid of spacing ", spacing,
                       " do not fit the floats of .vdb: write .npy or .vti"),
                path);
}

Result<openvdb::FloatGrid::Ptr> vdb_grid(const PointGrid& grid, std::span<const double> distances,
                                         double band, Progress* progress)
{
    const bool is_level_set = std::isfinite(band);
    auto field = openvdb::FloatGrid::create(is_level_set ? static_cast<float>(band) : 0);
    field->setName("distance");
    field->setCreator("proxima");
    field->setGridClass(is_level_set ? openvdb::GRID_LEVEL_SET : openvdb::GRID_UNKNOWN);
    auto transform = openvdb::math::Transform::createLinearTransform(grid.spacing);
    transform->postTranslate({grid.origin.x(), grid.origin.y(), grid.origin.z()});
    field->setTransform(transform);
    LeafFiller filler(grid, distances, band);
    for (std::uint32_t k = 0; k < grid.size[2]; k += Leaf::DIM) {
        if (is_cancelled(progress)) return cancelled("writing", "the grid");
        for (std::uint32_t j = 0; j < grid.size[1]; j += Leaf::DIM) {
            for (std::uint32_t i = 0; i < grid.size[0]; i += Leaf::DIM)
                filler.fill(field->tree(), {i, j, k});
        }
    }
    openvdb::tools::prune(field->tree());
    return field;
}

Status write_vdb(const PointGrid& grid, std::span<const double> distances, double band,
                 const std::string& path, Progress* progress)
{
    if (Status status = check_range(grid, distances, path); !status) return status;
    auto file = OutputFile::create(path, {progress, 0});
    if (!file) return tl::unexpected(file.error());
    FileBuffer buffer(*file);
    try {
        openvdb::initialize();
        const auto field = vdb_grid(grid, distances, band, progress);
        if (!field) return tl::unexpected(field.error());
        std::ostream stream(&buffer);
        stream.exceptions(std::ostream::badbit);
        openvdb::io::Stream(stream).write(openvdb::GridCPtrVec{*field});
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) { // of the library, or because bytes were refused
        if (!buffer.status()) return buffer.status();
        return fail(ErrorCode::file_not_writable, concat("OpenVDB says: ", error.what()), path);
    }
    if (!buffer.status()) return buffer.status();
    return file->commit();
}

} // namespace

} // namespace proxima

extern "C" PROXIMA_EXPORT proxima::WriteVdb proxima_write_vdb;

void proxima_write_vdb(const proxima::PointGrid& grid, std::span<const double> distances,
                       double band, const std::string& path, proxima::Progress* progress,
                       proxima::Status& status)
{
    status = proxima::write_vdb(grid, distances, band, path, progress);
}
