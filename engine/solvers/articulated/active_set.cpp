// The general solve of a step: iterations until the active set of limits, contacts, cables and pins
// is unchanged.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

bool has_rows(const Island& a) { return !a.pins.empty() || !a.cables.empty(); }

bool has_active_contacts(const World& world, const Island& a) {
  return std::any_of(a.scratch.contact_rows.begin(), a.scratch.contact_rows.end(),
                     [&](const ContactRow& t) { return contacts_of(world)[t.contact].active; });
}

bool is_plain(const Island& a) {
  return !has_rows(a) && a.joints.empty() && a.scratch.contact_rows.empty();
}

void eliminate_once(World& world, Island& a, Real h) {
  StepScratch& r = a.scratch;
  // The blocks of the bodies are constant over the iterations; contacts are not.
  PANTIN_ASSERT(r.base.size() == a.count() && r.joint_nodes.size() == a.count());
  r.joint_blocks = r.base;
  a.stiff_contacts = !a.iterates && has_active_contacts(world, a);
  if (a.stiff_contacts) add_contact_rows(world, a, r.joint_blocks);
  inward_pass(a);
  if (has_rows(a)) solve_rows(world, a, h, kStepPass);
}

bool apply_once(World& world, Island& a, Real h) {
  const bool converged = outward_pass(world, a, h, kStepPass);
  kernels().apply_poses(view_of(world, a), kRotation);
  return (a.iterates ? update_iterated(world, a) : update_contacts(world, a)) && converged;
}

void begin_step(World& world, Island& a, Real h) {
  a.disturbed = a.limited = false;
  a.sweeps_used = a.active_set_iterations_used = a.stops_hit = a.drives_capped = 0;
  a.supplied_work = 0, a.iterates = false;
  for (PackedCable& cord : a.cables) cord.was_taut = cord.lambda > 0;
  if (!a.finite || a.settings.solver != Solver::articulated || is_plain(a)) return;
  reserve_general_solve(a);
  const Tension tension = tension_of(a);
  kernels().prepare(view_of(world, a), kPosition, kRotation, Tension::ignored);
  if (!a.joints.empty()) set_terms(world, a, h, kStepPass);
  keep_gaps(a);
  fill_base(a, tension);
  if (tension == Tension::stiffens) add_cable_stiffness(world, a, a.scratch.base);
  prepare_contacts(world, a, h);
  if (!a.joints.empty() && has_active_contacts(world, a)) regularise_limits(a);
}

namespace {

bool needs_active_set(const Island& a) {
  return a.finite && a.settings.solver == Solver::articulated && !is_plain(a);
}

}  // namespace

void begin_iterating(World& world, Island& a) {
  if (a.iterates || !needs_active_set(a)) return;
  a.iterates = true;
  reserve_general_solve(a);
  PANTIN_ASSERT(a.scratch.terms.size() == a.joints.size());
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    for (LimitRow& limit : a.scratch.terms[c].limits) {
      limit.nonlinearity = 0;
      if (limit.both_ways) continue;
      limit.on = false, limit.weight = 0;
      limit.lambda =
          std::max(Real(0), a.joint_memory[c].lambdas[&limit - a.scratch.terms[c].limits]);
    }
  for (ContactRow& t : a.scratch.contact_rows) {
    t.nonlinearity = Vec3(0);
    if (t.side > 0) contacts_of(world)[t.contact].lambda = contacts_of(world)[t.contact].before;
  }
}

void begin_iteration(World& world, Island& a, Real h) {
  if (!needs_active_set(a)) return;
  PANTIN_ASSERT(a.iterates);
  ++a.active_set_iterations_used;
  eliminate_once(world, a, h);
  free_response(a, kPosition);
  find_contact_response(world, a);
}

bool end_iteration(World& world, Island& a, Real h) {
  if (!needs_active_set(a)) return true;
  add_iterated_lambdas(world, a);
  return apply_once(world, a, h);
}

void iterate_mutual(World& world, Real h) {
  std::vector<Island*>& all = world.memory.of<Islands>().mutual.list;
  all.clear();
  for (Island& a : islands_of(world))
    if (a.mutual && needs_active_set(a)) all.push_back(&a);
  iterate_contacts(world, all, h, {.rounds = 100, .enough = 1e-9});
}

namespace {

/// Steps without guessing after a wrong guess.
constexpr int kStepsIterating = 4;

/// Guessing iterations; each costs a tenth of a Gauss-Seidel iteration.
constexpr int kGuesses = 8;

/// Largest number of Gauss-Seidel iterations, counted from the third; more do not help.
constexpr int kIterations = 4;

/// With more contacts, substeps are cheaper than iterating.
constexpr std::ptrdiff_t kFewContacts = 24;

std::ptrdiff_t bearing(const World& world, const Island& a) {
  return std::count_if(a.scratch.contact_rows.begin(), a.scratch.contact_rows.end(),
                       [&](const ContactRow& t) { return contacts_of(world)[t.contact].active; });
}

}  // namespace

bool find_active_set(World& world, Island& a, Real h, StepLength length) {
  const bool in_substeps = length == StepLength::substep;
  bool converged = !needs_active_set(a);
  // The active set is warm-started from the last step; one or two iterations mostly confirm it.
  // Otherwise projected Gauss-Seidel finds it.
  const bool few = in_substeps || bearing(world, a) <= kFewContacts;
  const bool may_iterate = a.settings.active_set_iterations > 2;
  const int guesses = !may_iterate             ? a.settings.active_set_iterations
                      : few && a.iterating > 0 ? 0
                                               : kGuesses;
  for (int n = 0; n < guesses && !converged; ++n) {
    ++a.active_set_iterations_used;
    eliminate_once(world, a, h);
    converged = apply_once(world, a, h);
  }
  a.iterating = converged ? 0 : a.iterating > 0 ? a.iterating - 1 : kStepsIterating;
  if (converged || !may_iterate) return converged;
  if (!in_substeps && bearing(world, a) > kFewContacts) return false;
  begin_iterating(world, a);
  for (int n = 2; n < std::min(kIterations, a.settings.active_set_iterations) && !converged; ++n) {
    begin_iteration(world, a, h);
    Island* const alone[] = {&a};
    iterate_contacts(world, alone, h, {.rounds = 100, .enough = 1e-8});
    converged = end_iteration(world, a, h);
  }
  return converged;
}

}  // namespace pantin::detail::articulated
