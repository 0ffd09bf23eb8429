#pragma once
/// Wrenches and responses to them; bodies, contacts and joints of a group at rest (group_rest.cpp).
#include <cstdint>
#include <limits>

#include "engine/base/math.hpp"
#include "engine/joints/parameters.hpp"

namespace pantin::detail::articulated {

/// A force and its torque, or an impulse and its moment.
struct Wrench {
  Vec3 force{0}, torque{0};
  Wrench& operator+=(const Wrench& o) {
    force += o.force, torque += o.torque;
    return *this;
  }
};

/// Response of a motion to a wrench: velocity = vf force + vt torque, spin = vt^T force + wt
/// torque. The matrix as a whole is symmetric.
struct Response {
  Mat3 vf{0}, vt{0}, wt{0};
};

/// The inertia of a rigid or articulated body: force = ff velocity + ft spin,
/// torque = ft^T velocity + tt spin.
struct SpatialInertia {
  Mat3 ff{0}, ft{0}, tt{0};
};

/// A body of a group at rest (group_rest.cpp). A motion is a velocity and a spin.
struct RestBody {
  std::uint32_t row = 0;       // of the factor
  bool touches = false;        // in the step
  Real pressed = 0;            // N s, by its contacts
  Mat3 inertia{0};             // kg m^2, world axes
  Wrench free, motion, kept;   // without contacts and joints; current iterate; an earlier one
  Wrench residual, direction;  // of momentum; of Newton's method
};

/// An impulse along the axes of a contact, with regard to Coulomb's cone.
struct ConeImpulse {
  enum class At : std::uint8_t { apex, inside, surface };  // no impulse, held, sliding
  Vec3 impulse{0};                                         // N s
  At at = At::apex;
  Real normal = 0, aside = 0;  // on the surface, N s: of the impulse, of what was projected there
  Vec3 across{0};              // likewise: unit, its direction across the normal
};

/// A contact of such a group, along its axes.
struct RestContact {
  bool near = false;
  bool may_press = false, presses = false;  // predicted active; so in the first iteration
  Real compliance = 0;                      // 1/kg
  Real sank = 0;                            // m/s, by the load, when that was last reduced
  Real lift = 0;                            // m/s, of `goal`: see settle_lifts()
  Real kept_compliance = 0, kept_lift = 0;  // see keep_found()
  Vec3 goal{0}, speed{0}, change{0};        // m/s, of a's point relative to b's
  ConeImpulse cone;
};

/// One row of a joint, its limits, springs or actuator, of a tie or of rolling friction: the
/// impulse (goal - speed) / R along a relative motion of two bodies; of an actuator that of its
/// law.
struct RestLink {
  enum class Of : std::uint8_t {
    nothing,
    joint,
    lock,
    limit,
    cable,
    tie,
    spring,
    actuator,
    rolling
  };
  Of of = Of::nothing;
  std::uint32_t number = 0, side = 0;  // node, tie or rolling friction; the limit or the axis
  std::uint32_t a = 0, b = 0;          // bodies of the group; at a joint to the world both are one
  Wrench on_a, on_b;                   // by a unit of impulse
  Real compliance = 0;                 // 1/kg, 1/(kg m^2) of rotations
  Real kept_compliance = 0;            // see keep_found()
  Real size = 0;                       // m: a speed per unit of `speed`
  Real goal = 0, speed = 0, change = 0;
  Real most = std::numeric_limits<Real>::infinity();  // N s or N m s, of the impulse's size
  Real last = 0, impulse = 0;               // of the last step; never negative at limits and cables
  const Dof* dof = nullptr;                 // of an actuator
  Real angle = 0, h = 0;                    // rad, at the start; s
  bool may_press = false, presses = false;  // as of RestContact
  bool is_one_sided() const { return of == Of::limit || of == Of::cable; }
};

}  // namespace pantin::detail::articulated
