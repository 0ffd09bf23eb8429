// Limits, cables and unilateral surface joints: one row each, with events, impacts and release.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Slower impacts are inelastic, m/s or rad/s.
constexpr Real kRestitutionThreshold = 1e-3;
/// m/s: impulses that change speeds by less are ignored.
constexpr Real kNoSpeed = 1e-9;
/// Fraction of a step: limits and cables that are reached within this time are hit together. On
/// symmetric mechanisms rounding alone would decide which is hit first.
constexpr Real kTogether = 1e-3;
/// Impacts per step with restitution; later ones are inelastic (Zeno behaviour).
constexpr int kMaxBounces = 4;
/// Hits of one limit in a step after which an impact leaves it closed.
constexpr int kMostHits = 2;
/// Fraction of the force at the start: the multiplier counts as 0.
constexpr Real kLiftTolerance = 1e-6;
/// Bounds on bisections for the time at which a pair changes, on events per step, on search steps
/// per event, on attempts per step, on retries with penetrating contacts held, and on sweeps per
/// step.
constexpr int kMaxCuts = 26, kMaxEvents = 40, kMaxSearches = 16, kMaxAttempts = 60, kMaxHolds = 4,
              kMaxSweeps = 24;

/// Least clearance of the inactive limits, or slip speed left; negative if a limit is violated.
Real clearance(const Island& m) {
  Real least = 1e300;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_one_sided(m, i) && !m.memory[i].active)
      least = std::min(least, m.scratch.c[m.blocks[i].first_row]);
  for (std::size_t i = 0; m.rubs && i < m.blocks.size(); ++i)
    least = std::min(least, slip_left(m, i));
  return least;
}

/// Deactivates unilateral rows with a tensile multiplier. True if any was.
bool release_pulling(Island& m) {
  bool any = false;
  Real scale = 0;
  for (Real block_lambda : m.mean_lambda) scale = std::max(scale, std::abs(block_lambda));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_one_sided(m, i) || !m.memory[i].active) continue;
    if (m.mean_lambda[m.blocks[i].first_row] >= -1e-9 * scale) continue;
    m.memory[i].active = false, any = true;
  }
  return any;
}

/// Releases rows that pull and friction that would exceed mu N. True if any was.
bool give_way(Island& m) {
  const bool pulled = release_pulling(m);
  return yield_holding(m, m.mean_lambda) || pulled;
}

/// Repeats the impact from scratch.start with the friction of slipping contacts, which depends on
/// the normal impulse being solved for.
void rub(Island& m, const std::vector<Real>& bias) {
  StepScratch& scratch = m.scratch;
  scratch.part_h = 0;
  aim_slips(m);
  for (SurfaceMemory& touch : m.touches) touch.projected = 0;
  std::fill(scratch.momenta.begin(), scratch.momenta.end(), Vec3(0));
  std::fill(scratch.step_lambda.begin(), scratch.step_lambda.end(), 0.0);
  set_grips(m, scratch.step_lambda);
  settle_grips(m, 1, scratch.momenta, [&] {
    for (std::size_t b = 0; b < m.count(); ++b) {
      BodyState& at = scratch.body_states[b];
      at.velocity = scratch.state.v[b] = scratch.start.v[b] + scratch.momenta[2 * b] / m.mass[b];
      at.angular_velocity = scratch.state.w[b] =
          scratch.start.w[b] + scratch.inverse_inertia[b] * scratch.momenta[2 * b + 1];
    }
    project_twists(m, bias);
  });
}

/// Whether an impulse of a unilateral row or of friction exceeds `least`, N s.
bool any_hits(const Island& m, Real least) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    const bool may = is_one_sided(m, i) || may_slip(b);
    for (std::size_t r = 0; may && m.memory[i].active && r < b.rows; ++r)
      if (std::abs(m.scratch.lambda[b.first_row + r]) > least) return true;
  }
  return false;
}

/// Whether an inactive unilateral row has reached its bound.
bool is_reached(const Island& m, std::size_t i) {
  const Block& b = m.blocks[i];
  return is_one_sided(m, i) && !m.memory[i].active && m.scratch.c[b.first_row] <= kLimitTolerance &&
         !(b.kind == BlockKind::surface && m.scratch.touching[b.first_place].has_let_go);
}

