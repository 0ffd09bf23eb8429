#pragma once
/// Design variables: numbers of joints and cables that assembly may change together with the poses.
///
/// Internal (pantin::detail).
#include <string_view>

#include "engine/base/math.hpp"
#include "engine/world/entity.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

enum class Quantity : std::uint8_t {
  length,    // m, of a distance joint or a cable
  radius,    // m, of a pulley that a cable runs over
  pitch,     // m/rad, of a screw
  anchor_a,  // m, three numbers in the mass-centre frame of the body
  anchor_b,
  axis_a,  // rad, two numbers: rotations of the x axis of a joint about its y and z in that body
  axis_b
};

struct DesignVariable {
  Entity law;  // a joint or a cable
  Quantity quantity = Quantity::length;
  std::uint32_t guide = 0;            // radius: its number among the guides
  Real least = -1e300, most = 1e300;  // m, of a length or a radius
};

/// The number of independent numbers: 1, 2 or 3.
constexpr std::size_t numbers_of(Quantity q) {
  if (q == Quantity::anchor_a || q == Quantity::anchor_b) return 3;
  return q == Quantity::axis_a || q == Quantity::axis_b ? 2 : 1;
}
/// Whether it is a length or a radius, which may have bounds.
constexpr bool is_size(Quantity q) { return q == Quantity::length || q == Quantity::radius; }

/// A length or radius, in x, or an anchor; or the joint axes in the body.
struct DesignValue {
  Vec3 numbers{0};
  Quat axes{1, 0, 0, 0};
};

struct Joint;
struct CableParameters;

/// Why a quantity of a joint or cable is no number of its equations, as a clause ("expected ...");
/// empty if it may be a design variable. `radius`: that of the guide, below 0 without one.
std::string_view design_fault(const Joint& joint, Quantity quantity);
std::string_view design_fault(const CableParameters& cable, Quantity quantity, Real radius);
/// The same for a law of a World, which may be gone.
std::string_view fault_of(const World& world, const DesignVariable& variable);

/// The value in a World, for a variable without a fault.
DesignValue value_of(const World& world, const DesignVariable& variable);
void set_value(World& world, const DesignVariable& variable, const DesignValue& value);

}  // namespace pantin::detail
