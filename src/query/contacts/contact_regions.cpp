#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "geometry/length.h"
#include "proxima/contacts.h"
#include "query/contact/find_pairs.h"
#include "query/contacts/contact_lines.h"
#include "query/contacts/meeting_triangles.h"
#include "query/contacts/solid_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// A region's contour, summed up.
struct RegionSums {
    Vec3 weighted = Vec3::Zero(); ///< middles of segments times lengths, from the first point
    Vec3 from_surfaces = Vec3::Zero();
    double length = 0;
    bool is_flush = false; ///< somewhere the surfaces are parallel, as where faces share a plane
};

constexpr double parallel_faces = 1 - 1e-6; ///< of normals' product: in one plane, or as good as

class RegionMaker {
public:
    RegionMaker(const Solid& a, const Solid& b, const RigidTransform& pose_b,
                const IntersectionContour& contour, Progress* progress)
        : a_(a.parts()), b_(b.parts()), pose_(pose_b), lines_(a.parts(), b.parts(), pose_b),
          contour_(contour), progress_(progress)
    {}

    /// One step of the stage. Of no use where the progress asks to stop.
    ContactRegion make(std::span<const std::size_t> numbers)
    {
        ContactRegion region;
        const Vec3 first = contour_.points[contour_.lines[numbers.front()].first].position;
        const RegionSums sums = sum_up(numbers, first);
        region.length = sums.length;
        region.position = first;
        if (sums.length > 0) region.position += sums.weighted / sums.length;
        const Vec3 area = vector_area(numbers, sums.from_surfaces);
        region.area = length_of(area);
        region.normal = normal_of(area, sums);
        straighten(region);
        add_points(region, numbers);
        advance_stage(progress_, 1);
        return sums.is_flush ? least_deep(region, numbers) : region;
    }

private:
    /// Visits the segments (from, to) of a line, the closing one included.
    template <class Visit>
    void visit_segments(std::size_t number, Visit visit) const
    {
        const ContourLine& line = contour_.lines[number];
        const auto points = contour_.points_of(line);
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
            visit(points[i].position, points[i + 1].position);
        if (line.closed && points.size() > 1)
            visit(points.back().position, points.front().position);
    }

    RegionSums sum_up(std::span<const std::size_t> numbers, const Vec3& first)
    {
        RegionSums sums;
        for (const std::size_t number : numbers) {
            visit_segments(number, [&](const Vec3& from, const Vec3& to) {
                const double length = length_of(to - from);
                const Vec3 middle = 0.5 * (from - first) + 0.5 * (to - first);
                sums.length += length;
                sums.weighted += length * middle;
                const SurfaceNormals normals = lines_.surfaces_at(first + middle);
                sums.from_surfaces += length * normals.apart();
                if (std::abs(normals.of_a.dot(normals.of_b)) > parallel_faces) sums.is_flush = true;
            });
        }
        if (sums.length == 0) sums.from_surfaces = lines_.surfaces_at(first).apart();
        return sums;
    }

    /// Loops are turned the way that surfaces face.
    [[nodiscard]] Vec3 vector_area(std::span<const std::size_t> numbers, const Vec3& outward) const
    {
        Vec3 sum = Vec3::Zero();
        for (const std::size_t number : numbers) {
            const ContourLine& line = contour_.lines[number];
            if (!line.closed) continue;
            const Vec3 first = contour_.points[line.first].position;
            Vec3 area = Vec3::Zero();
            visit_segments(number, [&](const Vec3& from, const Vec3& to) {
                area += 0.5 * (from - first).cross(to - first);
            });
            sum += area.dot(outward) < 0 ? Vec3(-area) : area;
        }
        return sum;
    }

    static Vec3 normal_of(const Vec3& area, const RegionSums& sums)
    {
        constexpr double thin = 1e-6; // of the square of the length: no plane can be told
        if (length_of(area) > thin * sums.length * sums.length) return unit_of(area);
        const Vec3 normal = unit_of(sums.from_surfaces);
        return normal.squaredNorm() > 0.5 ? normal : Vec3(Vec3::UnitZ());
    }