/// Activates the bounds that are reached now or within BlowScratch::together. Returns whether any
/// is approached fast enough for an impact.
bool list_hit(const World& world, Island& m) {
  BlowScratch& s = m.scratch.blow;
  s.early.clear();
  bool blow = false;
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_one_sided(m, i) || m.memory[i].active) continue;
    const bool reached = is_reached(m, i), surface = m.blocks[i].kind == BlockKind::surface;
    if (surface && !reached) continue;
    const Real rate = surface ? 0 : opening_rate(world, m, i);
    if (!reached && m.scratch.c[m.blocks[i].first_row] > -rate * s.together) continue;
    m.memory[i].active = true;
    // A slow approach may be detected repeatedly until the active set settles; it is no impact.
    const bool strikes = surface || rate < -kRestitutionThreshold;
    ++(strikes ? s.hits : s.touches)[i];
    blow = blow || strikes;
    if (!reached) s.early.push_back(i);
    // Friction sticks at first.
    if (m.rubs && i + 1 < m.blocks.size() && m.blocks[i + 1].kind == BlockKind::roll)
      m.memory[i + 1].active = true;
  }
  return blow;
}

/// Rates after the impact at the limits that are hit, m/s or rad/s, by row.
void find_rates_after(const World& world, const Island& m, Impact kind, std::span<Real> bias) {
  std::fill(bias.begin(), bias.end(), 0.0);
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_one_sided(m, i) || !m.memory[i].active) continue;
    const Block& b = m.blocks[i];
    const Real rate = rate_of(m, b, 0);
    const Real bounce = b.kind == BlockKind::limit && kind == Impact::with_restitution
                            ? world.links.values()[b.source].joint.parameters->restitution
                            : 0;
    if (rate < -kRestitutionThreshold) bias[b.first_row] = -bounce * rate;
  }
}

}  // namespace

void resolve_impacts(const World& world, Island& m, Impact kind) {
  StepScratch& scratch = m.scratch;
  update_kinematics(m);
  const bool blow = list_hit(world, m);
  end_slips(m, kLimitTolerance);
  Real least = 0;  // N s
  for (const Real mass : m.mass) least += kNoSpeed * mass;
  std::vector<Real>& bias = scratch.sum_lambda;
  update_kinematics(m);
  write_all_rows(world, m, {true, false});
  find_rates_after(world, m, kind, bias);
  if (!m.rubs) choose_hit(world, m, bias);
  // Limits that are hit in turn at ever shorter intervals all stay active.
  const auto rests = [&](std::size_t i) {
    return is_one_sided(m, i) &&
           scratch.blow.hits[i] + (blow ? 0 : scratch.blow.touches[i]) > kMostHits &&
           scratch.c[m.blocks[i].first_row] <= kLimitTolerance;
  };
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (!m.rubs && rests(i)) m.memory[i].active = true;
  for (int round = 0; round < 8; ++round) {
    update_kinematics(m);
    write_all_rows(world, m, {true, false});
    factor(m);
    if (m.rubs) find_rates_after(world, m, kind, bias);
    scratch.start.v = scratch.state.v, scratch.start.w = scratch.state.w;
    project_twists(m, bias);
    // Without an impulse, friction would follow rounding errors.
    const bool rubs = m.rubs && any_hits(m, least);
    if (rubs) rub(m, bias);
    bool pulled = rubs && yield_holding(m, scratch.lambda, least);
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      if (!is_one_sided(m, i) || !m.memory[i].active) continue;
      const std::size_t row = m.blocks[i].first_row;
      const bool leaves = bias[row] > 0;
      if (scratch.lambda[row] < -least && (m.rubs || !rests(i)))
        m.memory[i].active = false, pulled = true;
      else if (leaves && round == 7)
        m.memory[i].active = false;
    }
    if (!pulled) {
      for (std::size_t r = 0; r < m.rows; ++r) scratch.impulses[r] += scratch.lambda[r];
      for (std::size_t i = 0; i < m.blocks.size(); ++i)
        if (is_one_sided(m, i) && bias[m.blocks[i].first_row] > 0) m.memory[i].active = false;
      if (!m.rubs)
        for (const std::uint32_t i : scratch.blow.resting) m.memory[i].active = true;
      return;
    }
    scratch.state.v = scratch.start.v, scratch.state.w = scratch.start.w;
  }
}

