#include "proxima/intersect_meshes.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_intersection.h"
#include "index/index_parts.h"
#include "query/contact/contact_search.h"
#include "query/contact/join_segments.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

namespace proxima {
namespace {

constexpr const char* contour_stage = "finding the intersection contour";

/// Calls visit(pair) for each; false, and soon, where the progress asks to stop.
template <class Visit>
bool for_each_pair(std::span<const TrianglePair> pairs, const Progress* progress,
                   const Visit& visit)
{
    constexpr std::size_t block = 4096;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (i % block == 0 && is_cancelled(progress)) return false;
        visit(pairs[i]);
    }
    return !is_cancelled(progress);
}

/// The triangles of a mesh that meet another's.
class TrianglesOfMesh {
public:
    explicit TrianglesOfMesh(const TriangleMesh& mesh) : mesh_(mesh) {}

    [[nodiscard]] TriangleCorners corners(TriangleId id) const
    {
        return mesh_.triangles()[to_index(id)];
    }
    [[nodiscard]] Triangle triangle(TriangleId id) const { return mesh_.triangle(id); }

    /// The positions of vertices of these triangles, whose ids ascend.
    [[nodiscard]] std::vector<Vec3> positions(std::span<const std::uint32_t> vertices) const
    {
        std::vector<Vec3> positions;
        positions.reserve(vertices.size());
        for (const std::uint32_t id : vertices) positions.push_back(mesh_.positions()[id]);
        return positions;
    }

private:
    const TriangleMesh& mesh_;
};

/// Like TrianglesOfMesh, copied from rows of an index.
class TrianglesOfRows {
public:
    TrianglesOfRows(const IndexParts& index, std::vector<std::uint32_t> rows)
    {
        std::ranges::sort(rows);
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        copy(index.float_rows(), rows);
        copy(index.double_rows(), rows);
        std::ranges::sort(copies_, {}, &Copy::id);
    }

    [[nodiscard]] TriangleCorners corners(TriangleId id) const { return find(id).vertices; }
    [[nodiscard]] Triangle triangle(TriangleId id) const { return find(id).triangle; }

    [[nodiscard]] std::vector<Vec3> positions(std::span<const std::uint32_t> vertices) const
    {
        std::vector<Vec3> positions(vertices.size());
        for (const Copy& copy : copies_) {
            for (std::size_t i = 0; i < 3; ++i) {
                const auto at = std::ranges::lower_bound(vertices, copy.vertices[i]);
                positions[static_cast<std::size_t>(at - vertices.begin())] =
                    copy.triangle.vertices[i];
            }
        }
        return positions;
    }

private:
    struct Copy {
        TriangleId id;
        TriangleCorners vertices;
        Triangle triangle;
    };

    template <class Row>
    void copy(std::span<const Row> all, const std::vector<std::uint32_t>& rows)
    {
        if (all.empty()) return;
        for (const std::uint32_t row : rows) {
            const auto& [first, second, third] = all[row].vertices;
            copies_.push_back(
                {TriangleId{all[row].triangle_id()}, {first, second, third}, all[row].corners()});
        }
    }
    [[nodiscard]] const Copy& find(TriangleId id) const
    {
        return *std::ranges::lower_bound(copies_, id, {}, &Copy::id);
    }

    std::vector<Copy> copies_; ///< by id
};

SurfacePart vertex_part(std::uint32_t id)
{
    return {FeatureKind::vertex, {id, id}};
}
SurfacePart edge_part(std::uint32_t a, std::uint32_t b)
{
    return {FeatureKind::edge, {std::min(a, b), std::max(a, b)}};
}

/// The triangles' vertices with those that the pose moves to one position made one, and triangles by
/// these. Of no use where the progress asks to stop.
template <class Triangles>
class SharedVertices {
public:
    template <class TriangleOf>
    SharedVertices(const Triangles& triangles, const RigidTransform& pose,
                   std::span<const TrianglePair> pairs, const TriangleOf& triangle_of,
                   const Progress* progress)
        : triangles_(triangles)
    {
        const auto add_corners = [&](const TrianglePair& pair) {
            for (const std::uint32_t corner : triangles.corners(triangle_of(pair)))
                ids_.push_back(corner);
        };
        if (!for_each_pair(pairs, progress, add_corners)) return;
        std::ranges::sort(ids_);
        ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
        std::vector<Vec3> positions = triangles.positions(ids_);
        for (Vec3& p : positions) p = pose(p);
        std::vector<std::uint32_t> by_position(ids_.size()); // ranks of ids
        for (std::uint32_t i = 0; i < by_position.size(); ++i) by_position[i] = i;
        const auto position = [&](std::uint32_t rank) {
            const Vec3& p = positions[rank];
            return std::tuple(p.x(), p.y(), p.z());
        };
        std::ranges::stable_sort(by_position, {}, position);
        first_.resize(ids_.size());
        for (std::size_t i = 0, first = 0; i < by_position.size(); ++i) {
            if (position(by_position[i]) != position(by_position[first])) first = i;
            first_[by_position[i]] = ids_[by_position[first]];
        }
        const auto add_name = [&](const TrianglePair& pair) {
            by_corners_.push_back(named(triangle_of(pair)));
        };
        if (for_each_pair(pairs, progress, add_name)) std::ranges::sort(by_corners_);
    }

