#include "bindings.h"
#include "touch.h"

namespace proxima::python {

TouchColumns::TouchColumns(std::size_t ticks, bool objects)
    : objects_(objects), force_(new_rows<double>(ticks, 3)), proxy_(new_rows<double>(ticks, 3)),
      anchor_(new_rows<double>(ticks, 3)), normal_(new_rows<double>(ticks, 3)),
      depth_(new_array<double>(ticks)), hold_(new_array<std::uint8_t>(ticks)),
      fault_(new_array<std::uint8_t>(ticks)), placed_(new_array<bool>(ticks)),
      squeezed_(new_array<bool>(ticks))
{}

void TouchColumns::set(std::size_t row, const RenderTick& tick)
{
    elements_of<Vec3>(force_)[row] = tick.force;
    elements_of<Vec3>(proxy_)[row] = tick.proxy;
    elements_of<Vec3>(anchor_)[row] = tick.anchor;
    elements_of<Vec3>(normal_)[row] = tick.normal;
    depth_.mutable_data()[row] = tick.depth;
    hold_.mutable_data()[row] = static_cast<std::uint8_t>(tick.hold);
    fault_.mutable_data()[row] = static_cast<std::uint8_t>(tick.fault);
    placed_.mutable_data()[row] = tick.is_placed;
    squeezed_.mutable_data()[row] = tick.squeezed;
    contacts_.insert(contacts_.end(), tick.contacts.begin(),
                     tick.contacts.begin() + static_cast<std::ptrdiff_t>(tick.contact_count));
    first_.push_back(static_cast<std::int64_t>(contacts_.size()));
}

py::object TouchColumns::result(bool single) const
{
    const std::size_t count = contacts_.size();
    auto object = new_array<std::int32_t>(count);
    auto triangle = new_array<std::int32_t>(count);
    auto position = new_rows<double>(count, 3);
    auto normal = new_rows<double>(count, 3);
    auto pressure = new_array<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
        const ContactPoint& contact = contacts_[i];
        const TriangleId id = contact.triangle;
        object.mutable_data()[i] =
            objects_ ? static_cast<std::int32_t>(to_index(object_of(id))) : 0;
        triangle.mutable_data()[i] =
            static_cast<std::int32_t>(to_index(objects_ ? triangle_of(id) : id));
        elements_of<Vec3>(position)[i] = contact.position;
        elements_of<Vec3>(normal)[i] = contact.normal;
        pressure.mutable_data()[i] = contact.pressure;
    }
    const py::object contacts =
        result_type("Contacts")(array_of<std::int64_t>(std::span<const std::int64_t>(first_)),
                                object, triangle, position, normal, pressure);
    const ResultType type = result_type("Touch");
    if (!single) {
        return type(force_, proxy_, anchor_, normal_, depth_, hold_, placed_, fault_, squeezed_,
                    contacts);
    }
    const py::int_ row(0);
    return type(force_[row], proxy_[row], anchor_[row], normal_[row], depth_[row], hold_[row],
                placed_[row], fault_[row], squeezed_[row], contacts);
}

} // namespace proxima::python
