#include "haptics/device/device_input.h"

#include "base/check.h"
#include "haptics/force/surface_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

bool is_fault(InputCondition condition) noexcept
{
    using enum InputCondition;
    return condition == unsure || condition == frozen || condition == silent || condition == gone;
}

} // namespace

DeviceInput::DeviceInput(const DeviceInfo& info, const InputOptions& options) noexcept
    : options_(options), patience_(info.patience), may_rest_(info.stillness == Stillness::usual)
{
    PROXIMA_CHECK_GT(options.tick_seconds, 0);
    PROXIMA_CHECK_LT((options.rotation.transpose() * options.rotation - Mat3::Identity()).norm(),
                     rigid_tolerance);
    state_.pose.translation.setConstant(std::numeric_limits<double>::quiet_NaN());
}

bool DeviceInput::same_as_before(const DeviceState& said) const noexcept
{
    const RigidTransform& a = said.pose;
    const RigidTransform& b = last_said_.pose;
    return a.translation == b.translation && a.rotation == b.rotation;
}

InputCondition DeviceInput::judge(const DeviceState& said) noexcept
{
    const Vec3& place = said.pose.translation;
    if (!place.allFinite() || place.cwiseAbs().maxCoeff() > options_.max_distance) {
        ++report_.not_finite;
        unchanged_ = 0;
        return InputCondition::unsure;
    }
    const bool pushed = force_ >= options_.frozen_force;
    const bool frozen = state_.condition == InputCondition::frozen;
    // Once frozen, the force has faded: it stays so until something changes.
    const bool same = heard_ && same_as_before(said) && (pushed || frozen);
    unchanged_ = same ? unchanged_ + options_.tick_seconds : 0;
    heard_ = true;
    last_said_ = said;
    if (placed_ && (place - good_).norm() > options_.max_jump) {
        const bool agrees = jumping_ && (place - jumped_to_).norm() <= options_.max_jump;
        report_.jumps += agrees ? 0U : 1U;
        agreed_ = agrees ? agreed_ + options_.tick_seconds : 0;
        jumping_ = true;
        jumped_to_ = place;
        if (agreed_ < options_.settle_seconds) return InputCondition::unsure;
    }
    jumping_ = false;
    if (!may_rest_ && unchanged_ >= options_.frozen_seconds) return InputCondition::frozen;
    return InputCondition::well;
}

InputCondition DeviceInput::condition_of(const DeviceReading& reading) noexcept
{
    const bool is_new = reading.sample != sample_;
    sample_ = reading.sample;
    report_.samples += is_new ? 1U : 0U;
    waited_ = is_new ? 0 : waited_ + options_.tick_seconds;
    if (reading.state.condition == InputCondition::gone) return InputCondition::gone;
    if (is_new) {
        const InputCondition judged = judge(reading.state);
        return reading.state.condition == InputCondition::well ? judged : reading.state.condition;
    }
    if (!placed_ || waited_ > patience_) return InputCondition::silent;
    return is_fault(state_.condition) ? state_.condition : InputCondition::well;
}

/// The velocity of a good sample, as far as it is plausible, in the device's axes.
Vec3 DeviceInput::velocity_of(const DeviceState& said) noexcept
{
    const auto ticks = static_cast<double>(std::max<std::uint64_t>(tick_ - sampled_, 1));
    sampled_ = tick_;
    bounds_.add(said.pose.translation, ticks * options_.tick_seconds);
    const Vec3 used = bounds_.plausible(said.velocity);
    report_.velocities += used != said.velocity ? 1U : 0U;
    return used;
}

void DeviceInput::count_buttons(std::uint32_t buttons) noexcept
{
    for (std::uint32_t changed = buttons ^ buttons_; changed != 0; changed &= changed - 1) {
        const int button = std::countr_zero(changed);
        events_.push({tick_, button, ((buttons >> static_cast<unsigned>(button)) & 1U) != 0});
    }
    buttons_ = buttons;
}

