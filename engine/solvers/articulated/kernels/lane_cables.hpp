#pragma once
/// Cables in a step by the energy-momentum method, vectorised over islands, one per lane: the
/// counterpart of the hooks of conserving_ties.cpp. Lanes whose equations need more than one row
/// for a cable fail, and are stepped alone.
#include "engine/solvers/articulated/kernels/lane_response.hpp"

namespace pantin::detail::articulated {
namespace {

class LaneCables : public LaneResponse {
 public:
  using LaneResponse::LaneResponse;

  /// Before an elimination: adds the cables to the blocks, at the iterate.
  void load() {
    for (std::size_t c = 0; c < t_.count; ++c)
      for (std::size_t n = 0; n < (all_.ties->grounded[c] ? kTieBlock : kTieLoads); ++n)
        store(t_.tie_block_at(c) + n * kWide, all<Lane>(0));
    bool may_change[kWide];
    for (std::size_t l = 0; l < kWide; ++l) {
      may_change[l] = runs(l), tautened_[l] = false;
      if (runs(l)) ++*island(l).iterations;
    }
    for (std::size_t n = 0; n < count(); ++n) {
      look_at(n);
      if (!tie(n).stretches) {
        const Mask asked = has_to_change(n);
        for (std::size_t l = 0; any(asked) && l < kWide; ++l) {
          if (!may_change[l] || !asked[l]) continue;
          change(n, l), may_change[l] = *island(l).iterations <= kChangeAtOnce;
          tautened_[l] = tautened_[l] || kind(n, l) == kTautTie;
        }
      }
      double* const k = at(n);
      const Vec<Lane> before = vec<Lane>(k, kCableMu);
      if (tie(n).stretches) {
        const CableLoad<Vec<Lane>, Lane> now = load_of(n);
        put(k, kCableMu, t_.kept(now.mu, before));
        for (std::size_t i = 0; i < 3; ++i) put(k, kCableDerivative + 3 * i, now.derivative[i]);
        write(k + kCableAcross * kWide, now.across);
      } else {
        const auto [mu, across] = load_of_taut(span_of(k), before);
        write(k + kCableAcross * kWide, across);
        put(k, kCableMu, t_.kept(chosen(taut(n), mu, before), before));
        if (tie(n).a == kNoColumn) {
          Vec<Lane> columns[3];
          turn_taut(choose(taut(n), across, all<Lane>(0)), columns);
          for (std::size_t i = 0; i < 3; ++i) put(k, kCableDerivative + 3 * i, columns[i]);
        }
      }
      const Vec<Lane> mu = vec<Lane>(k, kCableMu);
      add_to_block(tie(n).b, mu, vec<Lane>(k, kCableMeanB), vec<Lane>(k, kCableEndB));
      if (tie(n).a != kNoColumn)
        add_to_block(tie(n).a, -1.0 * mu, vec<Lane>(k, kCableMeanA), vec<Lane>(k, kCableEndA));
      else
        add_grounded(n);
    }
  }

  /// After an elimination: solves for the impulses of the cables.
  void correct(bool (&fails)[kWide]) {
    for (std::size_t n = 0; n < count(); ++n) {
      const Lane acts =
          tie(n).stretches ? choose(grounded(n), all<Lane>(0), ones(stretched(n))) : ones(taut(n));
      write(at(n) + kCableActs * kWide, acts);
      if (any(acts > 0.5)) put_row(n);
    }
    const bool any = answer({LaneArms::mean, t_.running}, fails);
    for (std::size_t r = 0; any && r < rows_; ++r) {
      double* const k = at(row(r));
      const Vec<Lane> mu = vec<Lane>(k, kCableMu);
      put(k, kCableMu, t_.kept(mu + gain(r) * vec<Lane>(k, kCableDirection), mu));
    }
    for (std::size_t n = 0; n < count(); ++n) {
      if (tie(n).a != kNoColumn) continue;
      double* const k = at(n);
      const Vec<Lane> derivative[3] = {vec<Lane>(k, kCableDerivative),
                                       vec<Lane>(k, kCableDerivative + 3),
                                       vec<Lane>(k, kCableDerivative + 6)};
      const Vec<Lane> mu = vec<Lane>(k, kCableMu),
                      now = mu + times_vector(derivative, change_of(n));
      put(k, kCableMu, t_.kept(chosen(grounded(n), now, mu), mu));
    }
    for (std::size_t l = 0; l < kWide; ++l)
      if (runs(l) && !fails[l] && tautened_[l] && island(l).is_hit_early(island(l).context))
        fails[l] = true;
    if (any) add_joint_impulses(1.0);
  }