    /// Of the triangles with the same corners the lowest.
    [[nodiscard]] TriangleId first_like(TriangleId triangle) const
    {
        const NamedTriangle wanted = {named(triangle).first, TriangleId{0}};
        return std::ranges::lower_bound(by_corners_, wanted)->second;
    }

    [[nodiscard]] TriangleCorners corners(TriangleId triangle) const
    {
        TriangleCorners corners = triangles_.corners(triangle);
        for (std::uint32_t& corner : corners) corner = first_[rank(corner)];
        return corners;
    }

    [[nodiscard]] SurfacePart part(TriangleId triangle, TrianglePart part) const
    {
        if (part == TrianglePart::inside)
            return {FeatureKind::face, {to_index(triangle), to_index(triangle)}};
        const auto corner = corners(triangle);
        const auto number = static_cast<std::size_t>(number_of(part));
        return is_corner(part) ? vertex_part(corner[number])
                               : edge_part(corner[number], corner[(number + 1) % 3]);
    }

private:
    using NamedTriangle = std::pair<TriangleCorners, TriangleId>; ///< corners ascend

    [[nodiscard]] NamedTriangle named(TriangleId triangle) const
    {
        TriangleCorners sorted = corners(triangle);
        std::ranges::sort(sorted);
        return {sorted, triangle};
    }

    [[nodiscard]] std::size_t rank(std::uint32_t id) const
    {
        return static_cast<std::size_t>(std::ranges::lower_bound(ids_, id) - ids_.begin());
    }

    const Triangles& triangles_;
    std::vector<std::uint32_t> ids_;
    std::vector<std::uint32_t> first_; ///< by rank of the id
    std::vector<NamedTriangle> by_corners_;
};

/// \pre both have an area, or what is said does not matter
bool are_in_one_plane(const Triangle& a, const Triangle& b) noexcept
{
    return std::ranges::all_of(
        b.vertices, [&](const Vec3& corner) { return orient3d(a[0], a[1], a[2], corner) == 0; });
}

/// The ends of segments by name, and which ones each segment joins.
template <class Triangles>
class ContourMaker {
public:
    ContourMaker(const Triangles& a, const Triangles& b, const RigidTransform& pose_b,
                 std::span<const TrianglePair> pairs, Progress* progress)
        : a_(a), b_(b), pose_b_(pose_b), progress_(progress),
          vertices_a_(
              a, {}, pairs, [](const TrianglePair& pair) { return pair.a; }, progress),
          vertices_b_(
              b, pose_b, pairs, [](const TrianglePair& pair) { return pair.b; }, progress)
    {
        // Triangles that lie on each other meet the same ones in the same points: once is enough.
        const auto add_once = [&](const TrianglePair& pair) {
            pairs_.push_back({vertices_a_.first_like(pair.a), vertices_b_.first_like(pair.b)});
        };
        if (!for_each_pair(pairs, progress, add_once)) return;
        std::ranges::sort(pairs_);
        pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
    }

    /// Nothing where the progress asks to stop.
    [[nodiscard]] std::optional<IntersectionContour> contour()
    {
        if (is_cancelled(progress_)) return std::nullopt;
        StageSteps steps(progress_, contour_stage, pairs_.size());
        for (const TrianglePair& pair : pairs_) {
            add(pair);
            if (!steps.done(1)) return std::nullopt;
        }
        if (is_cancelled(progress_)) return std::nullopt;
        number_ends();
        if (is_cancelled(progress_)) return std::nullopt;
        std::vector<SegmentEnds> borders = renumbered(borders_);
        std::ranges::sort(borders);
        std::vector<SegmentEnds> segments = renumbered(segments_);
        for (const SegmentEnds& touch : renumbered(touches_)) {
            if (!std::ranges::binary_search(borders, touch)) segments.push_back(touch);
        }
        // Ends of polygons that have sides in common belong together.
        DisjointSets areas(ends_.size());
        for (const SegmentEnds& side : borders) areas.unite(side[0], side[1]);
        borders = odd_ones(borders);
        segments.insert(segments.end(), borders.begin(), borders.end());
        std::vector<bool> has_lines(ends_.size()); // by area
        for (const SegmentEnds& ends : segments) {
            if (ends[0] == ends[1]) continue;
            for (const std::uint32_t end : ends) has_lines[areas.find(end)] = true;
        }
        if (is_cancelled(progress_)) return std::nullopt;
        IntersectionContour result;
        for (const JoinedLine& line : join_segments(ends_.size(), std::move(segments))) {
            // A point without a segment within an area that has a border.
            if (line.points.size() == 1 && has_lines[areas.find(line.points[0])]) continue;
            result.lines.push_back({result.points.size(), line.points.size(), line.closed});
            for (const std::uint32_t end : line.points) result.points.push_back(ends_[end]);
        }
        return result;
    }

private:
    struct Crossing {
        TrianglePair pair;
        Triangle a;
        Triangle b;
    };

