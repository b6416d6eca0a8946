#include "c/handles.h"

#include "base/text.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace proxima::c {
namespace {

// A failure for want of memory must not need any, so its message is not copied.
thread_local std::string last_text;
thread_local const char* last_message = "";

void keep(const char* message) noexcept
{
    last_message = message;
}

void keep(std::string&& text) noexcept
{
    last_text = std::move(text);
    last_message = last_text.c_str();
}

constexpr std::int32_t most_threads = 1024;

static_assert(static_cast<int>(ErrorCode::invalid_argument) + 1 == PROXIMA_INVALID_ARGUMENT);
static_assert(static_cast<int>(ErrorCode::malformed_file) + 1 == PROXIMA_MALFORMED_FILE);
static_assert(static_cast<int>(ErrorCode::cancelled) + 1 == PROXIMA_CANCELLED);

// Packed arrays of C are read as the library's own types.
static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));

} // namespace

proxima_status failed(const Error& error) noexcept
{
    return guarded([&] {
        std::string line = describe(error);
        std::ranges::replace(line, '\n', ' '); // of a file's name
        keep(std::move(line));
        return static_cast<proxima_status>(static_cast<int>(error.code) + 1);
    });
}

proxima_status failed_by_exception() noexcept
{
    try {
        throw;
    } catch (const std::bad_alloc&) {
        keep("out of memory");
        return PROXIMA_OUT_OF_MEMORY;
    } catch (const std::length_error&) {
        keep("a count is larger than any memory");
        return PROXIMA_OUT_OF_MEMORY;
    } catch (const std::exception&) {
        keep("an error that the library did not expect");
        return PROXIMA_INTERNAL_ERROR;
    }
}

proxima_status check_count(std::size_t count, std::size_t most, const char* limit) noexcept
{
    if (count <= most) return PROXIMA_OK;
    return guarded([&] {
        return failed({ErrorCode::limit_exceeded, concat(limit, ", not ", count), {}});
    });
}

proxima_status refused(const char* message) noexcept
{
    keep(message);
    return PROXIMA_INVALID_ARGUMENT;
}

std::optional<Execution> execution_of(const proxima_execution* execution) noexcept
{
    if (execution == nullptr) return Execution{};
    if (execution->threads < 0 || execution->threads > most_threads) {
        refused("threads: must be from 0 to 1024; 0 is all of the machine");
        return {};
    }
    return Execution{.threads = {execution->threads},
                     .progress =
                         execution->progress != nullptr ? &execution->progress->progress : nullptr,
                     .budget = {execution->budget_bytes}};
}

std::span<const Vec3> points_of(const double* points, std::size_t count)
{
    if (count > std::size_t{PTRDIFF_MAX} / sizeof(Vec3)) throw std::length_error("points");
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): asserted above
    return {reinterpret_cast<const Vec3*>(points), count};
}

Result<RigidTransform> pose_of(const double* matrix)
{
    if (matrix == nullptr) return RigidTransform{};
    return make_rigid_transform(std::span<const double, 12>(matrix, 12));
}

} // namespace proxima::c

uint32_t proxima_c_version()
{
    return PROXIMA_C_VERSION;
}

const char* proxima_version()
{
    return PROXIMA_VERSION_TEXT;
}

const char* proxima_error_message()
{
    return proxima::c::last_message;
}

proxima_status proxima_progress_create(proxima_progress** progress)
{
    using namespace proxima::c;
    if (any_null(progress)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        *progress = new proxima_progress;
        return PROXIMA_OK;
    });
}

void proxima_progress_destroy(proxima_progress* progress)
{
    delete progress;
}

void proxima_progress_cancel(proxima_progress* progress)
{
    if (progress != nullptr) progress->progress.cancel();
}

double proxima_progress_fraction(const proxima_progress* progress)
{
    return progress != nullptr ? progress->progress.fraction() : 0;
}

const char* proxima_progress_stage(const proxima_progress* progress)
{
    return progress != nullptr ? progress->progress.stage() : "";
}
