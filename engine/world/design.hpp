#pragma once
/// Design variables: numbers of laws that assembly may change together with the poses.
///
/// Internal (pantin::detail).
#include <string_view>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/nurbs/knots.hpp"
#include "engine/world/entity.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

enum class Quantity : std::uint8_t {
  length,    // m, of a distance joint or a cable
  radius,    // m, of a pulley that a cable or a belt runs over
  pitch,     // m/rad, of a screw
  ratio,     // of a gear
  anchor_a,  // m, three numbers in the mass-centre frame of the body
  anchor_b,
  axis_a,  // rad, two numbers: rotations of the x axis of a joint about its y and z in that body
  axis_b,
  point_a,  // m, a control point of a surface or curve, three numbers in its frame
  point_b,
  weight_a,  // of a control point
  weight_b
};

struct DesignVariable {
  Entity law;  // a joint, cable, gear, belt or surface joint
  Quantity quantity = Quantity::length;
  // radius: the number of the pulley; points and weights: of the control point in its face.
  std::uint32_t guide = 0;
  Real least = -1e300, most = 1e300;  // of a quantity of one number
  std::uint32_t face = 0;             // of points and weights

  /// Whether it is the same number, with any bounds.
  bool is_same(const DesignVariable& other) const {
    return law == other.law && quantity == other.quantity && guide == other.guide &&
           face == other.face;
  }
};

constexpr bool is_anchor(Quantity q) { return q == Quantity::anchor_a || q == Quantity::anchor_b; }
constexpr bool is_axis(Quantity q) { return q == Quantity::axis_a || q == Quantity::axis_b; }
constexpr bool is_point(Quantity q) { return q == Quantity::point_a || q == Quantity::point_b; }
constexpr bool is_weight(Quantity q) { return q == Quantity::weight_a || q == Quantity::weight_b; }

/// The number of independent numbers: 1, 2 or 3.
constexpr std::size_t numbers_of(Quantity q) {
  if (is_anchor(q) || is_point(q)) return 3;
  return is_axis(q) ? 2 : 1;
}
/// Whether it must be above 0.
constexpr bool is_size(Quantity q) {
  return q == Quantity::length || q == Quantity::radius || is_weight(q);
}

/// A quantity of one number, in x, or a point; or the joint axes in the body.
struct DesignValue {
  Vec3 numbers{0};
  Quat axes{1, 0, 0, 0};
};

struct Joint;
struct CableParameters;
struct Gear;
struct Belt;
struct SurfaceContact;

/// Poses of the bodies of a belt's pulleys where it was laid: a component of the belt. The belt
/// keeps the length that it has there.
struct LaidBelt {
  std::vector<Pose> bodies;
};
const LaidBelt* laid_of(const World& world, Entity belt);

/// Why a quantity of a law is no number of its equations, as a clause ("expected ..."); empty if it
/// may be a design variable. `radius`: that of the guide, below 0 without one.
std::string_view design_fault(const Joint& joint, Quantity quantity);
std::string_view design_fault(const CableParameters& cable, Quantity quantity, Real radius);
std::string_view design_fault(const Gear& gear, Quantity quantity);
std::string_view design_fault(const Belt& belt, Quantity quantity, std::uint32_t pulley);
std::string_view design_fault(const SurfaceContact& contact, const DesignVariable& variable);
/// The same for a law of a World, which may be gone.
std::string_view fault_of(const World& world, const DesignVariable& variable);

/// The surface or curve of a point or weight, and whether the same is on a side of a contact.
struct ContactSurface;
const ContactSurface& surface_of(const World& world, const DesignVariable& variable);
bool is_same_net(const ContactSurface& one, const ContactSurface& other);

/// A control point with its weight, in its frame, for a variable without a fault.
nurbs::Weighted control_point_of(const World& world, const DesignVariable& variable);

/// The value in a World, for a variable without a fault.
DesignValue value_of(const World& world, const DesignVariable& variable);
/// Sets it. A surface or curve is replaced in all contacts that share it, and a belt is laid again
/// where it was laid; shapes are as before.
void set_value(World& world, const DesignVariable& variable, const DesignValue& value);

}  // namespace pantin::detail
