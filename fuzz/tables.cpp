// Any bytes as a file of points, rays or poses, text or .npy: refused with a reason and the place,
// or finite numbers, valid rays and rigid transforms. The first byte says which.
#include "base/check.h"
#include "cli/number_table.h"
#include "cli/point_options.h"
#include "cli/poses.h"
#include "cli/ray_sources.h"
#include "cli/session.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

namespace {

using namespace proxima;

/// A file in memory that has a path.
class MemoryFile {
public:
    MemoryFile(const std::uint8_t* data, std::size_t size) : file_(::memfd_create("table", 0))
    {
        PROXIMA_CHECK_GE(file_, 0);
        PROXIMA_CHECK_EQ(::write(file_, data, size), static_cast<ssize_t>(size));
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { ::close(file_); }

    [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

private:
    int file_;
};

/// Whether there is a result; an error says what and where.
template <class T>
bool is_taken(const Result<T>& result)
{
    if (result) return true;
    PROXIMA_CHECK(!result.error().message.empty());
    PROXIMA_CHECK(!result.error().where.empty());
    return false;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    if (size == 0) return 0;
    const MemoryFile file(data + 1, size - 1);
    CommonOptions quiet;
    quiet.quiet = true;
    Session session(quiet);
    switch (data[0] % 3) {
    case 0: {
        const auto points = read_points({.file = file.path(), .points = {}}, session);
        if (!is_taken(points)) break;
        PROXIMA_CHECK_GT(points->rows(), 0U);
        PROXIMA_CHECK_EQ(points->values.size(), 3 * points->rows());
        PROXIMA_CHECK(
            std::ranges::all_of(points->values, [](double x) { return std::isfinite(x); }));
        for (std::size_t row = 0; row < points->rows(); ++row)
            PROXIMA_CHECK(!points->place_of(row).empty());
        break;
    }
    case 1: {
        const auto rays = read_rays(file.path(), session);
        if (is_taken(rays)) PROXIMA_CHECK(std::ranges::all_of(*rays, is_valid));
        break;
    }
    default:
        const auto poses = read_poses(file.path(), session);
        if (!is_taken(poses)) break;
        for (const RigidTransform& pose : poses->poses) {
            PROXIMA_CHECK(pose.translation.allFinite());
            const Mat3 turned_back = pose.rotation.transpose() * pose.rotation;
            PROXIMA_CHECK_LE((turned_back - Mat3::Identity()).norm(), 1e-9);
            PROXIMA_CHECK_GT(pose.rotation.determinant(), 0.5);
        }
    }
    return 0;
}