    /// Where the faces at both ends of the middle line are parallel, as those of boxes are, their normal
    /// is the region's: the contour may run along slanting sides.
    void straighten(ContactRegion& region) const
    {
        const auto line = lines_.line_through(region.position, region.normal, region.length);
        if (!line) return;
        const Vec3 of_a = lines_.surfaces_at(line->on_a).of_a;
        const Vec3 of_b = lines_.surfaces_at(line->on_b).of_b;
        constexpr double parallel = -1 + 1e-6;
        constexpr double aligned = 0.9;
        if (of_a.dot(of_b) < parallel && of_a.dot(region.normal) > aligned)
            region.normal = (of_a - of_b).normalized();
    }

    /// At most some dozens of the contour's points: evenly, and those that reach farthest.
    [[nodiscard]] std::vector<Vec3> chosen_points(const ContactRegion& region,
                                                  std::span<const std::size_t> numbers) const
    {
        std::vector<Vec3> all;
        for (const std::size_t number : numbers) {
            for (const ContourPoint& point : contour_.points_of(contour_.lines[number]))
                all.push_back(point.position);
        }
        constexpr std::size_t most = 16;
        if (all.size() <= most) return all;
        std::vector<Vec3> chosen;
        for (std::size_t i = 0; i < most; ++i) chosen.push_back(all[i * all.size() / most]);
        const Vec3 u = region.normal.unitOrthogonal();
        const Vec3 v = region.normal.cross(u);
        constexpr int sides = 8;
        for (int side = 0; side < sides; ++side) {
            const double turn = 2 * std::numbers::pi * side / sides;
            const Vec3 direction = std::cos(turn) * u + std::sin(turn) * v;
            chosen.push_back(*std::ranges::max_element(
                all, {}, [&](const Vec3& p) { return direction.dot(p - region.position); }));
        }
        return chosen;
    }

    void add_points(ContactRegion& region, std::span<const std::size_t> numbers)
    {
        const std::vector<Vec3> around = chosen_points(region, numbers);
        std::vector<RegionPoint> found;
        const auto look_at = [&](const Vec3& p) {
            if (const auto line = lines_.line_through(p, region.normal, region.length))
                found.push_back(*line);
        };
        look_at(region.position);
        for (const Vec3& p : around) {
            if (region.length == 0) break; // a point
            for (const double part : {0.984375, 0.5})
                look_at(region.position + part * (p - region.position));
            // Into both, for contours that go round a hole.
            const Vec3 inward = lines_.surfaces_at(p).inward();
            for (const double part : {0x1p-20, 0x1p-8}) look_at(p + part * region.length * inward);
        }
        if (!found.empty()) {
            const auto deepest = std::ranges::max_element(found, {}, &RegionPoint::depth);
            std::iter_swap(found.begin(), deepest);
            found.push_back(found.front());
            if (region.length > 0) found.front() = climb(found.front(), region);
            region.depth = found.front().depth;
        } else { // they only touch
            for (const Vec3& p : around) found.push_back({p, p, 0});
        }
        reduce(found, region);
    }

    /// From the deepest line to deeper ones beside it.
    RegionPoint climb(const RegionPoint& start, const ContactRegion& region)
    {
        const Vec3 u = region.normal.unitOrthogonal();
        const Vec3 v = region.normal.cross(u);
        double turn = 0;
        RegionPoint best = start;
        constexpr double first = 0x1p-4;
        constexpr double last = 0x1p-12;
        constexpr int most_rounds = 256;
        // Then steps grow: where a body only peeps out of another one, the contour is tiny beside them.
        constexpr int alike = 16;
        double part = first;
        int rising = 0;
        for (int round = 0; part > last && round < most_rounds; ++round) {
            bool better = false;
            // Other directions each time: the deepest lines may be along a ridge.
            turn += std::numbers::phi;
            constexpr int sides = 6;
            for (int i = 0; i < sides; ++i) {
                const double angle = turn + 2 * std::numbers::pi * i / sides;
                const Vec3 side = std::cos(angle) * u + std::sin(angle) * v;
                const Vec3 middle = 0.5 * best.on_a + 0.5 * best.on_b;
                const auto line = lines_.line_through(middle + part * region.length * side,
                                                      region.normal, region.length);
                if (!line || !(line->depth > best.depth)) continue;
                best = *line;
                better = true;
            }
            rising = better ? rising + 1 : 0;
            if (!better) part *= 0.5;
            if (rising > alike) part *= 2;
        }
        return best;
    }

