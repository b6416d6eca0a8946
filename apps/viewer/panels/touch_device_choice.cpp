#include "viewer/panels/touch_device_choice.h"

#include "base/text.h"

namespace proxima {
namespace {

const char* usual_axes(Hand hand, bool z_is_up)
{
    switch (hand) {
    case Hand::hd: // y up, z towards the person
        return z_is_up ? "x,-z,y" : "x,y,z";
    case Hand::dhd: // z up, x towards the person
        return z_is_up ? "y,-x,z" : "y,z,x";
    case Hand::mouse: // moves in the model
    case Hand::udp:   // turns for itself
        break;
    }
    return "x,y,z";
}

} // namespace

bool TouchDeviceChoice::offer(Controls& controls)
{
    constexpr std::array<std::string_view, 4> words = {"mouse", "udp", "hd", "dhd"};
    bool changed = choose(controls, "device", hand, words);
    {
        const OfferedIf by_udp(controls, "device=udp", hand == Hand::udp);
        changed = controls.text("address", address) || changed;
    }
    {
        const OfferedIf by_hd(controls, "device=hd", hand == Hand::hd);
        changed = controls.text("name", name) || changed;
    }
    {
        const OfferedIf by_dhd(controls, "device=dhd", hand == Hand::dhd);
        changed = controls.number("number", number, 0, 63) || changed;
    }
    {
        const OfferedIf by_maker(controls, "device=hd or device=dhd",
                                 hand == Hand::hd || hand == Hand::dhd);
        changed = controls.text("library", library) || changed;
    }
    const OfferedIf by_device(controls, "a device other than the mouse", hand != Hand::mouse);
    changed = controls.text("axes", axes) || changed;
    return controls.button("open it again") || changed;
}

std::string TouchDeviceChoice::device() const
{
    switch (hand) {
    case Hand::mouse:
        return "mouse";
    case Hand::udp:
        return concat("udp:", address);
    case Hand::hd:
        return name.empty() ? "hd" : concat("hd:", name);
    case Hand::dhd:
        break;
    }
    return concat("dhd:", number);
}

Result<Mat3> TouchDeviceChoice::rotation(const Vec3& up) const
{
    return parse_axes(axes.empty() ? usual_axes(hand, up == Vec3::UnitZ()) : axes);
}

Result<TouchDevice> TouchDeviceChoice::open(const ViewModel& model) const
{
    const std::string wanted = device();
    if (const std::string problem = touch_device_problem(wanted); !problem.empty())
        return fail(ErrorCode::invalid_argument, problem);
    TouchDeviceSettings settings;
    settings.device = wanted;
    settings.library = library;
    return open_touch_device(settings, model.box, model.mesh, model.topology, {});
}

} // namespace proxima
