// Advances by the chosen integrator: halves steps that are too long, controls the error if a
// tolerance is set, falls back to Euler where nothing else works.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kMaxHalvings = 6, kMaxSteps = 200000;
/// A substep that needs more divisions than this fails.
constexpr int kMaxSubsteps = 1000;
/// Constraint drift of a Runge-Kutta step that projection may correct, relative to the displacement
/// of the bodies.
constexpr Real kMaxOpening = 0.05;
/// Euler steps before the integrator is retried, and halvings allowed for the retry.
constexpr int kPatience = 8, kRetries = 3;
/// Largest rotation per step, rad; larger ones halve the step, except with the implicit integrator.
/// Of islands without joints, whose steps cost little.
constexpr Real kMaxRotation = 0.5, kMaxFreeRotation = 0.2;
/// Moments of inertia with a smaller relative difference are equal.
constexpr Real kAlike = 1e-6;
/// Fraction of a step. In a shorter substep, up to an event, multipliers of poses consist of
/// rounding errors, which would disturb speeds and friction; Euler takes such a substep.
constexpr Real kShortest = 1e-3;
/// Energy error of a symplectic integrator between impacts, relative to the permitted drift.
constexpr Real kReturned = 10;
/// Energy that may stay unpaid in a step, relative to all weight falling by the size of the island.
constexpr Real kUnpaidEnergy = 1e-10;
/// Fraction of its kinetic energy that the projection may add to a free island.
constexpr Real kFreeGain = 1e-9;

/// Whether the drift is small compared with the displacement of the bodies. A high-order step with
/// larger drift passes near a singular configuration and may end on another branch.
bool keeps_joints(const Island& m, Real h) {
  Real speed = 0;
  for (const BodyState& b : m.scratch.body_states)  // frames too
    speed = std::max(speed, glm::length(b.velocity) + m.reach * glm::length(b.angular_velocity));
  return m.scratch.opened <= std::max({kMaxOpening * h * speed, 1e-9 * m.size, tolerance_of(m)});
}

void add_impulses(Island& m, Real h) {
  for (std::size_t r = 0; r < m.rows; ++r) m.scratch.impulses[r] += h * m.mean_lambda[r];
}

/// If the projection is part of the motion, it supplies the normal forces that bend the twists
/// along curved surfaces, and side forces that turn blades. They count in whether contacts are
/// tensile, and in friction.
void add_projected_forces(Island& m, Real h) {
  for (const Block& b : m.blocks) {
    const bool counts = b.kind == BlockKind::joint && (may_slip(b) || b.carries);
    for (std::size_t r = 0; counts && r < b.rows; ++r)
      m.mean_lambda[b.first_row + r] += m.scratch.lambda[b.first_row + r] / h;
    if (b.carrier != UINT32_MAX)
      m.touches[b.first_place].projected = load_of(m, b, m.scratch.lambda) / h;
    if (b.kind != BlockKind::surface) continue;
    const Real force = m.scratch.lambda[b.first_row] / h;
    if (!b.lock || m.rubs) m.mean_lambda[b.first_row] += force;
    m.touches[b.first_place].projected = force;
  }
}

/// One integrator step with projection. False: it failed.
bool integrate(const World& world, Island& m, const Span& span, const IntegratorRow& by) {
  PANTIN_ASSERT(!(span.h < 0) && span.whole > 0);
  m.scratch.lost_touch = UINT32_MAX, m.scratch.part_h = span.h;
  set_grips(m, m.mean_lambda);
  for (SurfaceMemory& touch : m.touches)
    if (!by.projection_moves && !by.projection_presses) touch.projected = 0;
  const bool done = by.step(world, m, span);
  ++m.substeps;
  if (!done || m.scratch.lost_touch != UINT32_MAX || !all_within_bounds(m)) return false;
  m.fresh = false;
  add_impulses(m, span.h);
  // RATTLE ends on the constraints up to rounding.
  if (by.ends_on_joints && m.residual <= tolerance_of(m)) {
    note_pulls(m, span);
    return true;
  }
  if (m.settings.stabilisation == Stabilisation::projection) {
    const bool moves = by.projection_moves;
    const Real kinetic = moves ? kinetic_energy(m, m.scratch.state) : 0;
    m.scratch.projection_moves = moves;
    const bool closed = project(world, m, span.fraction(1), span.whole);
    m.scratch.projection_moves = false;
    if (moves || (m.rubs && by.projection_presses)) add_projected_forces(m, span.h);
    note_pulls(m, span);
    return closed && m.scratch.lost_touch == UINT32_MAX && all_within_bounds(m) &&
           (!by.may_open_joints || keeps_joints(m, span.h)) &&
           (!moves || remove_projection_energy(m, kinetic));
  }
  update_kinematics(m), update_frames(world, m, span.fraction(1), span.whole);
  write_all_rows(world, m, {true, false});
  m.residual = worst_residual(m);
  return all_within_bounds(m);
}

