#include "cli/touch_patches.h"

#include "base/text.h"
#include "cli/touch_report.h"
#include "cli/touch_session.h"
#include "haptics/force/surface_renderer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

constexpr int most_rings = 64;

/// A patch is lost when it is older than so many periods of the collision loop.
constexpr std::uint64_t periods_to_loss = 5;

/// The position where friction begins depends on rounding along the path to it.
constexpr double apart_metres = 1e-6;

double percent_sent(const PatchAccount& account)
{
    const auto sent = static_cast<double>(account.triangles);
    const double all =
        static_cast<double>(account.patches) * static_cast<double>(account.model_triangles);
    return all > 0 ? 100 * sent / all : 0;
}

double mean_triangles(const PatchAccount& account)
{
    return account.patches == 0
               ? 0
               : static_cast<double>(account.triangles) / static_cast<double>(account.patches);
}

} // namespace

PatchTouch::PatchTouch(const TouchModel& model, const PatchSettings& settings,
                       const WorkspaceMap& map, const RenderOptions& render,
                       const SurfaceProperties* properties, double tick_seconds, Pace pace)
    : whole_(*model.contact), map_(map),
      rings_(model.index, model.surface.mesh, model.surface.topology), patch_(whole_),
      expected_(whole_, proxy_options(render, map, properties)), near_(ContactPatch::most), due_(2)
{
    account_.settings = settings;
    if (settings.method == QueryMethod::thesis) {
        by_thesis_.emplace(*model.thesis, model.surface.mesh, model.surface.topology, rings_);
    }
    account_.model_triangles = model.surface.mesh.triangle_count();
    ticks_per_patch_ = static_cast<std::uint64_t>(
        std::max(1LL, std::llround(1 / (settings.collision_rate * tick_seconds))));
    if (pace == Pace::unpaced) return;
    collision_thread_ = std::thread([this] {
        collision_ = run_servo_loop({.rate = account_.settings.collision_rate,
                                     .ticks = std::numeric_limits<std::uint64_t>::max()},
                                    [this](std::uint64_t) noexcept {
                                        if (ending_.load()) return Flow::stop;
                                        ServoPosition position;
                                        if (exchange_.receive_position(position) &&
                                            make(exchange_.writing(), position))
                                            exchange_.publish_patch();
                                        return Flow::proceed;
                                    });
    });
}

PatchTouch::~PatchTouch()
{
    (void)finish();
}

/// By the thread that makes patches. Returns false where there is none yet to send down.
bool PatchTouch::make(ContactPatch& patch, const ServoPosition& position) noexcept
{
    if (!by_thesis_) {
        rings_.fill(patch, position.device, account_.settings.rings);
    } else if (!by_thesis_->fill(patch, position.device, position.proxy, account_.settings.rings)) {
        return false; // no feature was found until now
    }
    patch.made_at = position.tick;
    ++account_.patches;
    account_.incomplete += patch.complete ? 0U : 1U;
    account_.triangles += patch.count();
    account_.largest = std::max<std::uint64_t>(account_.largest, patch.count());
    return true;
}

Patch PatchTouch::begin_tick() noexcept
{
    if (collision_thread_.joinable()) used_ = exchange_.latest_patch();
    patch_.use(used_);
    if (used_ == nullptr) {
        ++account_.waited_ticks;
        return Patch::lost;
    }
    const bool lost = tick_ - used_->made_at > periods_to_loss * ticks_per_patch_;
    account_.lost_ticks += lost ? 1U : 0U;
    return lost ? Patch::lost : Patch::available;
}

/// Whether the patch answers with the contact's triangle, asked where that is touched.
bool PatchTouch::has(const Contact& contact) noexcept
{
    const double near = safety_gap(patch_.scale());
    const std::size_t count = looked_up_.collect(patch_, contact.point, near, near_);
    return std::ranges::any_of(
        std::span(near_).first(std::min(count, near_.size())),
        [&](const ContactTriangle& each) { return each.id == contact.triangle; });
}