void hit(const World& world, Island& m) {
  ++m.events;
  resolve_impacts(world, m, m.events <= kMaxBounces ? Impact::with_restitution : Impact::inelastic);
  for (const std::uint32_t i : m.scratch.blow.early) m.memory[i].active = false;
  m.fresh = m.fresh || row_of(m.settings.integrator).keeps_accelerations;
}

void begin_active_set(const World& world, Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    m.memory[i].active =
        is_one_sided(m, i) && m.scratch.c[m.blocks[i].first_row] <= kLimitTolerance;
  write_all_rows(world, m, {true, false});
  begin_slips(m);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)  // a limit that is being left is inactive
    if (m.memory[i].active && rate_of(m, m.blocks[i], 0) > kRestitutionThreshold)
      m.memory[i].active = false;
}

namespace {

/// A substep that is being tried.
struct Substep {
  Real length = 0;      // s
  int sweeps = 0;       // of the step so far
  Real freed = 0;       // see until_let_go()
  bool turned = false;  // a pair of curves is replaced by another at its end
  // A contact that leaves its surface, why, and when, s after the start. It is released there.
  std::uint32_t lost = UINT32_MAX;
  nurbs::ContactStatus how = nurbs::ContactStatus::found;
  Real lost_at = 0;

  bool ends_in_loss() const { return lost != UINT32_MAX && length == lost_at; }
};

/// Bisects for the longest feasible substep up to `length`, s, and takes it. 0: none.
template <class Attempt>
Real until_failure(Island& m, const Attempt& attempt, Real length) {
  const Real row_residual = m.scratch.worst_relative_residual;
  Real low = 0, high = length;
  for (int n = 0; n < kMaxCuts; ++n) {
    const Real middle = 0.5 * (low + high);
    (attempt(middle) ? low : high) = middle;
  }
  m.scratch.worst_relative_residual = row_residual;  // attempts that are rejected do not count
  return low > 0 && attempt(low) ? low : 0;
}

/// Takes a substep, or as much of it as there is before a pair of curves is replaced by another, or
/// before a contact leaves its surface and is released: then it may have no length. False: failure.
template <class Attempt>
bool take_until_pair_ends(const World& world, Island& m, const Attempt& attempt, Substep& part) {
  if (attempt(part.length)) return true;
  if (may_turn_over(world, m))
    part.turned = true;
  else if (may_release(world, m))
    part.lost = m.scratch.lost_touch, part.how = m.scratch.lost_how;
  else
    return false;
  part.length = part.lost_at = until_failure(m, attempt, part.length);
  return part.turned ? part.length > 0 : true;
}

/// Times that bracket the zero of a function that falls from above 0 to below: regula falsi,
/// Illinois variant.
struct Bracket {
  Real low = 0, high = 0, at_low = 0, at_high = 0;
  int side = 0;  // end that was replaced last

