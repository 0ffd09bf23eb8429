#pragma once
// Worlds for the Lagrangian solver, and its equations by other routes.
#include <cmath>
#include <vector>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::test {

using namespace detail;

/// Every integrator in the list.
#define PANTIN_VALUE(word, ...) Integrator::word,
constexpr Integrator kAll[] = {PANTIN_INTEGRATORS(PANTIN_VALUE)};
#undef PANTIN_VALUE

inline World exact_world(Integrator integrator, Vec3 gravity = {0, -9.81, 0}) {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  w.default_settings.integrator = integrator;
  w.gravity = gravity;
  return w;
}

inline Entity add_ground(World& w, Pose at = {}) {
  Body b;
  b.motion = Motion::fixed, b.pose = at;
  return w.add_body(b);
}

inline Body solid(Real mass, Vec3 inertia, Pose at = {}) {
  Body b;
  b.mass = mass, b.inertia = inertia, b.pose = at, b.drag = 0;
  return b;
}

/// A thin rod of length `l` along its x.
inline Body rod(Real mass, Real l, Pose at = {}) {
  const Real across = mass * l * l / 12;
  return solid(mass, {0.01 * across, across, across}, at);
}

/// Joint axes whose x points along world `axis`.
inline Quat frame_along(Vec3 axis) {
  const Vec3 x = glm::normalize(axis), to = glm::cross(Vec3(1, 0, 0), x);
  if (glm::length(to) < 1e-12) return x.x > 0 ? kIdentity : from_rotation_vector({0, 0, kPi});
  return from_rotation_vector(std::atan2(glm::length(to), x.x) / glm::length(to) * to);
}

/// A joint whose point and axes are given in the world as it stands.
inline Joint joint_at(const World& w, Entity a, Entity b, JointKind kind, Vec3 point,
                      Quat axes = kIdentity) {
  const Pose &pa = w.bodies[a].pose, &pb = w.bodies[b].pose;
  Joint j;
  j.kind = kind;
  j.anchor_a = glm::conjugate(pa.rotation) * (point - pa.position);
  j.anchor_b = glm::conjugate(pb.rotation) * (point - pb.position);
  j.frames.set(glm::conjugate(pa.rotation) * axes, glm::conjugate(pb.rotation) * axes);
  return j;
}

inline BodyState placed_of(const Body& b) {
  return {b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), b.velocity,
          b.angular_velocity};
}

/// The value of a coordinate of a link as it stands.
inline Real coordinate_of(const World& w, Entity link, Coordinate which, Real before = 0) {
  const Link& l = w.links[link];
  Real c = 0;
  write_coordinate({l.joint, placed_of(w.bodies[l.a]), placed_of(w.bodies[l.b]), before}, which,
                   {&c, nullptr, nullptr});
  return c;
}

/// What all links lack at worst, m or (sines of) rad; screws and cables aside.
inline Real worst_gap(const World& w) {
  Real worst = 0;
  for (const Link& l : w.links.values()) {
    Real c[6] = {};
    if (l.joint.kind == JointKind::screw) continue;
    write_rows({l.joint, placed_of(w.bodies[l.a]), placed_of(w.bodies[l.b])},
               {c, nullptr, nullptr});
    for (const Real x : c) worst = std::max(worst, std::abs(x));
  }
  return worst;
}

/// The island with its room made and the bodies' state in it, as a step would have it.
inline lagrangian::Island& ready(World& w, std::size_t which = 0) {
  compile_if_changed(w);
  lagrangian::prepare(w);
  lagrangian::Island& m = lagrangian::islands_of(w).at(which);
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Body& body = w.bodies.values()[m.slots[b]];
    m.scratch.state.x[b] = body.pose.position, m.scratch.state.q[b] = body.pose.rotation;
    m.scratch.state.v[b] = body.velocity, m.scratch.state.w[b] = body.angular_velocity;
    m.scratch.applied[2 * b] = m.scratch.applied[2 * b + 1] = Vec3(0);
  }
  return m;
}

/// A square system in long doubles, by elimination with full pivots; what has no pivot is zero.
class Dense {
 public:
  explicit Dense(std::size_t n) : n_(n), a_(n * n, 0), b_(n, 0) {}
  long double& at(std::size_t r, std::size_t c) { return a_[r * n_ + c]; }
  long double& right(std::size_t r) { return b_[r]; }

