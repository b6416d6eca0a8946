#include "haptics/proxy/free_position.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace proxima {

namespace {

constexpr double a_little_more = 1 + 0x1p-20;

/// Directions spread about evenly over the sphere, along a spiral.
constexpr int directions = 32;

Vec3 direction(int i) noexcept
{
    const double z = 1 - (2 * i + 1.0) / directions;
    const double aside = std::sqrt(1 - z * z);
    const double turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    return {aside * std::cos(turn), aside * std::sin(turn), z};
}

/// Searches for the nearest position.
class FreePositionSearch {
public:
    FreePositionSearch(const ContactSurface& surface, double radius, Vec3 p,
                       SlideScratch& scratch) noexcept
        : surface_(surface), radius_(radius), gap_(safety_gap(surface.scale())), p_(std::move(p)),
          scratch_(scratch)
    {}

    std::optional<Vec3> run() noexcept
    {
        if (is_free(p_)) return p_;
        push();
        constexpr std::array shells = {0.5, 1.0, 1.5, 2.0, 3.0, free_position_radii};
        for (const double shell : shells) {
            // Farther shells are seldom nearer after a slide.
            if (reachable_.found) break;
            for (int i = 0; i < directions; ++i) try_candidate(p_ + shell * radius_ * direction(i));
        }
        if (reachable_.found) return reachable_.position;
        if (other_.found) return other_.position;
        return std::nullopt;
    }

private:
    struct Best {
        bool found = false;
        Vec3 position = Vec3::Zero();
        double distance = std::numeric_limits<double>::infinity();
    };

    [[nodiscard]] bool is_free(const Vec3& p) const noexcept
    {
        return surface_.clearance_beyond(p, radius_) > radius_;
    }

    /// Moves away from the nearest triangle until nothing is near, or the attempts end.
    void push() noexcept
    {
        constexpr int attempts = 16;
        Vec3 position = p_;
        for (int attempt = 0; attempt < attempts; ++attempt) {
            const auto near = nearest_contact(surface_, position, radius_, scratch_);
            if (!near) break;
            position = near->point + near->normal * (radius_ * a_little_more);
        }
        try_candidate(position);
    }

    /// Slides a free candidate as near to p as it comes, and keeps the best.
    void try_candidate(const Vec3& position) noexcept
    {
        if ((position - p_).norm() > free_position_radii * radius_ * a_little_more ||
            !is_free(position))
            return;
        const SlideResult slide = slide_sphere(surface_, radius_, position, p_, scratch_);
        const double distance = (slide.center - p_).norm();
        Best& best = is_reachable_from(slide.center) ? reachable_ : other_;
        if (distance < best.distance) best = {true, slide.center, distance};
    }

    /// Whether a point that moves from the position to p arrives there or just before.
    [[nodiscard]] bool is_reachable_from(const Vec3& position) noexcept
    {
        const SlideResult slide = slide_sphere(surface_, 0, position, p_, scratch_);
        return (slide.center - p_).norm() <= 4 * gap_;
    }

    const ContactSurface& surface_;
    double radius_;
    double gap_;
    Vec3 p_;
    SlideScratch& scratch_;
    Best reachable_;
    Best other_;
};

} // namespace

std::optional<Vec3> find_free_position(const ContactSurface& surface, double radius, const Vec3& p,
                                       SlideScratch& scratch) noexcept
{
    return FreePositionSearch(surface, radius, p, scratch).run();
}

} // namespace proxima
