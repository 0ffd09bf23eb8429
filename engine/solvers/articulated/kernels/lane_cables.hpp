#pragma once
/// Cables of islands side by side in a step by the energy-momentum method: what the hooks of
/// conserving_ties.cpp do for one island, an island in each lane. Lanes whose equations need more
/// than a row for a cable fail, and are stepped alone.
#include "engine/solvers/articulated/kernels/lane_response.hpp"

namespace pantin::detail::articulated {
namespace {

class LaneCables : public LaneResponse {
 public:
  using LaneResponse::LaneResponse;

  /// Before an elimination: what the cables add to the blocks, at the iterate.
  void load(Four h) {
    for (std::size_t n = 0; n < kTieBlock * t_.count; ++n) store(room_.blocks + n * kLanes, all(0));
    bool may_change[kLanes];
    for (std::size_t l = 0; l < kLanes; ++l) {
      may_change[l] = runs(l), tautened_[l] = false;
      if (runs(l)) ++*island(l).iterations;
    }
    for (std::size_t n = 0; n < count(); ++n) {
      look_at(n);
      if (!tie(n).stretches) {
        const Mask asked = has_to_change(n);
        for (std::size_t l = 0; any(asked) && l < kLanes; ++l) {
          if (!may_change[l] || !asked[l]) continue;
          change(n, l), may_change[l] = *island(l).iterations <= kChangeAtOnce;
          tautened_[l] = tautened_[l] || kind(n, l) == kTautTie;
        }
      }
      double* const k = at(n);
      const Vec<Four> before = vec<Four>(k, kCableMu);
      if (tie(n).stretches) {
        const Load now = load_of(n, h);
        put(k, kCableMu, t_.kept(now.mu, before));
        for (std::size_t i = 0; i < 3; ++i) put(k, kCableDerivative + 3 * i, now.derivative[i]);
        write(k + kCableAcross * kLanes, now.across);
      } else {
        // The impulse of a taut cable is along the mean of d.
        const Vec<Four> mean = 0.5 * (vec<Four>(k, kCableBefore) + vec<Four>(k, kCableNow));
        const Four across = dot(before, mean) / dot(mean, mean);
        write(k + kCableAcross * kLanes, across);
        put(k, kCableMu, t_.kept(chosen(taut(n), across * mean, before), before));
      }
      const Vec<Four> mu = vec<Four>(k, kCableMu);
      add_to_block(tie(n).b, mu, vec<Four>(k, kCableMeanB), vec<Four>(k, kCableEndB));
      if (tie(n).a != kNoColumn)
        add_to_block(tie(n).a, -1.0 * mu, vec<Four>(k, kCableMeanA), vec<Four>(k, kCableEndA));
    }
  }

  /// After it: how the cables answer.
  void correct(Four h, bool (&fails)[kLanes]) {
    Solve solve{LaneArms::mean, h, {}};
    for (std::size_t l = 0; l < kLanes; ++l) solve.wanted[l] = runs(l);
    for (std::size_t n = 0; n < count(); ++n) {
      write(at(n) + kCableActs * kLanes, ones(tie(n).stretches ? stretched(n) : taut(n)));
      put_row(n);
    }
    const bool any = answer(solve, fails);
    for (std::size_t r = 0; any && r < rows_; ++r) {
      double* const k = at(row(r));
      const Vec<Four> mu = vec<Four>(k, kCableMu);
      put(k, kCableMu, t_.kept(mu + gain(r) * vec<Four>(k, kCableDirection), mu));
    }
    for (std::size_t l = 0; l < kLanes; ++l)
      if (runs(l) && !fails[l] && tautened_[l] && island(l).is_hit_early(island(l).context))
        fails[l] = true;
    if (any) add_joint_impulses(1.0);
    for (std::size_t l = 0; l < kLanes; ++l) fails[l] = fails[l] || alone_[l];
  }

  /// Where iterations have converged: which of those that are near have nothing left to change.
  void settle(Four h, bool (&near)[kLanes]) {
    for (std::size_t n = 0; n < count(); ++n) {
      look_at(n);
      const Mask asked = tie(n).stretches ? is_not_followed(n, h) : has_to_change(n);
      for (std::size_t l = 0; any(asked) && l < kLanes; ++l) {
        if (!near[l] || !asked[l]) continue;
        if (!tie(n).stretches) change(n, l);
        near[l] = false;
      }
    }
  }

