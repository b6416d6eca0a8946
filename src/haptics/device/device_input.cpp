#include "haptics/device/button_queue.h"
#include "haptics/device/check_numbers.h"
#include "haptics/device/velocity_bounds.h"
#include "haptics/force/surface_renderer.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/tool_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima {

namespace {

bool is_fault(InputCondition condition) noexcept
{
    using enum InputCondition;
    return condition == unsure || condition == frozen || condition == silent || condition == gone;
}

/// Error where an option is out of range.
Status check_input(const DeviceInfo& info, const InputOptions& options)
{
    if (Status status = check_positive({"tick_seconds", options.tick_seconds}); !status)
        return status;
    if (Status status = check_not_negative({{"max_jump", options.max_jump},
                                            {"max_distance", options.max_distance},
                                            {"settle_seconds", options.settle_seconds},
                                            {"frozen_seconds", options.frozen_seconds},
                                            {"frozen_force", options.frozen_force},
                                            {"patience", info.patience}});
        !status)
        return status;
    const Mat3& turn = options.rotation;
    const double off = (turn.transpose() * turn - Mat3::Identity()).norm();
    if (!(off < rigid_tolerance) || !(turn.determinant() > 0)) {
        return fail(ErrorCode::invalid_argument,
                    "the matrix from the device's axes to those of the model must be a rotation",
                    "rotation");
    }
    return {};
}

} // namespace

/// What a DeviceInput is made of.
class PROXIMA_HIDDEN InputGuard {
public:
    InputGuard(const DeviceInfo& info, InputOptions options) noexcept
        : options_(std::move(options)), patience_(info.patience),
          stillness_(options_.stillness.value_or(info.stillness))
    {
        state_.pose.translation.setConstant(std::numeric_limits<double>::quiet_NaN());
    }

    const DeviceState& accept(const DeviceReading& reading) noexcept;
    [[nodiscard]] DeviceCommand command(const HapticRenderer& renderer) noexcept;
    [[nodiscard]] DeviceCommand command(const ToolRenderer& renderer) noexcept;
    void release() noexcept { released_ = true; }
    [[nodiscard]] ButtonQueue& events() noexcept { return events_; }
    [[nodiscard]] const InputReport& report() const noexcept { return report_; }
    [[nodiscard]] const DeviceState& state() const noexcept { return state_; }

private:
    [[nodiscard]] InputCondition condition_of(const DeviceReading& reading) noexcept;
    [[nodiscard]] InputCondition judge(const DeviceState& reported) noexcept;
    [[nodiscard]] bool same_as_before(const DeviceState& reported) const noexcept;
    void watch_stillness(bool same) noexcept;
    [[nodiscard]] Vec3 velocity_of(const DeviceState& reported) noexcept;
    void count_buttons(std::uint32_t buttons) noexcept;
    void count(InputCondition condition) noexcept;
    void watch_recovery(double ramp) noexcept;

    ButtonQueue events_;
    InputOptions options_;
    double patience_;
    DeviceState state_; ///< as given to the renderer
    VelocityBounds bounds_;
    std::uint64_t sampled_ = 0;     ///< tick of the last good sample
    Vec3 good_ = Vec3::Zero();      ///< the device's last good position, in its axes
    Vec3 offset_ = Vec3::Zero();    ///< of the clutch
    Vec3 jumped_to_ = Vec3::Zero(); ///< position of samples that are not accepted
    double agreed_ = 0;             ///< s for which these agree
    double unchanged_ = 0;          ///< s of the same bits while pushed
    double waited_ = 0;             ///< s since the last new sample
    double force_ = 0;              ///< N, of the last tick
    std::uint64_t sample_ = 0;
    std::uint64_t tick_ = 0;
    DeviceState last_reported_;
    double fault_ = 0;       ///< s, of the fault in progress
    double recovering_ = -1; ///< s since the last fault ended; negative where nothing recovers
    InputReport report_;
    std::uint32_t buttons_ = 0;
    Stillness stillness_;
    bool placed_ = false; ///< there was a good sample
    bool jumping_ = false;
    bool released_ = false;
    bool heard_ = false; ///< there was a sample with a position
};

bool InputGuard::same_as_before(const DeviceState& reported) const noexcept
{
    const RigidTransform& a = reported.pose;
    const RigidTransform& b = last_reported_.pose;
    return a.translation == b.translation && a.rotation == b.rotation;
}