    void add(const TrianglePair& pair)
    {
        const Crossing crossing = {pair, a_.triangle(pair.a), pose_b_(b_.triangle(pair.b))};
        const TriangleIntersection found = intersect(crossing.a, crossing.b);
        const std::size_t first = ends_.size();
        for (const MeetingParts& parts : found.ends()) add_end(crossing, parts);
        const auto end = [&](std::size_t i) {
            return static_cast<std::uint32_t>(first + i % found.size());
        };
        if (found.size() == 1) bridge(crossing, found.ends()[0], end(0));
        if (found.size() == 2) {
            auto& list = are_in_one_plane(crossing.a, crossing.b) ? touches_ : segments_;
            list.push_back({end(0), end(1)});
        }
        for (std::size_t i = 0; found.size() > 2 && i < found.size(); ++i)
            borders_.push_back({end(i), end(i + 1)});
    }

    void add_end(const Crossing& crossing, const MeetingParts& parts)
    {
        ends_.push_back({meeting_point(crossing.a, crossing.b, parts),
                         vertices_a_.part(crossing.pair.a, parts.of_a),
                         vertices_b_.part(crossing.pair.b, parts.of_b)});
    }

    /// A triangle without an area crosses a plane once, on its long side and on a short one: a
    /// segment without a length joins what its neighbours have on either side.
    void bridge(const Crossing& crossing, const MeetingParts& parts, std::uint32_t end)
    {
        const bool a_is_flat = is_degenerate(crossing.a);
        if (a_is_flat == is_degenerate(crossing.b)) return;
        const Triangle& flat = a_is_flat ? crossing.a : crossing.b;
        const Triangle& other = a_is_flat ? crossing.b : crossing.a;
        const TrianglePart long_side = a_is_flat ? parts.of_a : parts.of_b;
        const auto corners =
            a_is_flat ? vertices_a_.corners(crossing.pair.a) : vertices_b_.corners(crossing.pair.b);
        if (!is_side(long_side)) return;
        const int from = number_of(long_side);
        const int to = (from + 1) % 3;
        const int middle = (from + 2) % 3;
        const auto id = [&](int corner) { return corners[static_cast<std::size_t>(corner)]; };
        if (id(middle) == id(from) || id(middle) == id(to)) return;
        const auto side_of = [&](int corner) {
            return orient3d(other[0], other[1], other[2], flat[corner]);
        };
        const int side = side_of(middle);
        if (side == 0 && side_of(from) == 0) return; // in the other's plane
        const SurfacePart short_part =
            side == 0 ? vertex_part(id(middle))
                      : edge_part(id(middle), id(side == side_of(from) ? to : from));
        ContourPoint twin = ends_[end];
        (a_is_flat ? twin.on_a : twin.on_b) = short_part;
        ends_.push_back(twin);
        segments_.push_back({end, end + 1});
    }