  /// After the iterations: whether the step of a lane can be taken so.
  bool accept(Four h, std::size_t l, double& released) {
    const LaneIsland& own = island(l);
    double most = 0, work = 0;
    for (std::size_t n = 0; n < count(); ++n) {
      const double* const k = at(n);
      const Vec<Four> mu = vec<Four>(k, kCableMu);
      const Vec<Four> way = vec<Four>(k, kCableBefore) - vec<Four>(k, kCableNow);
      released += (2.0 / h * dot(mu, way))[l];
      work -= (2.0 / h * dot(mu, vec<Four>(k, kCableWay)))[l];
      const double over = ::fabs(over_of(k)[l]);
      if (!tie(n).stretches && kind(n, l) == kTautTie && over > most) most = over;
    }
    *own.place_work = work;
    return most <= kAccepted * own.size && !own.ends_early(own.context);
  }

  /// Velocities at the end, as the cables allow them, of the lanes wanted.
  void project(Four h, const bool (&wanted)[kLanes], bool (&fails)[kLanes]) {
    Solve solve{LaneArms::end, h, {}};
    for (std::size_t l = 0; l < kLanes; ++l) solve.wanted[l] = wanted[l] && !strikes(l);
    for (std::size_t n = 0; n < count(); ++n) {
      double* const k = at(n);
      const Vec<Four> direction = normalized(vec<Four>(k, kCableNow));
      write(k + kCableSoftness * kLanes, all(0));
      put(k, kCableDirection, direction), put(k, kCableBy, direction);
      write(k + kCableRight * kLanes, dot(direction, vec<Four>(k, kCableVelocity)));
      write(k + kCableActs * kLanes, tie(n).stretches ? all(0) : ones(taut(n)));
    }
    if (answer(solve, fails)) {
      for (std::size_t r = 0; r < rows_; ++r) {
        const double* const k = at(row(r));
        const Vec<Four> mu = gain(r) * vec<Four>(k, kCableDirection);
        // The impulses of the projection count in the mean over the step.
        const Four work = dot(mu, vec<Four>(k, kCableVelocity));
        for (std::size_t l = 0; l < kLanes; ++l)
          if (solve.wanted[l] && acts(row(r), l)) *island(l).place_work -= work[l];
      }
      add_joint_impulses(0.5);
    }
    for (std::size_t l = 0; l < kLanes; ++l)
      if (wanted[l] && strikes(l)) fails[l] = !strike(l);
  }

 private:
  /// A blow, of one island alone: its tables are lent what it needs.
  bool strike(std::size_t l) {
    const LaneIsland& own = island(l);
    for (std::size_t c = 0; c < t_.count; ++c) {
      double* const memory = column(own.view.memory, kMemoryRows, c);
      double* const work = column(own.view.work, kWorkRows, c);
      for (std::size_t i = 0; i < 9; ++i)
        memory[(kMove + i) * kLanes] = t_.memory_at(c)[(kMove + i) * kLanes + l];
      for (std::size_t i = 0; i < 3; ++i)
        work[(kEndReach + i) * kLanes] = t_.work_at(c)[(kEndReach + i) * kLanes + l];
      for (std::size_t i = 0; i < kNodeSize; ++i)
        own.view.nodes[kNodeSize * c + i] = t_.node_at(c)[i * kLanes + l];
      for (std::size_t i = 0; i < kTieFactor; ++i)
        own.factors[kTieFactor * c + i] = t_.tie_factor_at(c)[i * kLanes + l];
    }
    if (!own.strike(own.context)) return false;
    for (std::size_t c = 0; c < t_.count; ++c)
      for (std::size_t i = 0; i < 9; ++i)
        t_.memory_at(c)[(kMove + i) * kLanes + l] =
            column(own.view.memory, kMemoryRows, c)[(kMove + i) * kLanes];
    return true;
  }

  bool tautened_[kLanes] = {};
};

}  // namespace
}  // namespace pantin::detail::articulated