  /// After convergence: clears `near` in lanes in which a cable still has to change.
  void settle(bool (&near)[kWide]) {
    for (std::size_t n = 0; n < count(); ++n) {
      look_at(n);
      const Mask asked = tie(n).stretches ? is_not_followed(n) : has_to_change(n);
      for (std::size_t l = 0; any(asked) && l < kWide; ++l) {
        if (!near[l] || !asked[l]) continue;
        if (!tie(n).stretches) change(n, l);
        near[l] = false;
      }
    }
  }

  /// After the iterations: whether the step of a lane is accepted.
  bool accept(std::size_t l, double& released) {
    const LaneIsland& own = island(l);
    double most = 0, work = 0;
    for (std::size_t n = 0; n < count(); ++n) {
      const double* const k = at(n);
      const Vec<Lane> mu = vec<Lane>(k, kCableMu);
      const Vec<Lane> way = vec<Lane>(k, kCableBefore) - vec<Lane>(k, kCableNow);
      released += (2.0 / h_ * dot(mu, way))[l];
      work -= (2.0 / h_ * dot(mu, vec<Lane>(k, kCableWay)))[l];
      const double over = ::fabs(over_of(k)[l]);
      if (!tie(n).stretches && kind(n, l) == kTautTie && over > most) most = over;
    }
    *own.place_work = work;
    return most <= kAccepted * own.size && !own.ends_early(own.context);
  }

  /// Projects the end velocities of the wanted lanes to those that the cables allow.
  void project(const bool (&wanted)[kWide], bool (&fails)[kWide]) {
    Solve solve{LaneArms::end, all<Lane>(0)};
    for (std::size_t l = 0; l < kWide; ++l) solve.asked[l] = wanted[l] && !strikes(l);
    for (std::size_t n = 0; n < count(); ++n) {
      double* const k = at(n);
      const Vec<Lane> direction = unit_of(vec<Lane>(k, kCableNow));
      write(k + kCableSoftness * kWide, all<Lane>(0));
      put(k, kCableDirection, direction), put(k, kCableBy, direction);
      write(k + kCableRight * kWide, dot(direction, vec<Lane>(k, kCableVelocity)));
      write(k + kCableActs * kWide, tie(n).stretches ? all<Lane>(0) : ones(taut(n)));
    }
    if (answer(solve, fails)) {
      for (std::size_t r = 0; r < rows_; ++r) {
        const double* const k = at(row(r));
        const Vec<Lane> mu = gain(r) * vec<Lane>(k, kCableDirection);
        // Half of the projection's impulses counts in the mean over the step.
        const Lane work = dot(mu, vec<Lane>(k, kCableVelocity));
        for (std::size_t l = 0; l < kWide; ++l)
          if (solve.asked[l] > 0.5 && acts(row(r), l)) *island(l).place_work -= work[l];
      }
      add_joint_impulses(0.5);
    }
    for (std::size_t l = 0; l < kWide; ++l)
      if (wanted[l] && strikes(l)) fails[l] = !strike(l);
  }

 private:
  /// An impact, of one island alone: copies the lane to the island's own tables and back.
  bool strike(std::size_t l) {
    const LaneIsland& own = island(l);
    for (std::size_t c = 0; c < t_.count; ++c) {
      double* const memory = column(own.view.memory, kMemoryRows, c);
      double* const work = column(own.view.work, kWorkRows, c);
      for (std::size_t i = 0; i < 9; ++i)
        memory[(kMove + i) * kLanes] = t_.memory_at(c)[(kMove + i) * kWide + l];
      for (std::size_t i = 0; i < 3; ++i)
        work[(kEndReach + i) * kLanes] = t_.work_at(c)[(kEndReach + i) * kWide + l];
      for (std::size_t i = 0; i < kNodeSize; ++i)
        own.view.nodes[kNodeSize * c + i] = t_.node_at(c)[i * kWide + l];
      for (std::size_t i = 0; i < kTieFactor; ++i)
        own.factors[kTieFactor * c + i] = t_.tie_factor_at(c)[i * kWide + l];
    }
    if (!own.strike(own.context)) return false;
    for (std::size_t c = 0; c < t_.count; ++c)
      for (std::size_t i = 0; i < 9; ++i)
        t_.memory_at(c)[(kMove + i) * kWide + l] =
            column(own.view.memory, kMemoryRows, c)[(kMove + i) * kLanes];
    return true;
  }

  bool tautened_[kWide] = {};
};

}  // namespace
}  // namespace pantin::detail::articulated
