#include "haptics/device/dhd_device.h"

#include "base/shared_library.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

namespace proxima {

namespace {

constexpr const char* dhd_advice =
    "install the Force Dimension SDK 3 and its udev rules, or name the library by "
    "--device-library";

/// The functions of libdhd that we use, by its public reference. All take the device's number last
/// and return a negative number where they fail.
struct DhdApi {
    int (*get_device_count)() = nullptr;
    int (*open_id)(char) = nullptr;
    int (*close)(char) = nullptr;
    const char* (*get_system_name)(char) = nullptr;
    int (*get_position)(double*, double*, double*, char) = nullptr;
    int (*get_linear_velocity)(double*, double*, double*, char) = nullptr;
    int (*set_force)(double, double, double, char) = nullptr;
    int (*enable_force)(unsigned char, char) = nullptr;
    int (*get_button)(int, char) = nullptr;
    const char* (*get_last_error)() = nullptr;
    // These may be missing in older versions.
    unsigned int (*get_button_mask)(char) = nullptr;
    int (*get_orientation)(double[3][3], char) = nullptr;
    int (*get_serial_number)(unsigned short*, char) = nullptr;
    void (*get_version)(int*, int*, int*, int*) = nullptr;
    bool (*has_wrist)(char) = nullptr;
};

Result<DhdApi> load_dhd_api(const SharedLibrary& library)
{
    DhdApi api;
    SymbolTable table(library);
    table.need(api.get_device_count, "dhdGetDeviceCount");
    table.need(api.open_id, "dhdOpenID");
    table.need(api.close, "dhdClose");
    table.need(api.get_system_name, "dhdGetSystemName");
    table.need(api.get_position, "dhdGetPosition");
    table.need(api.get_linear_velocity, "dhdGetLinearVelocity");
    table.need(api.set_force, "dhdSetForce");
    table.need(api.enable_force, "dhdEnableForce");
    table.need(api.get_button, "dhdGetButton");
    table.need(api.get_last_error, "dhdErrorGetLastStr");
    table.want(api.get_button_mask, "dhdGetButtonMask");
    table.want(api.get_orientation, "dhdGetOrientationFrame");
    table.want(api.get_serial_number, "dhdGetSerialNumber");
    table.want(api.get_version, "dhdGetSDKVersion");
    table.want(api.has_wrist, "dhdHasWrist");
    if (Status status = table.finish(dhd_advice); !status) return tl::unexpected(status.error());
    return api;
}

std::string dhd_text(const char* text)
{
    return text != nullptr ? text : "";
}

/// The limits of the model of this name, if it is known.
std::optional<DeviceLimits> limits_of(std::string name)
{
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const char* const known : {"omega", "delta", "falcon"}) {
        if (name.find(known) != std::string::npos) return find_device(known);
    }
    return std::nullopt;
}

class DhdDevice final : public Device {
public:
    DhdDevice(SharedLibrary library, const DhdApi& api, char id, int index)
        : library_(std::move(library)), api_(api), id_(id)
    {
        info_.name = index == 0 ? "dhd" : concat("dhd:", index);
        info_.model = concat("Force Dimension ", dhd_text(api_.get_system_name(id)));
        unsigned short serial = 0;
        if (api_.get_serial_number != nullptr && api_.get_serial_number(&serial, id) >= 0)
            info_.serial = to_text(serial);
        std::array<int, 4> version{};
        if (api_.get_version != nullptr)
            api_.get_version(&version[0], &version[1], &version[2], &version[3]);
        info_.driver = concat(library_.path(), ", SDK ", version[0], '.', version[1], '.',
                              version[2], '.', version[3]);
        const std::optional<DeviceLimits> limits = limits_of(info_.model);
        info_.limits = limits.value_or(*find_device("omega"));
        if (!limits) info_.model += " (unknown here: limits of an omega)";
        info_.buttons = api_.get_button_mask != nullptr ? 32 : 1;
        info_.rotates =
            api_.get_orientation != nullptr && api_.has_wrist != nullptr && api_.has_wrist(id);
    }
    ~DhdDevice() override
    {
        api_.set_force(0, 0, 0, id_);
        api_.enable_force(0, id_);
        api_.close(id_);
    }

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }

    [[nodiscard]] DeviceReading read() noexcept override
    {
        std::array<double, 3> p{};
        std::array<double, 3> v{};
        const bool there = api_.get_position(&p[0], &p[1], &p[2], id_) >= 0 &&
                           api_.get_linear_velocity(&v[0], &v[1], &v[2], id_) >= 0;
        if (!there) {
            ++failed_reads_;
            reading_.state.condition = InputCondition::gone;
            return reading_;
        }
        DeviceState& state = reading_.state;
        state.condition = InputCondition::well;
        state.pose.translation = Vec3(p[0], p[1], p[2]);
        state.velocity = Vec3(v[0], v[1], v[2]);
        double frame[3][3];
        if (info_.rotates && api_.get_orientation(frame, id_) >= 0) {
            for (int row = 0; row < 3; ++row) {
                for (int column = 0; column < 3; ++column)
                    state.pose.rotation(row, column) = frame[row][column];
            }
        }
        if (api_.get_button_mask != nullptr) {
            state.buttons = api_.get_button_mask(id_);
        } else {
            state.buttons = api_.get_button(0, id_) > 0 ? 1 : 0;
        }
        ++reading_.sample;
        return reading_;
    }

    void write(const DeviceCommand& command) noexcept override
    {
        const Vec3& f = command.force;
        failed_writes_ += api_.set_force(f.x(), f.y(), f.z(), id_) < 0 ? 1U : 0U;
    }

    [[nodiscard]] std::string trouble() const override
    {
        if (failed_reads_ + failed_writes_ == 0) return {};
        return concat("the driver failed to read ", failed_reads_, " times and to set the force ",
                      failed_writes_, " times; it says: ", dhd_text(api_.get_last_error()));
    }

private:
    SharedLibrary library_;
    DhdApi api_;
    char id_;
    DeviceInfo info_;
    DeviceReading reading_;
    std::uint64_t failed_reads_ = 0;
    std::uint64_t failed_writes_ = 0;
};

} // namespace

Result<std::unique_ptr<Device>> open_dhd_device(const DhdOptions& options)
{
    auto library =
        SharedLibrary::open({.what = "Force Dimension's libdhd.so",
                             .names = {"libdhd.so", "libdhd.so.3", "/usr/local/lib/libdhd.so",
                                       "/usr/local/lib/libdhd.so.3"},
                             .named = options.library,
                             .advice = dhd_advice});
    if (!library) return tl::unexpected(library.error());
    const auto api = load_dhd_api(*library);
    if (!api) return tl::unexpected(api.error());
    const int count = api->get_device_count();
    if (options.index < 0 || options.index >= count) {
        return fail(ErrorCode::invalid_argument,
                    concat("no device dhd:", options.index, ": devices found: ", std::max(count, 0),
                           "; check that it is plugged in and switched on, and that you may use it "
                           "(udev rules)"),
                    library->path());
    }
    const int opened = api->open_id(static_cast<char>(options.index));
    const char id = static_cast<char>(opened);
    if (opened < 0 || api->enable_force(1, id) < 0) {
        const std::string reported = dhd_text(api->get_last_error());
        if (opened >= 0) api->close(id);
        return fail(ErrorCode::invalid_argument,
                    concat("cannot open dhd:", options.index, ": ", reported), library->path());
    }
    return std::make_unique<DhdDevice>(std::move(*library), *api, id, options.index);
}

} // namespace proxima