    /// The deepest one first; then the farthest from it, from the line, and the largest quadrilateral.
    static void reduce(std::span<const RegionPoint> found, ContactRegion& region)
    {
        const auto flat = [&](const RegionPoint& p) {
            const Vec3 from = 0.5 * (p.on_a - region.position) + 0.5 * (p.on_b - region.position);
            return Vec3(from - region.normal.dot(from) * region.normal);
        };
        const double least = 1e-9 * region.length; // closer ones are one
        const auto add_best = [&](const auto& measure, double above) {
            const RegionPoint* best = nullptr;
            double most = above;
            for (const RegionPoint& point : found) {
                const double value = measure(point);
                if (!(value > most)) continue;
                most = value;
                best = &point;
            }
            if (best != nullptr) region.points[region.point_count++] = *best;
            return best != nullptr;
        };
        // The farthest out of those that are as deep, as where faces are parallel.
        constexpr double as_deep = 1 - 0x1p-20;
        add_best(
            [&](const RegionPoint& p) {
                return p.depth >= as_deep * region.depth ? length_of(flat(p)) : -1.0;
            },
            -1);
        const Vec3 p0 = flat(region.points[0]);
        if (!add_best([&](const RegionPoint& p) { return length_of(flat(p) - p0); }, least)) return;
        const Vec3 p1 = flat(region.points[1]);
        const Vec3 along = unit_of(p1 - p0);
        const auto beside = [&](const Vec3& p) { return along.cross(p - p0).dot(region.normal); };
        if (!add_best([&](const RegionPoint& p) { return std::abs(beside(flat(p))); }, least))
            return;
        // Beyond one of the triangle's three sides: what it adds to the area.
        std::array<Vec3, 3> corner = {p0, p1, flat(region.points[2])};
        if (beside(corner[2]) < 0) std::swap(corner[1], corner[2]);
        add_best(
            [&](const RegionPoint& point) {
                const Vec3 p = flat(point);
                double most = 0;
                for (std::size_t i = 0; i < 3; ++i) {
                    const Vec3 side = corner[(i + 1) % 3] - corner[i];
                    most = std::max(most, -side.cross(p - corner[i]).dot(region.normal));
                }
                return most;
            },
            least * region.length);
    }

    /// Where faces share a plane, the contour runs round what they share and says little about the
    /// normal. Of all pairs of faces there that look at each other, and of the normal found without them,
    /// the one of the least depth.
    ContactRegion least_deep(const ContactRegion& plain, std::span<const std::size_t> numbers)
    {
        ContactRegion best = plain;
        for (const Vec3& normal : facing_normals(plain, numbers)) {
            ContactRegion region = plain;
            region.normal = normal;
            region.point_count = 0;
            region.depth = 0;
            add_points(region, numbers);
            if (region.depth < best.depth) best = region;
        }
        return best;
    }

    /// Normals of A's faces at the region that B's faces there look at.
    std::vector<Vec3> facing_normals(const ContactRegion& region,
                                     std::span<const std::size_t> numbers)
    {
        std::vector<Vec3> points;
        for (const std::size_t number : numbers) {
            for (const ContourPoint& point : contour_.points_of(contour_.lines[number]))
                points.push_back(point.position);
        }
        if (!meeting_a_) find_meeting_triangles();
        const double near = 1e-9 * region.length;
        const MeetingTriangles::Found found_a = meeting_a_->near_points(points, near);
        const MeetingTriangles::Found found_b = meeting_b_->near_points(points, near);
        constexpr std::size_t most = 1 << 22; // of both: where faces are flush, regions are simple
        if (points.size() * std::min(found_a.pairs, found_b.pairs) > most) return {};
        const std::vector<Vec3> of_a = different_normals(found_a.triangles);
        const std::vector<Vec3> of_b = different_normals(found_b.triangles);
        std::vector<Vec3> facing;
        for (const Vec3& u : of_a) {
            for (const Vec3& v : of_b)
                if (u.dot(v) < -parallel_faces) facing.push_back((u - v).normalized());
        }
        return facing;
    }