  Real crossing() const { return low + (high - low) * at_low / (at_low - at_high); }
  void narrow(Real time, Real value) {
    if (value < 0) {
      high = time, at_high = value;
      if (side < 0) at_low *= 0.5;
      side = -1;
    } else {
      low = time, at_low = value;
      if (side > 0) at_high *= 0.5;
      side = 1;
    }
  }
};

/// `of` is the substep being tried. If a unilateral row presses at its start and pulls in the mean,
/// or friction sticks at its start and exceeds mu N in the mean, finds the time of the change, s,
/// and takes the substep up to it. Else 0.
template <class Attempt>
Real until_let_go(const World& world, Island& m, const Span& of, const Attempt& attempt) {
  StepScratch& scratch = m.scratch;
  const auto left = [&](Real at) {
    return least_left(world, m, (of.from + at) / of.whole, of.whole);
  };
  Bracket times{0, of.h, 0, left(of.h)};
  scratch.state = scratch.begin;
  times.at_low = left(0);
  if (!(times.at_low > 0 && times.at_high < 0)) return 0;
  const Real enough = kLiftTolerance * times.at_low;
  for (int n = 0; n < kMaxSearches && times.at_high < -enough; ++n) {
    const Real middle = times.crossing();
    if (!attempt(middle)) return 0;
    times.narrow(middle, left(middle));
  }
  return attempt(times.high) ? times.high : 0;
}

/// A substep: the clearance at its start, its length, s, and the resolution of times, s.
struct Part {
  Real at_start = 0, length = 0, alike = 0;
};
/// The time of the first event in a substep that has been taken, s, where a bound is crossed at its
/// end or before; takes the step up to it. No event: the whole length. 0: failure.
template <class Attempt>
Real until_event(const World& world, Island& m, const Part& part, const Attempt& attempt) {
  const Real at_end = clearance(m);
  const Passing passing = find_passing(world, m, part.length);
  const bool known = passing.guess <= 1;
  if (part.at_start < -kLimitTolerance || (!known && at_end >= -kLimitTolerance))
    return part.length;
  Bracket times{0, part.length, std::max(part.at_start, kLimitTolerance), at_end};
  if (known)
    times = {passing.low * part.length, passing.high * part.length, passing.at_low, at_end};
  if (known && passing.high < 1) {
    if (!attempt(times.high)) return 0;
    times.at_high = clearance(m);
    if (times.at_high >= -kLimitTolerance) return attempt(part.length) ? part.length : 0;
  }
  Real length = known ? passing.guess * part.length : times.crossing();
  for (int n = 0; n < kMaxSearches && times.high - times.low > part.alike; ++n) {
    if (!attempt(length)) {
      if (!may_turn_over(world, m)) return 0;
      times.high = length, times.at_high = -times.at_low, times.side = 0;
    } else {
      const Real left = clearance(m);
      if (std::abs(left) <= kLimitTolerance) return length;
      times.narrow(length, left);
    }
    length = times.crossing();
  }
  return attempt(times.high) ? times.high : 0;
}

/// Length of substeps where joints have cones. Thin rods that slide along a cone whip about their
/// axes within milliseconds. Longer substeps would miss bounds that are crossed and left again.
class Pace {
 public:
  Pace(const Island& m, Real h) : m_(m), h_(h), longest_(h) {
    for (const Block& b : m.blocks)
      bounds_ = bounds_ || (b.kind == BlockKind::limit && b.coordinate == Coordinate::swing);
  }
  bool bounds() const { return bounds_; }
  /// Longest substep, s, when `left` remains of the step.
  Real longest(Real left) const { return left - longest_ < kRest * h_ ? left : longest_; }
  /// Shortens a substep until no angular velocity changes by much in it. False: one failed.
  template <class Take>
  bool shorten(const Take& take, Real& length) {
    if (!bounds_) return true;
    const Real shortest = h_ / kParts, most = kBent * h_;
    Real bent = bent_in(length);
    for (int n = 0; n < kTries && bent > most && length > shortest; ++n) {
      length = std::max(shortest, length * std::clamp(0.8 * std::sqrt(most / bent), 0.1, 0.7));
      if (!take()) return false;
      bent = bent_in(length);
    }
    longest_ = length * (bent > 0 ? std::clamp(0.9 * std::sqrt(most / bent), 0.2, 3.0) : 3.0);
    return true;
  }

 private:
  /// Largest change of angular velocity times the substep, rad/s times the step; most substeps per
  /// step; smallest remainder, as a fraction of the step.
  static constexpr Real kBent = 0.12, kParts = 256, kRest = 1e-3;
  static constexpr int kTries = 8;

  Real bent_in(Real length) const {
    Real most = 0;
    for (std::size_t b = 0; b < m_.count(); ++b)
      most = std::max(most, glm::length(m_.scratch.state.w[b] - m_.scratch.begin.w[b]));
    return most * length;
  }

  const Island& m_;
  Real h_, longest_;
  bool bounds_ = false;
};

/// Records the gaps at the start of a step; no limit has been hit yet.
void note_start(Island& m, Real h) {
  BlowScratch& s = m.scratch.blow;
  s.together = kTogether * h;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    s.gap_before[i] = m.scratch.c[m.blocks[i].first_row], s.hits[i] = s.touches[i] = 0;
}

/// Whether a limit is reached, or a slip has ended.
bool any_reached(const Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_reached(m, i) || has_slip_ended(m, i, kLimitTolerance)) return true;
  return false;
}

