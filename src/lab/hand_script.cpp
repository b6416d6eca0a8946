#include "lab/hand_script.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace proxima {

namespace {

constexpr int sites = 12; ///< that a script visits

/// A point of the surface, in the device's metres.
struct Site {
    Vec3 position = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ();
};

} // namespace

/// Writes the stops of one script.
class ScriptWriter {
public:
    ScriptWriter(const TriangleMesh& mesh, const Topology& topology, const WorkspaceMap& map,
                 std::uint64_t seed, std::span<const std::uint32_t> parts)
        : mesh_(mesh), topology_(topology), map_(map), random_(seed), parts_(parts)
    {
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            if (!(scaled_normal(mesh.triangle(TriangleId{id})).norm() > 0)) continue;
            if (solid_.empty() || part_of(TriangleId{id}) != part_of(solid_.back().back()))
                solid_.emplace_back();
            solid_.back().push_back(TriangleId{id});
        }
    }

    [[nodiscard]] bool has_surface() const { return !solid_.empty(); }

    void press()
    {
        for (int i = 0; i < sites; ++i) {
            const Site site = any_site();
            go(0.4, site, 0.02);
            go(0.3, site, -0.008);
            go(0.2, site, -0.008);
            go(0.2, site, 0.02);
        }
    }

    void slide()
    {
        Site site = any_site();
        go(0.4, site, 0.02);
        for (int i = 0; i < 3 * sites; ++i) {
            go(0.25, site, -0.006);
            site = site_near(site);
        }
        go(0.3, site, 0.02);
    }

    void stroke()
    {
        for (int i = 0; i < sites && topology_.edge_count() > 0; ++i) {
            const EdgeId edge = any_edge();
            const auto triangles = topology_.triangles(edge);
            Site from = middle_of(triangles.front());
            Site to = middle_of(triangles.back());
            const Vec3 step = to.position - from.position;
            constexpr double least = 0.01; // m, to cross several edges of a fine mesh
            if (step.norm() > 0 && step.norm() < least) to.position += step * (least / step.norm());
            go(0.4, from, 0.02);
            for (int turn = 0; turn < 3; ++turn) {
                go(0.15, from, -0.005);
                go(0.15, to, -0.005);
            }
            go(0.2, to, 0.02);
        }
    }

    void corner()
    {
        for (const Site& site : dents()) {
            const Vec3 aside = 0.01 * direction();
            go(0.4, {site.position + aside, site.normal}, 0.02);
            go(0.2, site, -0.006);
            go(0.2, {site.position - 0.4 * aside, site.normal}, -0.008);
            go(0.2, site, 0.02);
        }
    }

    void poke()
    {
        for (int i = 0; i < sites; ++i) {
            const Site site = any_site();
            go(0.4, site, 0.03);
            go(0.06, site, -0.03);
            go(0.06, site, 0.03);
        }
    }

    void walk()
    {
        Site site = any_site();
        for (int i = 0; i < 4 * sites; ++i) {
            go(0.1 + 0.2 * unit(), {site.position + 0.005 * direction(), site.normal},
               0.02 * (unit() - 0.5));
            site = random_() % 4 == 0 ? any_site() : site_near(site);
        }
    }

    [[nodiscard]] HandScript finish() &&
    {
        // Close the path.
        script_.stops_.push_back({seconds_ + 0.5, script_.stops_.front().position});
        return std::move(script_);
    }