/// Steps with an error estimate, each within the tolerance. False: they became too small.
bool integrate_adaptively(const World& world, Island& m, const Span& span,
                          const IntegratorRow& by) {
  PANTIN_ASSERT(by.step_estimated);
  const Real goal = m.settings.step_tolerance;
  Real done = 0, h = m.try_step > 0 ? m.try_step : span.h / 16;
  for (int n = 0; done < span.h * (1 - 1e-14); ++n) {
    if (n > kMaxSteps || h < 1e-12 * span.h) return false;
    const bool last = done + h > span.h * (1 - 1e-12);
    const Real now = last ? span.h - done : h;
    m.scratch.start = m.scratch.state;
    const Real row_residual = m.scratch.worst_relative_residual;
    Real error = 0;
    m.scratch.lost_touch = UINT32_MAX, m.scratch.part_h = now;
    set_grips(m, m.mean_lambda);
    const Span part{span.from + done, now, span.whole};
    bool good = by.step_estimated(world, m, part, error);
    ++m.substeps;
    const Real factor_of =
        good ? 0.9 * std::pow(goal / std::max(error, 1e-300), 1.0 / by.estimate_order)
             : by.after_failure;
    good = good && error <= goal && m.scratch.lost_touch == UINT32_MAX;
    if (good && m.settings.stabilisation == Stabilisation::projection)
      good = project(world, m, part.fraction(1), span.whole) && m.scratch.lost_touch == UINT32_MAX;
    if (good) {
      add_impulses(m, now), note_pulls(m, part);
      done += now, m.fresh = false;
      if (!last || factor_of < 1) h = now * std::clamp(factor_of, 0.2, 5.0);
    } else {
      m.scratch.state = m.scratch.start, m.scratch.worst_relative_residual = row_residual;
      h = now * std::clamp(factor_of, 0.1, 0.7);
    }
  }
  m.try_step = h;
  return true;
}

/// Energy check for islands where only weight does work: a step that changes the energy is too
/// long.
class EnergyWatch {
 public:
  EnergyWatch(const World& world, const Island& m, const IntegratorRow& by) : world_(world), m_(m) {
    watches_ = by.keeps_energy_to > 0 && !m.scratch.pushed && m.joint_forces.empty() &&
               m.joint_torques.empty() && m.elastic_cables.empty() && m.elastic_pins.empty() &&
               m.elastic_paths.empty() && !m.rubs && !m.blocks.empty() && m.scratch.frames_rest;
    if (watches_) begin();
  }
  void begin() {
    if (watches_) kinetic_ = kinetic_energy(m_, m_.scratch.state), height_ = work_of_weight();
  }
  /// Whether energy is conserved since begin().
  bool keeps(const IntegratorRow& by) const {
    if (!watches_) return true;
    const Real now = kinetic_energy(m_, m_.scratch.state);
    const Real gained = now - kinetic_ - (work_of_weight() - height_);
    Real weight = 0;
    for (std::size_t b = 0; b < m_.count(); ++b)
      weight += m_.mass[b] * std::abs(m_.gravity_scale[b]);
    weight *= glm::length(world_.gravity);
    const Real part = by.keeps_energy_to * (by.returns_energy && !m_.unilateral ? kReturned : 1);
    const Real most = part * (std::max(now, kinetic_) + weight * m_.size);
    return gained <= most && (m_.damped || gained >= -most);
  }

 private:
  /// Work of weight from the origin to the current positions, J.
  Real work_of_weight() const {
    Real sum = 0;
    for (std::size_t b = 0; b < m_.count(); ++b)
      sum += m_.mass[b] * m_.gravity_scale[b] * glm::dot(world_.gravity, m_.scratch.state.x[b]);
    return sum;
  }

  const World& world_;
  const Island& m_;
  Real kinetic_ = 0, height_ = 0;
  bool watches_ = false;
};

Real fastest_rotation(const Island& m) {
  Real most = 0;
  for (const Vec3& w : m.scratch.state.w) most = std::max(most, glm::dot(w, w));
  return std::sqrt(most);
}