/// Counts how long the same bits arrive, and reports it once where that is not usual.
void InputGuard::watch_stillness(bool same) noexcept
{
    const bool was_long = unchanged_ >= options_.frozen_seconds;
    unchanged_ = same ? unchanged_ + options_.tick_seconds : 0;
    const bool begins = same && !was_long && unchanged_ >= options_.frozen_seconds;
    report_.suspicions += begins && stillness_ != Stillness::usual ? 1U : 0U;
}

InputCondition InputGuard::judge(const DeviceState& reported) noexcept
{
    const Vec3& position = reported.pose.translation;
    if (!position.allFinite() || position.cwiseAbs().maxCoeff() > options_.max_distance) {
        ++report_.not_finite;
        unchanged_ = 0;
        return InputCondition::unsure;
    }
    const bool pushed = force_ >= options_.frozen_force;
    const bool frozen = state_.condition == InputCondition::frozen;
    // A frozen device is no longer pushed, for the force has faded: only a change ends it.
    const bool same = heard_ && same_as_before(reported) && (pushed || frozen);
    watch_stillness(same);
    heard_ = true;
    last_reported_ = reported;
    if (placed_ && (position - good_).norm() > options_.max_jump) {
        const bool agrees = jumping_ && (position - jumped_to_).norm() <= options_.max_jump;
        report_.jumps += agrees ? 0U : 1U;
        agreed_ = agrees ? agreed_ + options_.tick_seconds : 0;
        jumping_ = true;
        jumped_to_ = position;
        if (agreed_ < options_.settle_seconds) return InputCondition::unsure;
    }
    jumping_ = false;
    const bool faulty = stillness_ == Stillness::impossible;
    if (faulty && unchanged_ >= options_.frozen_seconds) return InputCondition::frozen;
    return InputCondition::well;
}

InputCondition InputGuard::condition_of(const DeviceReading& reading) noexcept
{
    const bool is_new = reading.sample != sample_;
    sample_ = reading.sample;
    report_.samples += is_new ? 1U : 0U;
    waited_ = is_new ? 0 : waited_ + options_.tick_seconds;
    const InputCondition reported = reading.state.condition;
    if (reported == InputCondition::gone || reported == InputCondition::released) return reported;
    if (is_new) {
        const InputCondition judged = judge(reading.state);
        return reported == InputCondition::well ? judged : reported;
    }
    if (!placed_ || waited_ > patience_) return InputCondition::silent;
    return is_fault(state_.condition) ? state_.condition : InputCondition::well;
}

/// The velocity of a good sample, as far as it is plausible, in the device's axes.
Vec3 InputGuard::velocity_of(const DeviceState& reported) noexcept
{
    const auto ticks = static_cast<double>(std::max<std::uint64_t>(tick_ - sampled_, 1));
    sampled_ = tick_;
    bounds_.add(reported.pose.translation, ticks * options_.tick_seconds);
    Vec3 used = bounds_.plausible(reported.velocity);
    report_.velocities += used != reported.velocity ? 1U : 0U;
    return used;
}

void InputGuard::count_buttons(std::uint32_t buttons) noexcept
{
    for (std::uint32_t changed = buttons ^ buttons_; changed != 0; changed &= changed - 1) {
        const int button = std::countr_zero(changed);
        events_.push({tick_, button, ((buttons >> static_cast<unsigned>(button)) & 1U) != 0});
    }
    buttons_ = buttons;
}

void InputGuard::count(InputCondition condition) noexcept
{
    using enum InputCondition;
    const bool begins = condition != state_.condition;
    report_.clutched_ticks += condition == clutched ? 1U : 0U;
    if (!is_fault(condition)) return;
    ++report_.faulty_ticks;
    report_.freezes += begins && condition == frozen ? 1U : 0U;
    // Silence before the first good sample is not a loss.
    report_.silences += begins && condition == silent && placed_ ? 1U : 0U;
    report_.losses += begins && condition == gone ? 1U : 0U;
}

