#pragma once
/// Update stage: the free motion of every body.
#include "engine/solvers/articulated/kernels/table.hpp"

namespace pantin::detail::articulated {
namespace {

/// Four bodies of given angular momentum l: their rotations, and their inverse principal moments.
struct FreeTurn {
  Vec<Four> l;
  Qua<Four> q;
  Vec<Four> per_moment;
};

/// Angular velocity after a rotation `start + w reach` with angular momentum l: two fixed-point
/// iterations of w = I(q(w))^-1 l, from a guess.
INLINE Vec<Four> angular_velocity_keeping(const FreeTurn& turn, Vec<Four> start, Four reach,
                                          Vec<Four> guess) {
  Vec<Four> w = guess;
  for (int round = 0; round < 2; ++round)
    w = times_inertia(mul(exponential(start + reach * w), turn.q), turn.per_moment, turn.l);
  return w;
}

/// exp(-drag h) for four bodies, reused while the drag is the same.
class DampingFactor {
 public:
  explicit DampingFactor(double h) : h_(h) {}
  INLINE Four of(Four drag) {
    const auto same = drag == last_;
    if ((same[0] & same[1] & same[2] & same[3]) == 0) {
      for (int l = 0; l < 4; ++l) keep_[l] = ::exp(-drag[l] * h_);
      last_ = drag;
    }
    return keep_;
  }

 private:
  double h_;
  Four last_ = all(0.0), keep_ = all(1.0);
};

template <Rule rule, bool forced>
bool predict_by(const IslandView& p, const PredictInput& in) {
  const Four h = all(in.h), push = in.first ? 0.5 * h : h;
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  const Vec<Four> nothing{all(0), all(0), all(0)};
  Four probe = all(0);
  // A first step from given velocities takes half of its drag.
  DampingFactor damping(rule == Rule::euler && in.first ? 0.5 * in.h : in.h);
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    const double* c = column(p.constants, kConstantRows, i);
    double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> x = bodies.vec(p.layout.position), v = bodies.vec(p.layout.velocity);
    const Vec<Four> spin = bodies.vec(p.layout.angular_velocity);
    const Qua<Four> q = bodies.qua(p.layout.rotation);
    Vec<Four> a = num<Four>(c, kGravityScale) * g, torque = nothing;
    if (forced) {
      const double* f = column(p.forces, 6, i);
      a = a + vec<Four>(f, 0), torque = vec<Four>(f, 3);
    }
    const Four keep = damping.of(num<Four>(c, kDrag));
    const Vec<Four> translation = h * (keep * v + push * a);
    Vec<Four> w;
    if (rule == Rule::verlet) {
      w = keep * spin;
      if (forced) w = w + push * times_inertia(q, inverted(moments), torque);
    } else {
      const bool midpoint = rule == Rule::midpoint;
      const Vec<Four> kept =
          midpoint ? times_inertia(mul(exponential(all(-0.5) * h * spin), q), moments, spin)
                   : times_inertia(q, moments, spin);
      w = angular_velocity_keeping({keep * kept + push * torque, q, inverted(moments)}, nothing,
                                   midpoint ? 0.5 * h : push, spin);
    }
    const Vec<Four> r = h * w;
    probe += dot(translation + x, translation + x) + dot(r, r);
    const Qua<Four> predicted = unit_again(mul(exponential(r), q));
    put(k, kPosition, x + translation), put(k, kRotation, predicted),
        put(k, kAngularVelocityStar, w);
  }
  return sum(probe) < HUGE_VAL;
}

bool predict(const IslandView& p, const PredictInput& in) {
  const bool f = p.forces != nullptr;
  switch (in.rule) {
    case Rule::verlet:
      return f ? predict_by<Rule::verlet, true>(p, in) : predict_by<Rule::verlet, false>(p, in);
    case Rule::midpoint:
      return f ? predict_by<Rule::midpoint, true>(p, in) : predict_by<Rule::midpoint, false>(p, in);
    case Rule::euler:
      return f ? predict_by<Rule::euler, true>(p, in) : predict_by<Rule::euler, false>(p, in);
  }
  return false;
}

}  // namespace
}  // namespace pantin::detail::articulated
