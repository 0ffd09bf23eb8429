#pragma once
/// Explicit integrators in Pinocchio's coordinates: it has none of its own.
#include <algorithm>
#include <cmath>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/multibody.hpp>
#include <vector>

#include "engine/base/butcher_tableau.hpp"

namespace pantin::peers {

/// What a set of joints has besides those that a program knows: fewer compile sooner, and are
/// dispatched sooner. `Own` is the set.
template <typename Scalar_, int Options_, template <typename, int> class Own>
struct JointSet {
  using Scalar = Scalar_;
  static constexpr int Options = Options_;
  using JointModelSpherical = pinocchio::JointModelSphericalTpl<Scalar, Options>;
  using JointDataSpherical = pinocchio::JointDataSphericalTpl<Scalar, Options>;
  using JointModelComposite = pinocchio::JointModelCompositeTpl<Scalar, Options, Own>;
  using JointDataComposite = pinocchio::JointDataCompositeTpl<Scalar, Options, Own>;
  using JointModelMimic = pinocchio::JointModelMimicTpl<Scalar, Options, Own>;
  using JointDataMimic = pinocchio::JointDataMimicTpl<Scalar, Options, Own>;
};

enum class Way { euler, rk4, rk54 };

/// A motion of a model from its neutral configuration, at rest.
template <class Model>
class Motion {
 public:
  using Vector3 = Eigen::Vector3d;
  using VectorX = Eigen::VectorXd;

  /// `first_step`: s, that a method with a tolerance tries first.
  Motion(const Model& model, double first_step) : model_(model), first_step_(first_step) {
    for (VectorX* x : {&v, &from_v_, &turn_}) x->setZero(model.nv);
    for (VectorX& x : turn_rate_) x.setZero(model.nv);
    for (VectorX& x : rate_) x.setZero(model.nv);
    // The first is the universe, which has no coordinates.
    for (std::size_t i = 1; i < model.joints.size(); ++i)
      joints_.push_back({model.joints[i].idx_v(), model.joints[i].nv()});
    reset();
  }

  void reset() {
    q = from_q_ = next_q_ = pinocchio::neutral(model_);
    v.setZero();
    try_ = first_step_;
    time = 0, steps = 0;
  }

  /// Goes on by `count` steps of h seconds. `accelerate(t)` returns the accelerations at q, v and
  /// the time t, s.
  template <class Accelerate>
  void advance(Way way, long count, double h, const Accelerate& accelerate) {
    for (long i = 0; i < count; ++i, ++steps, time += h) {
      if (way == Way::euler)
        euler(h, accelerate);
      else
        q.swap(from_q_), v.swap(from_v_), runge_kutta(detail::kClassicRungeKutta, h, accelerate);
    }
  }

  /// Goes on by `span` seconds within a tolerance of a step, rad or rad/s. False: steps vanish.
  template <class Accelerate>
  bool adapt(double span, double tolerance, const Accelerate& accelerate) {
    double done = 0, h = std::min(try_, span);
    while (done < span * (1 - 1e-12)) {
      if (h < 1e-12) return false;
      const bool last = done + h > span * (1 - 1e-12);
      const double now = last ? span - done : h;
      from_q_ = q, from_v_ = v;
      runge_kutta(detail::kDormandPrince, now, accelerate);
      ++steps;
      const double e = error(now);
      const double factor =
          std::isfinite(e) ? 0.9 * std::pow(tolerance / std::max(e, 1e-300), 0.2) : 0.1;
      if (e <= tolerance) {
        done += now, time += now;
        if (!last || factor < 1) h = now * std::clamp(factor, 0.2, 5.0);
      } else {
        q = from_q_, v = from_v_;
        h = now * std::clamp(factor, 0.1, 0.7);
      }
    }
    try_ = h;
    return true;
  }

  VectorX q, v;
  double time = 0;  // s
  long steps = 0;   // tried

 private:
  struct JointRange {
    Eigen::Index first, count;  // in v
  };

  template <class Accelerate>
  void euler(double h, const Accelerate& accelerate) {
    v.noalias() += h * accelerate(time);
    turn_.noalias() = h * v;
    pinocchio::integrate(model_, q, turn_, next_q_);
    q.swap(next_q_);
  }

  /// The rate of the coordinates `turn_` since the start of the step: of balls a rotation vector,
  /// whose end spins at `v` in its own axes, exact to the fifth order. [Munthe-Kaas 1999]
  void turn_rates(VectorX& rates) const {
    rates = v;
    for (const JointRange& joint : joints_) {
      if (joint.count != 3) continue;
      const Vector3 u = turn_.segment<3>(joint.first), w = v.segment<3>(joint.first),
                    across = u.cross(w);
      rates.segment<3>(joint.first) = w + 0.5 * across + u.cross(across) / 12;
    }
  }

  /// q, v = from_q_, from_v_ and `h` times the weighted rates.
  void combine(const double* weights, int count, double h) {
    turn_.setZero();
    v = from_v_;
    for (int j = 0; j < count; ++j) {
      if (weights[j] == 0) continue;
      turn_.noalias() += h * weights[j] * turn_rate_[j];
      v.noalias() += h * weights[j] * rate_[j];
    }
    pinocchio::integrate(model_, from_q_, turn_, q);
  }

  /// One step from from_q_, from_v_ to q, v.
  template <class Accelerate>
  void runge_kutta(const detail::ButcherTableau& t, double h, const Accelerate& accelerate) {
    for (int i = 0; i < t.stages; ++i) {
      if (i == 0)
        q = from_q_, v = from_v_, turn_.setZero();
      else
        combine(t.a[i], i, h);
      rate_[i] = accelerate(time + t.c[i] * h);
      turn_rates(turn_rate_[i]);
    }
    combine(t.b, t.stages, h);
  }

  /// The worst estimated error of a step, rad or rad/s, of any joint.
  double error(double h) const {
    const detail::ButcherTableau& t = detail::kDormandPrince;
    double worst = 0;
    for (const JointRange& joint : joints_) {
      double turn2 = 0, v2 = 0;
      for (Eigen::Index i = joint.first; i < joint.first + joint.count; ++i) {
        double turn = 0, spin = 0;
        for (int j = 0; j < t.stages; ++j) {
          const double weight = h * (t.b[j] - t.lower[j]);
          turn += weight * turn_rate_[j][i], spin += weight * rate_[j][i];
        }
        turn2 += turn * turn, v2 += spin * spin;
      }
      worst = std::max({worst, std::sqrt(turn2), std::sqrt(v2)});
    }
    return worst;
  }

  const Model& model_;
  double first_step_, try_ = 0;
  std::vector<JointRange> joints_;
  VectorX from_q_, from_v_, next_q_, turn_;
  VectorX turn_rate_[7], rate_[7];
};

}  // namespace pantin::peers
