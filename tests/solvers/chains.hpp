#pragma once
// Chains for the solver tests, and an independent reference for planar ones.
#include <cmath>
#include <vector>

#include "engine/base/rotation.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"

namespace pantin::test {

using namespace detail;

struct ChainSpec {
  int links = 10;
  Real length = 1;          // m, all links together
  Real mass = 1;            // kg, of the first link
  Real mass_ratio = 1;      // of a link to the one before
  Real angle = kPi / 6;     // from hanging straight down, rad
  Real radius_part = 0.05;  // of a link's length, sets the inertia about its own axis
  bool held = true;
};

/// A chain of uniform rods from the origin; the bodies come in order, root first.
inline World chain(const ChainSpec& s, std::vector<Entity>* bodies = nullptr) {
  World world;
  world.default_settings.solver = Solver::articulated;
  const Real l = s.length / s.links;
  const Quat q = from_rotation_vector(Vec3(0, 0, s.angle));
  Body wall;
  wall.motion = Motion::fixed;
  const Entity holder = s.held ? world.add_body(wall) : Entity{};
  Vec3 top(0);
  Entity before = holder;
  Real mass = s.mass;
  for (int i = 0; i < s.links; ++i) {
    Body b;
    b.mass = mass;
    const Real across = mass * l * l / 12, r = s.radius_part * l;
    b.inertia = Vec3(across, mass * r * r / 2, across);
    b.pose = {top - q * Vec3(0, l / 2, 0), q};
    b.drag = 0;
    const Entity e = world.add_body(b);
    if (bodies) bodies->push_back(e);
    const Vec3 bottom = i == 0 ? Vec3(0) : Vec3(0, -l / 2, 0);
    if (before) add_link(world, {before, e, {bottom, Vec3(0, l / 2, 0)}});
    before = e;
    top = b.pose.position - q * Vec3(0, l / 2, 0);
    mass *= s.mass_ratio;
  }
  return world;
}

/// The same chain in minimal coordinates (angles from hanging down), by Runge-Kutta steps.
class PlanarChain {
 public:
  explicit PlanarChain(const ChainSpec& s) : l_(s.length / s.links) {
    const std::size_t n = static_cast<std::size_t>(s.links);
    Real mass = s.mass;
    for (std::size_t i = 0; i < n; ++i, mass *= s.mass_ratio) m_.push_back(mass);
    state_.assign(2 * n, 0);
    for (std::size_t i = 0; i < n; ++i) state_[i] = s.angle;
  }

  void advance(Real time, int steps) {
    for (int i = 0; i < steps; ++i) step(time / steps);
  }
  Vec3 tip() const {
    Vec3 p(0);
    for (std::size_t i = 0; i < m_.size(); ++i)
      p += l_ * Vec3(std::sin(state_[i]), -std::cos(state_[i]), 0);
    return p;
  }

 private:
  using State = std::vector<Real>;

  /// Lagrange's equations of rods: sum_j A_ij cos(t_i - t_j) t_j'' = -sum_j A_ij sin(t_i - t_j)
  /// t_j'^2
  /// - g B_i sin t_i.
  State rate(const State& y) const {
    const std::size_t n = m_.size();
    std::vector<Real> outboard(n + 1, 0), a(n * n), b(n);
    for (std::size_t i = n; i-- > 0;) outboard[i] = outboard[i + 1] + m_[i];
    for (std::size_t i = 0; i < n; ++i) {
      b[i] = -9.81 * l_ * (m_[i] / 2 + outboard[i + 1]) * std::sin(y[i]);
      for (std::size_t j = 0; j < n; ++j) {
        const std::size_t far = std::max(i, j);
        const Real c =
            l_ * l_ * (i == j ? m_[i] / 3 + outboard[i + 1] : m_[far] / 2 + outboard[far + 1]);
        a[i * n + j] = c * std::cos(y[i] - y[j]);
        b[i] -= c * std::sin(y[i] - y[j]) * y[n + j] * y[n + j];
      }
    }
    for (std::size_t k = 0; k < n; ++k)  // Gauss elimination of a definite matrix
      for (std::size_t i = k + 1; i < n; ++i) {
        const Real f = a[i * n + k] / a[k * n + k];
        for (std::size_t j = k; j < n; ++j) a[i * n + j] -= f * a[k * n + j];
        b[i] -= f * b[k];
      }
    State dy(2 * n);
    for (std::size_t i = n; i-- > 0;) {
      Real s = b[i];
      for (std::size_t j = i + 1; j < n; ++j) s -= a[i * n + j] * dy[n + j];
      dy[n + i] = s / a[i * n + i];
      dy[i] = y[n + i];
    }
    return dy;
  }

  void step(Real h) {
    const auto moved = [&](const State& k, Real f) {
      State y = state_;
      for (std::size_t i = 0; i < y.size(); ++i) y[i] += f * k[i];
      return y;
    };
    const State k1 = rate(state_), k2 = rate(moved(k1, h / 2)), k3 = rate(moved(k2, h / 2)),
                k4 = rate(moved(k3, h));
    for (std::size_t i = 0; i < state_.size(); ++i)
      state_[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }

  Real l_;
  std::vector<Real> m_;
  State state_;
};

inline Vec3 tip_of(const World& world, Entity last, const ChainSpec& s) {
  return to_world(world.bodies[last].pose, Vec3(0, -s.length / s.links / 2, 0));
}

struct SwingResult {
  Real rms_error = 0;                                     // of the tip, parts of the length
  Real worst_gap = 0;                                     // parts of the length
  Real energy_start = 0, energy_max = 0, energy_end = 0;  // J
};

/// Releases a planar chain and compares its tip with the reference at every step.
inline SwingResult swing(const ChainSpec& spec, Real rate, Real duration, const SolverSettings& how,
                         bool compare = true) {
  std::vector<Entity> bodies;
  Simulation sim(chain(spec, &bodies), {1 / rate, 1, 1, true});
  sim.world.default_settings = how;
  PlanarChain reference(spec);
  SwingResult r;
  r.energy_start = r.energy_max = measure(sim.world).energy();
  const int steps = static_cast<int>(std::lround(duration * rate));
  Real sum = 0;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = sim.step();
    r.worst_gap = std::max(r.worst_gap, report.measures.worst_gap / spec.length);
    r.energy_end = report.measures.energy();
    r.energy_max = std::max(r.energy_max, r.energy_end);
    if (!compare) continue;
    reference.advance(1 / rate, std::max(1, static_cast<int>(std::ceil(1200 / rate))));
    const Vec3 miss = tip_of(sim.world, bodies.back(), spec) - reference.tip();
    sum += glm::dot(miss, miss);
  }
  r.rms_error = std::sqrt(sum / steps) / spec.length;
  return r;
}

}  // namespace pantin::test
