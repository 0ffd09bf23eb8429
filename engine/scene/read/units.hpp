#pragma once
/// Units of scene files. A file states its unit of length; all numbers become SI when it is read.
/// The dimension of each key is the unit in its row of the tables (Key::unit), and nowhere else.
#include <string_view>

#include "engine/joints/coordinates.hpp"
#include "engine/scene/json/json.hpp"

namespace pantin::detail {

/// The words under "units", and what each is in m.
inline constexpr std::string_view kLengthUnits[] = {"m", "mm"};
inline constexpr double kMetresOf[] = {1, 1e-3};

/// The unit of length of a scene file in m: 1 where it states none, or an unknown one.
double length_unit_of(const JsonDocument& scene);

/// The exponent of length in a unit such as "N m/rad", "kg m^2", "m/N"; 0 for "kg/m^3", since
/// densities stay in kg/m^3. Of alternatives ("N m/rad or N m s/rad") the first counts.
int length_exponent(std::string_view unit);

/// The factor from a number of a file to SI, for a unit that the tables give for an angle: along a
/// travel "rad" stands for m, and "N m" for N.
double to_si(std::string_view unit, Coordinate along, double length_unit);

/// Converts all numbers of a scene file to SI, except those whose dimension depends on the
/// coordinate of a joint: springs, friction, motors and motions along coordinates, gears, motor
/// events and bounds of design variables, which their readers convert.
void convert_to_si(JsonDocument& scene);

}  // namespace pantin::detail
