// A reference to a callable: what queries take as a visitor, and what a visitor answers.
//
//     const auto first_ten = [&](TriangleId id) {
//         ids.push_back(id);
//         return ids.size() < 10 ? Flow::proceed : Flow::stop;
//     };
//     visit(index, box, first_ten);    // void visit(..., FunctionRef<Flow(TriangleId)> visitor)
#pragma once

#include "proxima/export.h"

#include <concepts>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>

namespace PROXIMA_EXPORT proxima {

/// What a visitor, or a tick of a loop, answers: whether there is to be another call.
enum class Flow : std::uint8_t { proceed, stop };

template <class Signature>
class FunctionRef;

/// Two pointers, made from any callable object of the signature, const or not; wrap a plain function
/// in a lambda. It neither copies the callable nor allocates; the callable must outlive it, as a
/// temporary in a call does.
template <class Return, class... Arguments>
class FunctionRef<Return(Arguments...)> {
public:
    template <class Callable>
    requires(!std::same_as<std::remove_cvref_t<Callable>, FunctionRef> &&
             !std::is_function_v<std::remove_reference_t<Callable>> &&
             std::is_invocable_r_v<Return, Callable&, Arguments...>)
        // NOLINTNEXTLINE(google-explicit-constructor, bugprone-forwarding-reference-overload): as a call reads
        FunctionRef(Callable&& callable)
    noexcept
        : object_(const_cast<void*>(static_cast<const void*>(std::addressof(callable)))),
          call_(&call<std::remove_reference_t<Callable>>)
    {}

    /// Calls the callable, which may throw what it likes.
    Return operator()(Arguments... arguments) const
    {
        return call_(object_, std::forward<Arguments>(arguments)...);
    }

private:
    template <class Callable>
    static Return call(void* object, Arguments... arguments)
    {
        return (*static_cast<Callable*>(object))(std::forward<Arguments>(arguments)...);
    }

    void* object_;
    Return (*call_)(void*, Arguments...);
};

} // namespace proxima
