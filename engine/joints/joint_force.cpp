#include "engine/joints/joint_force.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail {

LinearisedForce linearise(const Dof& f, Real coordinate, Real rate, Slope slope) {
  const bool secant = slope == Slope::secant;
  LinearisedForce p;
  p.force = -f.spring.stiffness * (coordinate - f.spring.rest) - f.spring.damping * rate;
  p.stiffness = f.spring.stiffness, p.damping = f.spring.damping;
  p.force -= f.friction.viscous * rate, p.damping += f.friction.viscous;
  if (f.friction.dry != 0) {
    const Real u = rate / f.friction.slip, t = std::tanh(u),
               steepest = f.friction.dry / f.friction.slip;
    p.force -= f.friction.dry * t;
    p.damping += secant ? steepest * (std::abs(u) > 1e-6 ? t / u : 1) : steepest * (1 - t * t);
  }
  if (f.motor.kind == MotorKind::none) return p;
  const bool speed = f.motor.kind == MotorKind::velocity;
  const Real requested =
      speed ? f.motor.gain * (f.motor.target - rate)
            : f.motor.gain * (f.motor.target - coordinate) - f.motor.damping * rate;
  p.force += std::clamp(requested, -f.motor.cap, f.motor.cap);
  const bool capped = std::abs(requested) >= f.motor.cap;
  const Real part = !capped ? 1 : secant ? f.motor.cap / std::abs(requested) : 0;
  p.stiffness += speed ? 0 : part * f.motor.gain;
  p.damping += part * (speed ? f.motor.gain : f.motor.damping);
  return p;
}

Real rate_after(const Dof& dof, const RateAt& at, Real response) {
  const auto impulse_at = [&](Real rate) {
    const LinearisedForce f = linearise(dof, at.coordinate + at.h * rate, rate, Slope::tangent);
    return std::array<Real, 2>{at.h * f.force, at.h * (at.h * f.stiffness + f.damping)};
  };
  return settled(at.rate, response, impulse_at);
}

bool is_sound(const Dof& dof) {
  const JointMotor& m = dof.motor;
  for (const Real x : {dof.spring.stiffness, dof.spring.damping, dof.spring.rest,
                       dof.friction.viscous, dof.friction.dry, dof.friction.slip})
    if (!std::isfinite(x)) return false;
  if (dof.friction.dry != 0 && !(dof.friction.slip > 0)) return false;
  if (m.kind == MotorKind::none) return true;
  return std::isfinite(m.target) && std::isfinite(m.gain) && std::isfinite(m.damping) && m.cap >= 0;
}

bool saturates(const Dof& dof) {
  return dof.friction.dry != 0 || (dof.motor.kind != MotorKind::none && dof.motor.cap < 1e299);
}

}  // namespace pantin::detail