void DeviceInput::count(InputCondition condition) noexcept
{
    using enum InputCondition;
    const bool begins = condition != state_.condition;
    report_.clutched_ticks += condition == clutched ? 1U : 0U;
    if (!is_fault(condition)) return;
    ++report_.faulty_ticks;
    report_.freezes += begins && condition == frozen ? 1U : 0U;
    // Before it was ever there it was not lost.
    report_.silences += begins && condition == silent && placed_ ? 1U : 0U;
    report_.losses += begins && condition == gone ? 1U : 0U;
}

const DeviceState& DeviceInput::accept(const DeviceReading& reading) noexcept
{
    InputCondition condition = condition_of(reading);
    const DeviceState& said = reading.state;
    const bool good = condition == InputCondition::well;
    if (good && waited_ == 0) {
        const Vec3 turned = options_.rotation * said.pose.translation;
        count_buttons(said.buttons);
        if ((said.buttons & options_.clutch_buttons) != 0 && placed_) {
            offset_ = state_.pose.translation - turned;
        } else {
            state_.pose.translation = turned + offset_;
        }
        good_ = said.pose.translation;
        placed_ = true;
        if (said.pose.rotation.allFinite())
            state_.pose.rotation = options_.rotation * said.pose.rotation;
        state_.velocity = options_.rotation * velocity_of(said);
        state_.buttons = said.buttons;
    }
    if (good && (state_.buttons & options_.clutch_buttons) != 0)
        condition = InputCondition::clutched;
    if (released_) condition = InputCondition::released;
    if (condition != InputCondition::well) state_.velocity = Vec3::Zero();
    count(condition);
    if (is_fault(condition)) {
        bounds_.restart();
        fault_ =
            is_fault(state_.condition) ? fault_ + options_.tick_seconds : options_.tick_seconds;
        if (placed_) report_.longest_fault = std::max(report_.longest_fault, fault_);
        recovering_ = placed_ ? 0 : -1;
    }
    state_.condition = condition;
    ++tick_;
    return state_;
}

void DeviceInput::watch_recovery(double trust) noexcept
{
    if (recovering_ < 0 || state_.condition != InputCondition::well) return;
    recovering_ += options_.tick_seconds;
    if (trust < 1) return;
    ++report_.recoveries;
    report_.longest_recovery = std::max(report_.longest_recovery, recovering_);
    recovering_ = -1;
}

DeviceCommand DeviceInput::command(const HapticRenderer& renderer) noexcept
{
    const RenderTick& tick = renderer.last();
    const RenderOptions& options = renderer.options();
    const Mat3 back = options_.rotation.transpose();
    const auto to_device = [&](const Vec3& model) -> Vec3 {
        return back * (renderer.map().to_device(model) - offset_);
    };
    DeviceCommand command;
    command.force = back * tick.force;
    command.condition = state_.condition;
    command.trust = parts_of(renderer).guard().trust();
    // As the guard has softened them: servo loops of their own must not swing either.
    const double softness = parts_of(renderer).passivity().softness();
    command.stiffness = softness * options.force.stiffness;
    command.damping =
        softness * options.force.damping + parts_of(renderer).passivity().added_damping();
    // What slides sticks again later than what sticks begins to slide.
    const bool slides = tick.hold == Hold::sliding;
    const double restick = parts_of(renderer).proxy().options().restick;
    command.static_friction = (slides ? restick : 1.0) * options.static_friction;
    command.dynamic_friction = options.dynamic_friction;
    command.anchor = to_device(tick.anchor);
    if (tick.hold != Hold::free) {
        const SlideResult& slide = parts_of(renderer).proxy_tick().slide;
        const Vec3 frictionless = to_device(slide.anchor);
        for (std::size_t i = 0; i < slide.contact_count; ++i) {
            const Vec3 normal = back * slide.contacts[i].normal;
            command.planes[i] = {normal, normal.dot(frictionless)};
        }
        command.plane_count = slide.contact_count;
    }
    force_ = tick.force.norm();
    watch_recovery(command.trust);
    return command;
}

} // namespace proxima