void PatchTouch::compare(const RenderTick& rendered) noexcept
{
    const Vec3 device = map_.to_model(rendered.position);
    if (!device.allFinite()) return;
    if (!rendered.is_placed) {
        placed_ = false;
        return;
    }
    if (!placed_) expected_.place(device);
    placed_ = true;
    const ProxyTick& should = expected_.follow(device);
    if (used_ == nullptr) return; // before the first
    account_.oldest_ticks = std::max(account_.oldest_ticks, tick_ - used_->made_at);
    if (should.hold == Hold::free) return;
    ++account_.touching_ticks;
    bool missed = false;
    for (std::size_t i = 0; i < should.slide.contact_count; ++i)
        missed |= !has(should.slide.contacts[i]);
    account_.missed_ticks += missed ? 1U : 0U;
    const double apart = (should.proxy - rendered.proxy).norm();
    account_.apart_ticks += apart > apart_metres * map_.units_per_metre ? 1U : 0U;
}

void PatchTouch::end_tick(const RenderTick& rendered) noexcept
{
    compare(rendered);
    position_ = {map_.to_model(rendered.position), rendered.proxy, tick_};
    if (collision_thread_.joinable()) {
        if (position_.device.allFinite()) exchange_.send_position(position_);
    } else if (tick_ % ticks_per_patch_ == 0) {
        // The patch that was begun a period ago has come; the next one is begun.
        used_ = made_ ? &due_[making_] : nullptr;
        making_ = 1 - making_;
        made_ = make(due_[making_], position_);
    }
    account_.ticks = ++tick_;
}

PatchAccount PatchTouch::finish()
{
    ending_.store(true);
    if (collision_thread_.joinable()) collision_thread_.join();
    account_.late_collisions = collision_.missed;
    return account_;
}

std::string name_of(const PatchSettings& settings)
{
    return concat(settings.method == QueryMethod::thesis ? "thesis " : "rings ", settings.rings);
}

Result<std::vector<PatchSettings>> parse_patch_kinds(const std::string& text)
{
    std::vector<PatchSettings> kinds;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string word = text.substr(begin, end - begin);
        begin = end + 1;
        int rings = -1;
        const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), rings);
        if (error != std::errc() || rest != word.data() + word.size() || rings < 0 ||
            rings > most_rings) {
            return fail(ErrorCode::invalid_argument,
                        concat("'", word,
                               "' is no adjacency depth: use a number of rings from 0 to ",
                               most_rings));
        }
        kinds.push_back({.rings = rings});
    }
    return kinds;
}

std::string patch_table(const std::vector<PatchAccount>& accounts)
{
    std::string text =
        fmt::format("{:<9} {:>8} {:>10} {:>8} {:>9} {:>9} {:>7} {:>7} {:>7} {:>5} {:>8} {:>8}\n",
                    "patch", "patches", "triangles", "largest", "sent down", "touching", "missed",
                    "apart", "oldest", "lost", "p50 us", "p99.9 us");
    for (const PatchAccount& account : accounts) {
        const auto microseconds = [&](double part) {
            return 1e-3 * static_cast<double>(account.tick.quantile(part));
        };
        text += fmt::format(
            "{:<9} {:>8} {:>10.1f} {:>8} {:>8.3f}% {:>9} {:>7} {:>7} {:>7} {:>5} {:>8.2f} "
            "{:>8.2f}\n",
            name_of(account.settings), account.patches, mean_triangles(account), account.largest,
            percent_sent(account), account.touching_ticks, account.missed_ticks,
            account.apart_ticks, account.oldest_ticks, account.lost_ticks, microseconds(0.5),
            microseconds(0.999));
    }
    for (const PatchAccount& account : accounts) {
        if (account.ticks == 0 || account.waited_ticks < account.ticks) continue;
        text += fmt::format("{}: no patch came in {} ticks, so nothing could be felt: no closest "
                            "feature was found in time, or --collision-rate is too low\n",
                            name_of(account.settings), account.waited_ticks);
    }
    return text;
}

nlohmann::ordered_json patch_json(const std::vector<PatchAccount>& accounts)
{
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const PatchAccount& account : accounts) {
        rows.push_back({{"patch", name_of(account.settings)},
                        {"collision_rate", account.settings.collision_rate},
                        {"patches", account.patches},
                        {"mean_triangles", mean_triangles(account)},
                        {"largest", account.largest},
                        {"percent_sent", percent_sent(account)},
                        {"touching_ticks", account.touching_ticks},
                        {"missed_ticks", account.missed_ticks},
                        {"apart_ticks", account.apart_ticks},
                        {"oldest_ticks", account.oldest_ticks},
                        {"waited_ticks", account.waited_ticks},
                        {"lost_ticks", account.lost_ticks},
                        {"incomplete", account.incomplete},
                        {"late_collisions", account.late_collisions},
                        {"tick", latency_json(account.tick)}});
    }
    return rows;
}

} // namespace proxima
