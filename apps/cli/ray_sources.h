// Where the rays of proxima raycast come from: a file, or a camera in front of the model.
#pragma once

#include "cli/camera.h"
#include "cli/session.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace proxima {

/// Rays of a table ox,oy,oz,dx,dy,dz or ox,oy,oz,dx,dy,dz,tmin,tmax. Errors as read_number_table,
/// and invalid_argument for a row that is no ray.
[[nodiscard]] Result<std::vector<Ray>> read_rays(const std::string& path, Session& session);

/// The same, of the command line.
[[nodiscard]] Result<std::vector<Ray>> parse_rays(std::span<const std::string> rays);

/// Rays by number: those of a file, or a camera's, which are made when they are asked for.
class RayList {
public:
    RayList() = default;
    explicit RayList(std::vector<Ray> rays) : rays_(std::move(rays)), count_(rays_.size()) {}

    /// One ray per pixel, row by row from the top, through its middle. Directions have length 1.
    RayList(const OrbitCamera& camera, ViewSize size);

    [[nodiscard]] std::size_t count() const noexcept { return count_; }

    /// \pre number < count()
    [[nodiscard]] Ray operator[](std::size_t number) const noexcept;

private:
    std::vector<Ray> rays_; ///< of a file
    std::size_t count_ = 0;
    std::optional<View> view_;
    std::size_t width_ = 0;
};

} // namespace proxima