  std::vector<long double> solve(std::size_t* rank = nullptr) {
    std::vector<std::size_t> column(n_);
    for (std::size_t i = 0; i < n_; ++i) column[i] = i;
    long double first = 0;
    std::size_t k = 0;
    for (; k < n_; ++k) {
      std::size_t pr = k, pc = k;
      for (std::size_t r = k; r < n_; ++r)
        for (std::size_t c = k; c < n_; ++c)
          if (std::abs(at(r, c)) > std::abs(at(pr, pc))) pr = r, pc = c;
      const long double pivot = at(pr, pc);
      if (k == 0) first = std::abs(pivot);
      if (std::abs(pivot) <= 1e-14L * first) break;
      for (std::size_t c = 0; c < n_; ++c) std::swap(at(k, c), at(pr, c));
      std::swap(b_[k], b_[pr]);
      for (std::size_t r = 0; r < n_; ++r) std::swap(at(r, k), at(r, pc));
      std::swap(column[k], column[pc]);
      for (std::size_t r = k + 1; r < n_; ++r) {
        const long double f = at(r, k) / pivot;
        if (f == 0) continue;
        for (std::size_t c = k; c < n_; ++c) at(r, c) -= f * at(k, c);
        b_[r] -= f * b_[k];
      }
    }
    if (rank) *rank = k;
    std::vector<long double> x(n_, 0), y(n_, 0);
    for (std::size_t r = k; r-- > 0;) {
      long double s = b_[r];
      for (std::size_t c = r + 1; c < k; ++c) s -= at(r, c) * y[c];
      y[r] = s / at(r, r);
    }
    for (std::size_t i = 0; i < n_; ++i) x[column[i]] = y[i];
    return x;
  }

 private:
  std::size_t n_;
  std::vector<long double> a_, b_;
};

/// Accelerations of all bodies (two vectors a slot) by dense elimination of J M^-1 J^T, from links
/// alone. Frames move as Placed and `known` (two vectors a slot) say.
struct Motion2 {
  std::vector<Vec3> a;
  std::size_t rank = 0, rows = 0;
};
inline Motion2 dense_motion(const World& w, const std::vector<BodyState>& at,
                            const std::vector<Vec3>& known) {
  const std::size_t bodies = w.bodies.size();
  struct Row {
    std::size_t a, b;
    Vec3 j[4];
    Real gamma;
  };
  std::vector<Row> rows;
  for (const Link& l : w.links.values()) {
    const std::size_t a = w.bodies.slot(l.a), b = w.bodies.slot(l.b);
    Vec3 j[24];
    Real gamma[6];
    write_rows({l.joint, at[a], at[b]}, {nullptr, j, gamma});
    for (int r = 0; r < row_count(l.joint); ++r)
      rows.push_back({a, b, {j[4 * r], j[4 * r + 1], j[4 * r + 2], j[4 * r + 3]}, gamma[r]});
  }
  const auto moves = [&](std::size_t s) { return w.bodies.values()[s].motion == Motion::dynamic; };
  const auto give = [&](std::size_t s, Vec3 torque) {
    const Mat3 r = glm::mat3_cast(w.bodies.values()[s].pose.rotation);
    return r * ((glm::transpose(r) * torque) / w.bodies.values()[s].inertia);
  };
  std::vector<Vec3> free(2 * bodies, Vec3(0));
  for (std::size_t s = 0; s < bodies; ++s) {
    const Body& b = w.bodies.values()[s];
    if (!moves(s)) {
      free[2 * s] = known[2 * s], free[2 * s + 1] = known[2 * s + 1];
      continue;
    }
    const Mat3 r = glm::mat3_cast(b.pose.rotation);
    const Vec3 l = r * (b.inertia * (glm::transpose(r) * b.angular_velocity));
    free[2 * s] = w.gravity, free[2 * s + 1] = give(s, -glm::cross(b.angular_velocity, l));
  }
  Dense system(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& p = rows[i];
    const std::size_t of_p[2] = {p.a, p.b};
    system.right(i) = p.gamma;
    for (std::size_t e = 0; e < 2; ++e)
      system.right(i) -= static_cast<long double>(glm::dot(p.j[2 * e], free[2 * of_p[e]])) +
                         glm::dot(p.j[2 * e + 1], free[2 * of_p[e] + 1]);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& q = rows[k];
      const std::size_t of_q[2] = {q.a, q.b};
      for (std::size_t e = 0; e < 2; ++e)
        for (std::size_t f = 0; f < 2; ++f)
          if (of_p[e] == of_q[f] && moves(of_p[e]))
            system.at(i, k) += static_cast<long double>(glm::dot(p.j[2 * e], q.j[2 * f])) /
                                   w.bodies.values()[of_p[e]].mass +
                               glm::dot(p.j[2 * e + 1], give(of_p[e], q.j[2 * f + 1]));
    }
  }
  Motion2 out;
  out.rows = rows.size();
  const std::vector<long double> load = system.solve(&out.rank);
  out.a = free;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t of[2] = {rows[i].a, rows[i].b};
    for (std::size_t e = 0; e < 2; ++e) {
      if (!moves(of[e])) continue;
      const Real x = static_cast<Real>(load[i]);
      out.a[2 * of[e]] += x / w.bodies.values()[of[e]].mass * rows[i].j[2 * e];
      out.a[2 * of[e] + 1] += give(of[e], x * rows[i].j[2 * e + 1]);
    }
  }
  return out;
}

}  // namespace pantin::test