private:
    double unit() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }

    Vec3 direction()
    {
        for (;;) {
            const Vec3 v(2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1);
            const double length = v.norm();
            if (length > 0.1 && length <= 1) return v / length;
        }
    }

    void go(double seconds, const Site& site, double height)
    {
        if (!script_.stops_.empty()) seconds_ += seconds;
        script_.stops_.push_back({seconds_, site.position + height * site.normal});
    }

    [[nodiscard]] Site site_at(TriangleId id, double u, double v) const
    {
        const Triangle triangle = mesh_.triangle(id);
        const Vec3 position =
            triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
        return {map_.to_device(position), scaled_normal(triangle).normalized()};
    }
    [[nodiscard]] Site middle_of(TriangleId id) const { return site_at(id, 1.0 / 3, 1.0 / 3); }

    Site any_site()
    {
        const double u = unit();
        const double v = (1 - u) * unit();
        return site_at(any_triangle(), u, v);
    }

    /// A triangle of the next part.
    TriangleId any_triangle()
    {
        const std::vector<TriangleId>& part = solid_[next_part_++ % solid_.size()];
        return part[random_() % part.size()];
    }

    EdgeId any_edge()
    {
        if (solid_.size() == 1)
            return EdgeId{static_cast<std::uint32_t>(random_() % topology_.edge_count())};
        return topology_.edges(any_triangle())[random_() % 3];
    }

    [[nodiscard]] std::size_t part_of(TriangleId id) const
    {
        const auto after = std::upper_bound(parts_.begin(), parts_.end(), to_index(id));
        return static_cast<std::size_t>(after - parts_.begin());
    }

    /// The nearest of several sites with a similar normal.
    Site site_near(const Site& from)
    {
        Site best = from;
        double least = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 64; ++i) {
            const Site site = any_site();
            const double distance = (site.position - from.position).norm();
            if (distance < 0.003 || distance >= least || site.normal.dot(from.normal) < 0.3)
                continue;
            best = site;
            least = distance;
        }
        return best;
    }

    /// Vertices that lie deepest among their neighbours, as many in each part; on a convex model its
    /// sharpest ones.
    std::vector<Site> dents()
    {
        struct Dent {
            double depth;
            std::uint32_t vertex;
        };
        std::vector<Dent> found;
        for (std::uint32_t id = 0; id < mesh_.vertex_count(); ++id) {
            const auto edges = topology_.edges(VertexId{id});
            if (edges.empty()) continue;
            const Vec3 normal = normal_of(VertexId{id});
            double depth = 0;
            for (const EdgeId edge : edges) {
                const Vec3 edge_vector =
                    mesh_.position(topology_.other_end(edge, VertexId{id})) - mesh_.positions()[id];
                if (edge_vector.norm() > 0) depth += edge_vector.normalized().dot(normal);
            }
            found.push_back({depth / static_cast<double>(edges.size()), id});
        }
        std::ranges::stable_sort(found,
                                 [](const Dent& a, const Dent& b) { return a.depth > b.depth; });
        std::vector<Site> result;
        const std::size_t most = (sites + solid_.size() - 1) / solid_.size();
        std::vector<std::size_t> taken(parts_.size() + 1, 0);
        for (const Dent& dent : found) {
            if (result.size() == sites) break;
            const VertexId vertex{dent.vertex};
            if (taken[part_of(topology_.triangles(vertex).front())]++ >= most) continue;
            result.push_back({map_.to_device(mesh_.position(vertex)), normal_of(vertex)});
        }
        if (result.empty()) result.push_back(any_site());
        return result;
    }

    [[nodiscard]] Vec3 normal_of(VertexId vertex) const
    {
        Vec3 sum = Vec3::Zero();
        for (const TriangleId id : topology_.triangles(vertex)) {
            const Vec3 normal = scaled_normal(mesh_.triangle(id));
            if (normal.norm() > 0) sum += normal.normalized();
        }
        return sum.norm() > 0 ? Vec3(sum.normalized()) : Vec3(Vec3::UnitZ());
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    const WorkspaceMap& map_;
    std::mt19937_64 random_;
    std::span<const std::uint32_t> parts_;
    std::vector<std::vector<TriangleId>> solid_; ///< with an area, by part
    std::size_t next_part_ = 0;
    double seconds_ = 0;
    HandScript script_;
};

namespace {

struct NamedScript {
    std::string_view name;
    void (ScriptWriter::*write)();
};

constexpr std::array<NamedScript, 6> scripts = {{{"press", &ScriptWriter::press},
                                                 {"slide", &ScriptWriter::slide},
                                                 {"stroke", &ScriptWriter::stroke},
                                                 {"corner", &ScriptWriter::corner},
                                                 {"poke", &ScriptWriter::poke},
                                                 {"walk", &ScriptWriter::walk}}};

} // namespace

std::string_view hand_script_names() noexcept
{
    return "press, slide, stroke, corner, poke, walk";
}

bool is_hand_script(std::string_view name) noexcept
{
    return std::any_of(scripts.begin(), scripts.end(),
                       [&](const NamedScript& script) { return script.name == name; });
}

Result<HandScript> HandScript::make(std::string_view name, const TriangleMesh& mesh,
                                    const Topology& topology, const WorkspaceMap& map,
                                    std::uint64_t seed, std::span<const std::uint32_t> parts)
{
    for (const NamedScript& script : scripts) {
        if (script.name != name) continue;
        ScriptWriter writer(mesh, topology, map, seed, parts);
        if (!writer.has_surface()) {
            return fail(
                ErrorCode::invalid_mesh,
                "no triangle has an area that is a normal number: there is nothing to touch");
        }
        (writer.*script.write)();
        return std::move(writer).finish();
    }
    return fail(ErrorCode::invalid_argument,
                concat("no hand script is named ", name, ": they are ", hand_script_names()));
}

Vec3 HandScript::target(double seconds) const noexcept
{
    const double time = std::fmod(seconds, period());
    const auto next = std::upper_bound(stops_.begin() + 1, stops_.end() - 1, time,
                                       [](double t, const Stop& stop) { return t < stop.seconds; });
    const Stop& before = *(next - 1);
    const double span = next->seconds - before.seconds;
    const double part = span > 0 ? std::clamp((time - before.seconds) / span, 0.0, 1.0) : 1.0;
    const double smooth = part * part * (3 - 2 * part);
    return before.position + smooth * (next->position - before.position);
}

} // namespace proxima