const DeviceState& InputGuard::accept(const DeviceReading& reading) noexcept
{
    InputCondition condition = condition_of(reading);
    const DeviceState& reported = reading.state;
    const bool good = condition == InputCondition::well;
    if (good && waited_ == 0) {
        const Vec3 turned = options_.rotation * reported.pose.translation;
        count_buttons(reported.buttons);
        if ((reported.buttons & options_.clutch_buttons) != 0 && placed_) {
            offset_ = state_.pose.translation - turned;
        } else {
            state_.pose.translation = turned + offset_;
        }
        good_ = reported.pose.translation;
        placed_ = true;
        if (reported.pose.rotation.allFinite())
            state_.pose.rotation = options_.rotation * reported.pose.rotation;
        state_.velocity = options_.rotation * velocity_of(reported);
        state_.buttons = reported.buttons;
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
        report_.longest_fault = std::max(report_.longest_fault, fault_);
        recovering_ = placed_ ? 0 : -1;
    }
    state_.condition = condition;
    ++tick_;
    return state_;
}

void InputGuard::watch_recovery(double ramp) noexcept
{
    if (recovering_ < 0 || state_.condition != InputCondition::well) return;
    recovering_ += options_.tick_seconds;
    if (ramp < 1) return;
    ++report_.recoveries;
    report_.longest_recovery = std::max(report_.longest_recovery, recovering_);
    recovering_ = -1;
}

DeviceCommand InputGuard::command(const HapticRenderer& renderer) noexcept
{
    const RenderTick& tick = renderer.last();
    const SurfaceMaterial touched = parts_of(renderer).touched_material();
    const Mat3 back = options_.rotation.transpose();
    const auto to_device = [&](const Vec3& model) -> Vec3 {
        return back * (renderer.map().to_device(model) - offset_);
    };
    DeviceCommand command;
    command.force = back * tick.force;
    command.condition = state_.condition;
    command.force_scale = parts_of(renderer).guard().ramp();
    // With the guard's damping and softening, so that the device's own loop does not oscillate.
    const PassivityGuard& passivity = parts_of(renderer).passivity();
    command.stiffness = passivity.softness() * touched.stiffness;
    command.damping = passivity.softness() * touched.damping + passivity.added_damping();
    // A sliding proxy sticks again at less friction than a sticking one begins to slide.
    const bool slides = tick.hold == Hold::sliding;
    const double restick = parts_of(renderer).proxy().options().restick;
    command.static_friction = (slides ? restick : 1.0) * touched.static_friction;
    command.dynamic_friction = touched.dynamic_friction;
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
    watch_recovery(command.force_scale);
    return command;
}

DeviceCommand InputGuard::command(const ToolRenderer& renderer) noexcept
{
    const ToolTick& tick = renderer.last();
    const Mat3 back = options_.rotation.transpose();
    DeviceCommand command;
    command.force = back * tick.force;
    command.torque = back * tick.torque;
    command.condition = state_.condition;
    command.force_scale = tick.force_scale;
    command.stiffness = renderer.options().force.stiffness;
    command.damping = renderer.options().force.damping;
    force_ = tick.force.norm();
    watch_recovery(command.force_scale);
    return command;
}

DeviceInput::DeviceInput(std::unique_ptr<InputGuard> guard) noexcept : guard_(std::move(guard)) {}
DeviceInput::DeviceInput(DeviceInput&& other) noexcept = default;
DeviceInput& DeviceInput::operator=(DeviceInput&& other) noexcept = default;
DeviceInput::~DeviceInput() = default;

const DeviceState& DeviceInput::accept(const DeviceReading& reading) noexcept
{
    return guard_->accept(reading);
}

DeviceCommand DeviceInput::command(const HapticRenderer& renderer) noexcept
{
    return guard_->command(renderer);
}

DeviceCommand DeviceInput::command(const ToolRenderer& renderer) noexcept
{
    return guard_->command(renderer);
}

void DeviceInput::release() noexcept
{
    guard_->release();
}

std::optional<ButtonEvent> DeviceInput::next_button_event() noexcept
{
    return guard_->events().pop();
}

const InputReport& DeviceInput::report() const noexcept
{
    return guard_->report();
}

const DeviceState& DeviceInput::state() const noexcept
{
    return guard_->state();
}

Result<DeviceInput> make_device_input(const DeviceInfo& info, const InputOptions& options)
{
    if (Status status = check_input(info, options); !status) return tl::unexpected(status.error());
    return DeviceInput(std::make_unique<InputGuard>(info, options));
}

} // namespace proxima
