#include "haptics/loop/recorded_numbers.h"

#include "base/text.h"

namespace proxima {

double guard_number(Guard guard) noexcept
{
    if (guard == Guard::observe) return 2;
    return guard == Guard::on ? 1 : 0;
}

Guard guard_of_number(double number) noexcept
{
    if (number == guard_number(Guard::observe)) return Guard::observe;
    return number == guard_number(Guard::off) ? Guard::off : Guard::on;
}

Status check_choice(const std::string& field, double value, int most)
{
    for (int choice = 0; choice <= most; ++choice)
        if (value == choice) return {};
    return fail(ErrorCode::malformed_file,
                concat(field, " is ", value, " and must be a whole number ", "from 0 to ", most,
                       ": record the session again"));
}

} // namespace proxima