/// Largest angular speed that a free body can reach, rad/s, from its momentum and its energy
/// [Poinsot]. It is at one end of the curve of its angular velocity `w`, body axes, where a
/// component is 0.
Real fastest_of_free(Vec3 w, Vec3 inertia) {
  const Real energy = glm::dot(w, inertia * w), momentum = glm::dot(inertia * w, inertia * w);
  Real most = glm::dot(w, w);
  for (int k = 0; k < 3; ++k) {
    const Real p = inertia[(k + 1) % 3], q = inertia[(k + 2) % 3];
    if (!(std::abs(p - q) > kAlike * (p + q))) continue;
    const Real first = (momentum - q * energy) / (p * (p - q)),
               second = (p * energy - momentum) / (q * (p - q));
    if (first >= 0 && second >= 0) most = std::max(most, first + second);
  }
  return std::sqrt(most);
}

/// The largest in islands without joints: invariant, so that every step has the same divisions.
Real fastest_free_rotation(const Island& m) {
  Real most = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    most = std::max(
        most,
        fastest_of_free(glm::conjugate(m.scratch.state.q[b]) * m.scratch.state.w[b], m.inertia[b]));
  return most;
}

/// An integrator, how often it may halve a step that fails, and the bound on substeps in all.
struct Attempt {
  const IntegratorRow& by;
  int most_halvings, most_substeps;
};

/// Whether Runge-Kutta takes over steps of loops near singular configurations.
bool can_pass_singular(const Island& m, const IntegratorRow& by) {
  return by.takes_means && m.loops && m.touches.empty();
}

/// Whether pins, drives and soft stops are explicit forces. The collocation method has rows for
/// them; Euler takes them as at the end of the step.
bool takes_as_forces(const IntegratorRow& by) {
  return !by.collocates && &by != &integrators::euler;
}

/// Stiffness of the forces that an integrator takes explicitly.
Stiffness explicit_stiffness(const World& world, const Island& m, const IntegratorRow& by) {
  const Stiffness joints = by.efforts_are_forces ? stiffness_of(world, m) : Stiffness{};
  if (!takes_as_forces(by)) return joints;
  const Stiffness pins = stiffness_of_pins(world, m), torques = stiffness_of_torques(world, m);
  return {std::max({joints.spring, pins.spring, torques.spring}),
          std::max({joints.damper, pins.damper, torques.damper})};
}

/// Advances by one integrator, halving the step where it fails.
bool advance_by(const World& world, Island& m, const Span& span, const Attempt& attempt) {
  const IntegratorRow& by = attempt.by;
  const bool bound = !by.turns_far;
  const Real fastest = !bound             ? 0
                       : m.blocks.empty() ? fastest_free_rotation(m)
                                          : fastest_rotation(m);
  // Euler adds no energy, whatever the travel of contact points.
  const bool watched = !m.touches.empty() && &by != &integrators::euler;
  const Real most_turned = m.blocks.empty() ? kMaxFreeRotation : kMaxRotation;
  EnergyWatch energy(world, m, by);
  int substeps = 1;
  while (substeps < kMostParts && fastest * span.h > most_turned * substeps) substeps *= 2;
  const bool any_forces = !m.elastic_pins.empty() || !m.joint_torques.empty();
  if ((!m.joint_forces.empty() && by.efforts_are_forces) || (any_forces && takes_as_forces(by))) {
    update_kinematics(m), update_frames(world, m, span.fraction(0), span.whole);
    const Stiffness stiff = explicit_stiffness(world, m, by);
    while (substeps < kMostParts && stiff.is_long(span.h / substeps)) substeps *= 2;
    if (stiff.is_long(span.h / substeps)) return false;
  }
  for (int halvings = 0;; substeps *= 2) {
    bool good = true;
    for (int i = 0; i < substeps && good; ++i) {
      if (watched) note_touches(world, m);
      energy.begin();
      good = integrate(world, m, {span.from + i * span.h / substeps, span.h / substeps, span.whole},
                       by) &&
             (substeps >= kMostParts ||
              ((!bound || fastest_rotation(m) * span.h <= 2 * most_turned * substeps) &&
               energy.keeps(by) && !(watched && touches_leap(world, m, span.h / substeps))));
    }
    if (good) return true;
    m.scratch.state = m.scratch.start, m.scratch.impulses = m.scratch.impulses_at_start;
    m.scratch.pulled_at = 1e300;
    std::fill(m.mean_lambda.begin(), m.mean_lambda.end(), 0.0);
    m.fresh = true;
    // Shorter substeps arrive there, too.
    if (m.scratch.beside_singular) return false;
    if (m.scratch.lost_touch != UINT32_MAX &&
        m.scratch.lost_how == nurbs::ContactStatus::degenerate)
      return false;
    if (++halvings > attempt.most_halvings || m.substeps > attempt.most_substeps) return false;
  }
}