    /// Sorts the ends by name and leaves each name once.
    void number_ends()
    {
        const auto name = [&](std::uint32_t i) { return std::tie(ends_[i].on_a, ends_[i].on_b); };
        std::vector<std::uint32_t> order(ends_.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
        std::ranges::stable_sort(order, [&](auto i, auto j) { return name(i) < name(j); });
        numbers_.resize(ends_.size());
        std::vector<ContourPoint> distinct;
        for (std::size_t k = 0; k < order.size(); ++k) {
            if (k == 0 || name(order[k]) != name(order[k - 1])) distinct.push_back(ends_[order[k]]);
            numbers_[order[k]] = static_cast<std::uint32_t>(distinct.size() - 1);
        }
        ends_ = std::move(distinct);
    }

    [[nodiscard]] std::vector<SegmentEnds> renumbered(std::vector<SegmentEnds> segments) const
    {
        for (SegmentEnds& ends : segments) {
            for (std::uint32_t& end : ends) end = numbers_[end];
            if (ends[1] < ends[0]) std::swap(ends[0], ends[1]);
        }
        return segments;
    }

    /// What polygons beside each other have in common comes an even number of times.
    /// \pre sorted
    static std::vector<SegmentEnds> odd_ones(const std::vector<SegmentEnds>& segments)
    {
        std::vector<SegmentEnds> odd;
        for (const SegmentEnds& ends : segments) {
            if (!odd.empty() && odd.back() == ends) {
                odd.pop_back();
            } else {
                odd.push_back(ends);
            }
        }
        return odd;
    }

    const Triangles& a_;
    const Triangles& b_;
    const RigidTransform& pose_b_;
    Progress* progress_;
    SharedVertices<Triangles> vertices_a_;
    SharedVertices<Triangles> vertices_b_;
    std::vector<TrianglePair> pairs_;
    std::vector<ContourPoint> ends_;
    std::vector<SegmentEnds> segments_;
    std::vector<SegmentEnds> borders_;   ///< of polygons
    std::vector<SegmentEnds> touches_;   ///< of triangles side by side in one plane
    std::vector<std::uint32_t> numbers_; ///< of the ends as added
};

/// Nothing where the progress asks to stop.
std::optional<IntersectionContour> contour_of_indexes(const MeshIndex& a, const MeshIndex& b,
                                                      const RigidTransform& pose_b,
                                                      Progress* progress)
{
    std::vector<TrianglePair> pairs;
    std::vector<std::uint32_t> rows_a;
    std::vector<std::uint32_t> rows_b;
    visit_intersecting_rows(a.parts(), b.parts(), pose_b, [&](std::span<const RowPair> some) {
        for (const RowPair& rows : some) {
            pairs.push_back({a.ids()[rows.a], b.ids()[rows.b]});
            rows_a.push_back(rows.a);
            rows_b.push_back(rows.b);
        }
        return is_cancelled(progress) ? Flow::stop : Flow::proceed;
    });
    if (is_cancelled(progress)) return std::nullopt;
    std::ranges::sort(pairs);
    const TrianglesOfRows triangles_a(a.parts(), std::move(rows_a));
    const TrianglesOfRows triangles_b(b.parts(), std::move(rows_b));
    return ContourMaker(triangles_a, triangles_b, pose_b, pairs, progress).contour();
}

/// The contour of pairs of triangles that the caller has found. Nothing where the progress asks to stop.
std::optional<IntersectionContour> contour_of_pairs(const TriangleMesh& a, const TriangleMesh& b,
                                                    const RigidTransform& pose_b,
                                                    std::span<const TrianglePair> pairs,
                                                    Progress* progress)
{
    const TrianglesOfMesh triangles_a(a);
    const TrianglesOfMesh triangles_b(b);
    return ContourMaker(triangles_a, triangles_b, pose_b, pairs, progress).contour();
}

} // namespace

double IntersectionContour::length() const noexcept
{
    double sum = 0;
    for (const ContourLine& line : lines) {
        const auto along = points_of(line);
        for (std::size_t i = 1; i < along.size(); ++i)
            sum += (along[i].position - along[i - 1].position).norm();
        if (line.closed) sum += (along.front().position - along.back().position).norm();
    }
    return sum;
}

IntersectionContour intersection_contour(const MeshIndex& a, const MeshIndex& b,
                                         const RigidTransform& pose_b)
{
    return *contour_of_indexes(a, b, pose_b, nullptr);
}

Result<IntersectionContour> intersection_contour(const MeshIndex& a, const MeshIndex& b,
                                                 const RigidTransform& pose_b,
                                                 const ContourOptions& options)
{
    auto contour = contour_of_indexes(a, b, pose_b, options.execution.progress);
    if (!contour) return cancelled(contour_stage);
    return *std::move(contour);
}

IntersectionContour intersection_contour(const TriangleMesh& a, const TriangleMesh& b,
                                         const RigidTransform& pose_b,
                                         std::span<const TrianglePair> pairs)
{
    return *contour_of_pairs(a, b, pose_b, pairs, nullptr);
}

Result<IntersectionContour> intersection_contour(const TriangleMesh& a, const TriangleMesh& b,
                                                 const RigidTransform& pose_b,
                                                 std::span<const TrianglePair> pairs,
                                                 const ContourOptions& options)
{
    auto contour = contour_of_pairs(a, b, pose_b, pairs, options.execution.progress);
    if (!contour) return cancelled(contour_stage);
    return *std::move(contour);
}

} // namespace proxima
