#pragma once
/// Update stage: the free motion of every body.
#include "engine/solvers/articulated/kernels/table.hpp"

namespace pantin::detail::articulated {
namespace {

/// Four bodies with a given angular momentum: their rotations, and the inverse of their principal
/// moments.
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
StartSums predict_by(const IslandView& p, const PredictInput& in) {
  const Four h = all(in.h), third = all(1.0 / 3), two_thirds_h = all(2.0 / 3 * in.h);
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  Four kinetic = all(0), potential = all(0), damped = all(0), probe = all(0);
  Vec<Four> momentum{all(0), all(0), all(0)};
  // A first step of the rule below takes half of its drag before the motion, the other half after.
  DampingFactor damping(rule == Rule::euler && in.first ? 0.5 * in.h : in.h);
  for (std::size_t i = 0; i < p.count; i += kLanes) {
    const double* c = column(p.constants, kConstantRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Four mass = num<Four>(c, kMass), drag = num<Four>(c, kDrag);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> x = bodies.vec(p.layout.position), v = bodies.vec(p.layout.velocity);
    const Vec<Four> angular_velocity = bodies.vec(p.layout.angular_velocity);
    const Qua<Four> q = bodies.qua(p.layout.rotation);
    const Vec<Four> weight = num<Four>(c, kGravityScale) * g;
    const Four here = mask(i, p.count) * mass;
    Vec<Four> a = weight, torque{all(0), all(0), all(0)};
    if (forced) {
      const double* f = column(p.forces, 6, i);
      a = a + vec<Four>(f, 0), torque = vec<Four>(f, 3);
    }
    Vec<Four> translation, w, r;
    if (rule == Rule::verlet) {  // no energy balance
      const Four keep = damping.of(drag), push = in.first ? 0.5 * h : h;
      translation = h * (keep * v + push * a);
      w = keep * angular_velocity;
      if (forced) w = w + push * times_inertia(q, inverted(moments), torque);
      r = h * w;
    } else {
      const Vec<Four> per_moment = inverted(moments),
                      l = times_inertia(q, moments, angular_velocity);
      const Four energy = 0.5 * (here * dot(v, v) + mask(i, p.count) * dot(l, angular_velocity));
      kinetic += energy, momentum = momentum + here * v, potential -= here * dot(weight, x);
      if (rule == Rule::bdf2) {
        const Four brake = 1.0 / (1.0 + two_thirds_h * drag);
        damped += energy * (1.0 - 1.0 / (1.0 + 2.0 * h * drag));
        const Vec<Four> v_before = vec<Four>(m, kVelocityBefore);
        const Vec<Four> l_before = vec<Four>(m, kAngularMomentumBefore);
        const Vec<Four> v_star = brake * (third * (all(4) * v - v_before) + two_thirds_h * a);
        const Vec<Four> l_star = brake * (third * (all(4) * l - l_before) + two_thirds_h * torque);
        translation = third * vec<Four>(m, kLastTranslation) + two_thirds_h * v_star;
        const Vec<Four> start = third * vec<Four>(m, kLastRotation);
        w = angular_velocity_keeping({l_star, q, per_moment}, start, two_thirds_h,
                                     angular_velocity);
        r = start + two_thirds_h * w;
      } else {
        const Four keep = damping.of(drag), push = in.first ? 0.5 * h : h;
        damped += energy * (1.0 - keep * keep);
        translation = h * (keep * v + push * a);
        const Vec<Four> nothing{all(0), all(0), all(0)};
        const bool midpoint = rule == Rule::midpoint;
        const Vec<Four> kept =
            midpoint ? times_inertia(mul(exponential(all(-0.5) * h * angular_velocity), q), moments,
                                     angular_velocity)
                     : l;
        w = angular_velocity_keeping({keep * kept + push * torque, q, per_moment}, nothing,
                                     midpoint ? 0.5 * h : push, angular_velocity);
        r = h * w;
      }
      put(m, kVelocityBefore, v), put(m, kAngularMomentumBefore, l);
    }
    probe += dot(translation + x, translation + x) + dot(r, r);
    const Qua<Four> predicted = unit_again(mul(exponential(r), q));
    put(k, kPosition, x + translation), put(k, kRotation, predicted),
        put(k, kAngularVelocityStar, w);
  }
  return {sum(kinetic),
          sum(potential),
          sum(damped),
          {sum(momentum.x), sum(momentum.y), sum(momentum.z)},
          sum(probe) < HUGE_VAL};
}

StartSums predict(const IslandView& p, const PredictInput& in) {
  const bool f = p.forces != nullptr;
  switch (in.rule) {
    case Rule::verlet:
      return f ? predict_by<Rule::verlet, true>(p, in) : predict_by<Rule::verlet, false>(p, in);
    case Rule::midpoint:
      return f ? predict_by<Rule::midpoint, true>(p, in) : predict_by<Rule::midpoint, false>(p, in);
    case Rule::euler:
      return f ? predict_by<Rule::euler, true>(p, in) : predict_by<Rule::euler, false>(p, in);
    case Rule::bdf2:
      return f ? predict_by<Rule::bdf2, true>(p, in) : predict_by<Rule::bdf2, false>(p, in);
  }
  return {};
}

}  // namespace
}  // namespace pantin::detail::articulated