    void find_meeting_triangles()
    {
        const double reach = a_.largest + b_.largest + pose_.translation.cwiseAbs().maxCoeff();
        meeting_a_.emplace(a_, std::nullopt, reach);
        meeting_b_.emplace(b_, pose_, reach);
        for (const TrianglePair& pair : find_pairs(a_.index, b_.index, pose_, progress_)) {
            meeting_a_->add(pair.a);
            meeting_b_->add(pair.b);
        }
    }

    static std::vector<Vec3> different_normals(std::span<const Triangle> triangles)
    {
        std::vector<Vec3> normals;
        for (const Triangle& t : triangles) {
            const Vec3 normal = unit_normal({t[0], t[1]}, {t[0], t[2]});
            const bool is_new = std::ranges::none_of(
                normals, [&](const Vec3& other) { return other.dot(normal) > parallel_faces; });
            if (is_new) normals.push_back(normal);
        }
        return normals;
    }

    const SolidParts& a_;
    const SolidParts& b_;
    RigidTransform pose_;
    ContactLines lines_;
    const IntersectionContour& contour_;
    Progress* progress_;
    std::optional<MeetingTriangles> meeting_a_; ///< where some faces are flush
    std::optional<MeetingTriangles> meeting_b_;
};

/// The lines of the contour by what they are joined to, in their order.
std::vector<std::vector<std::size_t>> joined_lines(const IntersectionContour& contour)
{
    struct End {
        SurfacePart on_a;
        SurfacePart on_b;
        std::size_t line;
    };
    std::vector<End> ends;
    for (std::size_t i = 0; i < contour.lines.size(); ++i) {
        for (const ContourPoint& point : contour.points_of(contour.lines[i]))
            ends.push_back({point.on_a, point.on_b, i});
    }
    const auto key = [](const End& end) { return std::tuple(end.on_a, end.on_b); };
    std::ranges::sort(ends, [&](const End& a, const End& b) {
        return std::tuple(key(a), a.line) < std::tuple(key(b), b.line);
    });
    DisjointSets sets(contour.lines.size());
    for (std::size_t i = 1; i < ends.size(); ++i) {
        if (key(ends[i - 1]) != key(ends[i])) continue;
        sets.unite(static_cast<std::uint32_t>(ends[i - 1].line),
                   static_cast<std::uint32_t>(ends[i].line));
    }
    std::vector<std::vector<std::size_t>> regions;
    std::vector<std::size_t> region_of(contour.lines.size(), contour.lines.size());
    for (std::size_t i = 0; i < contour.lines.size(); ++i) {
        std::size_t& region = region_of[sets.find(static_cast<std::uint32_t>(i))];
        if (region == contour.lines.size()) {
            region = regions.size();
            regions.emplace_back();
        }
        regions[region].push_back(i);
    }
    return regions;
}

} // namespace

Result<ContactRegions> contact_regions(const Solid& a, const Solid& b, const RigidTransform& pose_b,
                                       const ContactRegionOptions& options)
{
    if (Status status = check_pose(pose_b); !status) return tl::unexpected(status.error());
    Progress* const progress = options.execution.progress;
    const auto stopped = [] { return cancelled("finding contact regions"); };
    if (is_cancelled(progress)) return stopped();
    auto contour = intersection_contour(a.index(), b.index(), pose_b, {options.execution});
    if (!contour) return stopped();
    ContactRegions found;
    found.contour = std::move(*contour);
    RegionMaker maker(a, b, pose_b, found.contour, progress);
    const auto joined = joined_lines(found.contour);
    begin_stage(progress, "measuring contact regions", 2 * joined.size());
    for (const auto& numbers : joined) {
        if (is_cancelled(progress)) return stopped();
        ContactRegion region = maker.make(numbers);
        if (is_cancelled(progress)) return stopped();
        region.first_line = found.lines.size();
        region.line_count = numbers.size();
        found.lines.insert(found.lines.end(), numbers.begin(), numbers.end());
        found.regions.push_back(region);
        advance_stage(progress, 1);
    }
    return found;
}

} // namespace proxima