/// Last resort: joints may stay open a little and angular velocities are bounded. If that fails
/// too, the step starts from rest, and at last for a fraction of its length only.
bool advance_loosely(const World& world, Island& m, const Span& span) {
  Motions& s = m.scratch.state;
  for (Vec3& w : s.w)
    if (const Real rotation = glm::length(w) * span.h; rotation > 1) w /= rotation;
  if (integrate(world, m, span, integrators::euler)) return true;
  for (const Real part : {1.0, 0.1, 0.01}) {
    s = m.scratch.start, m.scratch.impulses = m.scratch.impulses_at_start;
    std::fill(s.v.begin(), s.v.end(), Vec3(0)), std::fill(s.w.begin(), s.w.end(), Vec3(0));
    const Span late{span.from + (1 - part) * span.h, part * span.h, span.whole};
    if (integrate(world, m, late, integrators::euler)) return true;
  }
  return false;
}

}  // namespace

Real kinetic_energy(const Island& m, const Motions& s) {
  Real twice = 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 v = s.v[b], w = glm::conjugate(s.q[b]) * s.w[b];
    twice += m.mass[b] * glm::dot(v, v) + glm::dot(w, m.inertia[b] * w);
  }
  return 0.5 * twice;
}

bool remove_projection_energy(Island& m, Real before) {
  StepScratch& scratch = m.scratch;
  const bool is_free = scratch.pattern.framed.empty();
  if (!is_free && !scratch.frames_rest) return true;
  const Real now = kinetic_energy(m, scratch.state);
  if (is_free && m.rescues == 0) return now <= (1 + kFreeGain) * before;
  const Real due = before + scratch.projection_work;
  if (now <= due) return true;
  Real weight = 0;
  for (std::size_t b = 0; b < m.count(); ++b) weight += glm::length(scratch.force[2 * b]);
  if (due < -kUnpaidEnergy * weight * m.size && m.rescues == 0) return false;
  const Real part = due > 0 ? std::sqrt(due / now) : 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    scratch.state.v[b] *= part, scratch.state.w[b] *= part;
    scratch.body_states[b].velocity = scratch.state.v[b];
    scratch.body_states[b].angular_velocity = scratch.state.w[b];
  }
  return true;
}

bool advance(const World& world, Island& m, const Span& span) {
  m.scratch.frames_rest = frames_rest(world, m, span);
  const IntegratorRow& requested =
      m.scratch.in_parts ? integrators::euler : row_of(m.settings.integrator);
  const bool by_poses = requested.ends_on_joints || requested.projection_presses;
  const bool serves = !(by_poses && span.h < kShortest * span.whole);
  // A body without joints has no stiff forces, and RATTLE keeps its angular momentum.
  const bool is_loose = requested.turns_far && m.blocks.empty();
  const IntegratorRow& chosen = !serves    ? integrators::euler
                                : is_loose ? integrators::rattle
                                           : requested;
  if (chosen.step_estimated && m.settings.step_tolerance > 0)
    return integrate_adaptively(world, m, span, chosen);
  m.scratch.start = m.scratch.state, m.scratch.impulses_at_start = m.scratch.impulses;
  const int before = m.rescues;
  m.rescues = 0;
  const bool dear = is_expensive(m);
  // After a rescue fewer halvings are tried, and none in the next steps.
  const Attempt first{chosen, dear ? 0 : before > 0 ? kRetries : kMaxHalvings, kMaxSubsteps};
  const bool has_other = can_pass_singular(m, chosen);
  m.scratch.beside_singular = false, m.scratch.shuns_singular = has_other;
  const bool as_chosen = before % kPatience == 0 && advance_by(world, m, span, first);
  m.scratch.beside_singular = m.scratch.shuns_singular = false;
  const Attempt past{integrators::rk4, first.most_halvings, kMaxSubsteps};
  if (as_chosen || (has_other && advance_by(world, m, span, past))) {
    if (!as_chosen || &chosen != &requested) m.fresh = m.fresh || requested.keeps_accelerations;
    return true;
  }
  // Another method does not help surfaces that have lost contact.
  if (m.scratch.lost_touch != UINT32_MAX) return false;
  const Attempt rescue{integrators::euler, dear ? 0 : kMaxHalvings, 2 * kMaxSubsteps};
  const bool by_halves = &chosen != &integrators::euler && advance_by(world, m, span, rescue);
  if (m.scratch.lost_touch != UINT32_MAX) return false;
  m.rescues = before + 1;
  if (!by_halves && !advance_loosely(world, m, span)) return m.rescues = 0, false;
  m.fresh = requested.keeps_accelerations;
  return true;
}

}  // namespace pantin::detail::lagrangian
