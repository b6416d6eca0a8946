#include "haptics/proxy/free_place.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace proxima {

namespace {

constexpr double a_little_more = 1 + 0x1p-20;

/// Directions all round, about evenly: along a spiral.
constexpr int directions = 32;

Vec3 direction(int i) noexcept
{
    const double z = 1 - (2 * i + 1.0) / directions;
    const double aside = std::sqrt(1 - z * z);
    const double turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    return {aside * std::cos(turn), aside * std::sin(turn), z};
}

/// Looks about for the nearest place.
class FreePlaceSearch {
public:
    FreePlaceSearch(const ContactSurface& surface, double radius, Vec3 p,
                    SlideScratch& scratch) noexcept
        : surface_(surface), radius_(radius), gap_(safety_gap(surface.scale())), p_(std::move(p)),
          scratch_(scratch)
    {}

    std::optional<Vec3> run() noexcept
    {
        if (is_free(p_)) return p_;
        push();
        constexpr std::array shells = {0.5, 1.0, 1.5, 2.0, 3.0, free_place_radii};
        for (const double shell : shells) {
            // Farther shells end nearer only by a slide past what is between: leave them out.
            if (seen_.found) break;
            for (int i = 0; i < directions; ++i) look_at(p_ + shell * radius_ * direction(i));
        }
        if (seen_.found) return seen_.place;
        if (hidden_.found) return hidden_.place;
        return std::nullopt;
    }

private:
    struct Best {
        bool found = false;
        Vec3 place = Vec3::Zero();
        double distance = std::numeric_limits<double>::infinity();
    };

    [[nodiscard]] bool is_free(const Vec3& p) const noexcept
    {
        return surface_.clearance_beyond(p, radius_) > radius_;
    }

    /// Away from the nearest triangle until nothing is near, or it goes to and fro.
    void push() noexcept
    {
        constexpr int attempts = 16;
        Vec3 place = p_;
        for (int attempt = 0; attempt < attempts; ++attempt) {
            const auto near = nearest_contact(surface_, place, radius_, scratch_);
            if (!near) break;
            place = near->point + near->normal * (radius_ * a_little_more);
        }
        look_at(place);
    }

    /// A candidate: as near to p as it comes by sliding.
    void look_at(const Vec3& place) noexcept
    {
        if ((place - p_).norm() > free_place_radii * radius_ * a_little_more || !is_free(place))
            return;
        const SlideResult slide = slide_sphere(surface_, radius_, place, p_, scratch_);
        const double distance = (slide.center - p_).norm();
        Best& best = is_seen(slide.center) ? seen_ : hidden_;
        if (distance < best.distance) best = {true, slide.center, distance};
    }

    /// Whether a point that goes from there to p gets there, or just before it.
    [[nodiscard]] bool is_seen(const Vec3& place) noexcept
    {
        const SlideResult slide = slide_sphere(surface_, 0, place, p_, scratch_);
        return (slide.center - p_).norm() <= 4 * gap_;
    }

    const ContactSurface& surface_;
    double radius_;
    double gap_;
    Vec3 p_;
    SlideScratch& scratch_;
    Best seen_;
    Best hidden_;
};

} // namespace

std::optional<Vec3> find_free_place(const ContactSurface& surface, double radius, const Vec3& p,
                                    SlideScratch& scratch) noexcept
{
    return FreePlaceSearch(surface, radius, p, scratch).run();
}

} // namespace proxima
