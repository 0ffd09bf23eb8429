// Forces of spring pins between two bodies, or of a body and a place.
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// From the point to its target; both rotate about their bodies' mass centres.
struct Pull {
  Vec3 arm[2];
  Vec3 gap, rate;
};

Pull pull_of(const Island& m, const BodyPairForce& p, const Pin& pin) {
  const BodyState &a = m.scratch.body_states[p.body[0]], &b = m.scratch.body_states[p.body[1]];
  Pull pull;
  pull.arm[0] = a.rotation_matrix * pin.anchor;
  pull.arm[1] = pin.to ? b.rotation_matrix * pin.target : Vec3(0);
  pull.gap = b.position + pull.arm[1] - a.position - pull.arm[0];
  pull.rate = b.velocity + glm::cross(b.angular_velocity, pull.arm[1]) - a.velocity -
              glm::cross(a.angular_velocity, pull.arm[0]);
  return pull;
}

/// Acceleration of the gap by a unit force, if the bodies were free.
Mat3 mobility_of(const Island& m, const BodyPairForce& p, const Pull& pull) {
  Mat3 mobile(0);
  for (int k = 0; k < 2; ++k) {
    if (p.body[k] >= m.count()) continue;
    const Mat3& inverse = m.scratch.inverse_inertia[p.body[k]];
    for (int i = 0; i < 3; ++i) {
      Vec3 axis(0);
      axis[i] = 1;
      const Vec3 turned = inverse * glm::cross(pull.arm[k], axis);
      mobile[i] += axis / m.mass[p.body[k]] + glm::cross(turned, pull.arm[k]);
    }
  }
  return mobile;
}

}  // namespace

void count_pins(Island& m) {
  std::vector<std::uint32_t> at(m.count(), 0);
  const auto each = [&](const auto& act) {
    for (BodyPairForce& p : m.elastic_pins)
      for (const std::uint32_t body : p.body)
        if (body < m.count()) act(p, at[body]);
  };
  each([](BodyPairForce&, std::uint32_t& count) { ++count; });
  each([](BodyPairForce& p, std::uint32_t count) { p.beside = std::max(p.beside, Real(count)); });
}

void add_pin_forces(const World& world, Island& m) {
  const Real h = m.scratch.forces_over;
  for (const BodyPairForce& p : m.elastic_pins) {
    const Pin& pin = world.pins.values()[p.source];
    const Pull pull = pull_of(m, p, pin);
    PANTIN_ASSERT(h >= 0 && p.beside >= 1);
    const Real by_rate = pin.damping + h * pin.stiffness;
    Vec3 force = pin.stiffness * pull.gap + by_rate * pull.rate;
    // Several pins at one body divide its mass between them.
    if (h > 0)
      force = glm::inverse(Mat3(1) + p.beside * h * by_rate * mobility_of(m, p, pull)) * force;
    add_pair_force(m, p, {force, pull.arm[0], pull.arm[1]});
  }
}

Stiffness stiffness_of_pins(const World& world, const Island& m) {
  Stiffness most;
  for (const BodyPairForce& p : m.elastic_pins) {
    const Pin& pin = world.pins.values()[p.source];
    const Mat3 mobile = p.beside * mobility_of(m, p, pull_of(m, p, pin));
    for (int i = 0; i < 3; ++i) {
      const Real sum = std::abs(mobile[i].x) + std::abs(mobile[i].y) + std::abs(mobile[i].z);
      most.spring = std::max(most.spring, sum * pin.stiffness);
      most.damper = std::max(most.damper, sum * pin.damping);
    }
  }
  return most;
}

}  // namespace pantin::detail::lagrangian