/// Cuts a substep that was taken where surfaces meet at an untracked pair.
template <class Attempt>
bool end_where_met(const World& world, Island& m, const Attempt& attempt, Substep& part) {
  const auto is_clear = [&](Real length) {
    return attempt(length) && first_untracked_contact(world, m) > 1;
  };
  for (; part.sweeps < kMaxSweeps && !part.turned; ++part.sweeps) {
    const Real met = first_untracked_contact(world, m);
    if (met > 1) break;
    part.freed = 0;
    const Real seen = met < 1 ? 0 : until_failure(m, is_clear, part.length);
    part.turned = seen > 0, part.length = part.turned ? seen : met * part.length;
    if (part.turned) break;
    if (!attempt(part.length)) return false;
    if (met == 1) break;
  }
  return true;
}

}  // namespace

bool advance_among_limits(World& world, Island& m, Real h) {
  StepScratch& scratch = m.scratch;
  Real done = 0;
  int attempts = 0, sweeps = 0, events = 0;
  Pace pace(m, h);
  // After kMaxEvents the remainder is taken in one piece.
  for (int tries = 0; done < h * (1 - 1e-12); ++tries) {
    update_kinematics(m), update_frames(world, m, done / h, h);
    write_all_rows(world, m, {true, false});
    if (!begin_on_bounds(world, m, {done, 0, h})) return false;
    if (tries == 0) note_start(m, h);
    scratch.begin = scratch.state, scratch.impulses_before = scratch.impulses;
    scratch.lambda_before = m.mean_lambda;
    const int rescues = m.rescues;
    note_bounds(world, m, h - done);
    update_slip_directions(m, h - done), note_openings(m), note_sweep(world, m);
    const Real at_start = clearance(m);
    Substep part{pace.longest(h - done), sweeps};
    bool again = false;
    const auto attempt = [&](Real length) {
      ++attempts;
      scratch.state = scratch.begin, scratch.impulses = scratch.impulses_before;
      scratch.pulled_at = 1e300;
      // An attempt must be a function of its length alone: the bisection for the end of a pair
      // relies on that.
      const bool alike = again && (scratch.turned_over > 0 || part.lost != UINT32_MAX);
      if (alike) m.mean_lambda = scratch.lambda_before;
      if (alike || m.touches.empty()) m.rescues = rescues;  // surfaces: Euler keeps the step
      m.fresh = m.fresh || again, again = true;
      return advance(world, m, {done, length, h});
    };
    Real &length = part.length, &freed = part.freed;
    const auto take = [&] {
      const int counted = attempts + 1;
      const bool good = take_until_pair_ends(world, m, attempt, part);
      if (part.turned || part.lost != UINT32_MAX) attempts = counted;  // a bisection counts as one
      return good;
    };
    if (!take()) return false;
    if (length == 0) {
      release(world, m, part.lost, part.how);
      continue;
    }
    if (!part.turned && !part.ends_in_loss() && !pace.shorten(take, length)) return false;
    note_ends(m, done + length);
    if (!part.turned && attempts < kMaxAttempts && scratch.pulled_at < 1e300) {
      const Real until = std::min(scratch.pulled_at - done, length);
      if (until < length && !attempt(until)) return false;
      freed = until_let_go(world, m, {done, until, h}, attempt);
      if (freed > 0) length = freed;
      // A contact whose multiplier is tensile at the start of the step is released there.
      if (freed == 0 && until < length && attempt(until)) give_way(m);
      if (freed == 0 && !take()) return false;
    }
    for (int n = 0; n < 16 && (freed > 0 ? yield_holding(m, m.mean_lambda) : give_way(m)); ++n)
      if (!take()) return false;
    if (!end_where_met(world, m, attempt, part)) return false;
    sweeps = part.sweeps;
    if (!project_penetrations(world, m, {done, length, h})) return false;
    if (events < kMaxEvents && attempts < kMaxAttempts) {
      length = until_event(world, m, {at_start, length, 1e-12 * h}, attempt);
      if (length == 0) return false;
    }
    for (int n = 0; n < kMaxHolds && clearance(m) < -kLimitTolerance && activate_penetrating(m);
         ++n)
      if (!attempt(length)) return false;
    done += length;
    if (freed == length) let_go(world, m, done / h, h);
    if (part.ends_in_loss()) release(world, m, part.lost, part.how);
    if (part.turned) look_for_touches(world, m, h), write_all_rows(world, m, {true, false});
    if (pace.bounds()) attempts = 0;
    if (!any_reached(m)) continue;
    ++events;
    hit(world, m);
    update_frames(world, m, done / h, h);
    if (!project(world, m, done / h, h)) return false;
  }
  return true;
}

}  // namespace pantin::detail::lagrangian
