#include "engine/assembly/descent.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"

namespace pantin::detail::assembly {
namespace {

/// rad: the largest rotation of one step; a linear model of rotations serves up to about that.
constexpr Real kMostTurn = 1;
/// Damping at the start, its factors after a success and after a failure, and its bounds.
constexpr Real kFirstDamping = 1e-2, kEase = 0.2, kStiffen = 4, kLeast = 1e-12, kMost = 1e8;
/// Below this residual (of lengths at the size of the arms) Gauss-Newton steps are tried.
constexpr Real kNear = 1e-2;
/// Relative slope of a stationary point, and the number of perturbations that are tried there.
constexpr Real kFlat = 1e-8;
constexpr int kMostPerturbations = 2;
constexpr Real kPerturbation = 1e-3;
/// Iterations that have to reduce the merit by a tenth, or the descent ends.
constexpr int kPatience = 25;
constexpr Real kProgress = 0.9;
constexpr int kMemory = 5;
/// Further steps once the residual is within the tolerance, while each at least halves it.
constexpr int kPolish = 3;

/// Takes the solved step. False, and the poses are as before, if the merit does not fall.
bool take(Descent& d, Real merit) {
  lagrangian::StepScratch& scratch = d.part.m.scratch;
  scratch.from = scratch.state;
  const Real turn = turn_of(d.part);
  displace(d.world, d.part, turn > kMostTurn ? kMostTurn / turn : 1);
  look(d.world, d.part);
  if (merit_of(d.part) < merit) {
    count(d.world, d.part);
    return true;
  }
  scratch.state = scratch.from;
  undo_design(d.world, d.part);
  look(d.world, d.part);
  return false;
}

/// Reduces the residual from the tolerance to rounding.
void polish(Descent& d) {
  for (int n = 0; n < kPolish; ++n) {
    const Real merit = merit_of(d.part);
    if (merit == 0) return;
    solve_step(d.part, kLeast);
    if (!take(d, 0.25 * merit)) return;
  }
}

/// Gauss-Newton near the end, and steps that may exceed the merit of up to kMemory steps before
/// [Grippo, Lampariello & Lucidi 1986]; or always damped, and downwards.
enum class Style : std::uint8_t { fast, monotone };

Ending descend(Descent& d, Style style) {
  const bool ends_by_newton = style == Style::fast;
  const int memory = style == Style::fast ? kMemory : 1;
  Real damping = kFirstDamping;
  bool tries_newton = ends_by_newton;
  Real before = merit_of(d.part);  // kPatience iterations ago
  Real recent[kMemory];
  std::fill_n(recent, kMemory, merit_of(d.part));
  int at = 0;
  for (;;) {
    if (d.note(damping)) {
      polish(d);
      return Ending::closed;
    }
    const Real merit = merit_of(d.part);
    const bool idles =
        !d.settles && d.iterations % kPatience == kPatience - 1 && merit > kProgress * before;
    if (d.iterations % kPatience == 0) before = merit;
    if (idles || slope_of(d.part) < kFlat || damping > kMost) {
      if (idles || d.perturbations >= kMostPerturbations) return Ending::stationary;
      d.perturb();
      damping = kFirstDamping;
      std::fill_n(recent, kMemory, merit_of(d.part));
      continue;
    }
    if (d.iterations >= d.effort.iterations) return Ending::unfinished;
    ++d.iterations;
    const bool newton = tries_newton && worst_of(d.part) < kNear;
    solve_step(d.part, newton ? kLeast : damping);
    const bool good = take(d, *std::max_element(recent, recent + memory));
    if (good) recent[at++ % memory] = merit_of(d.part);
    if (newton) {
      tries_newton = good;
      if (!good) damping = std::max(damping, kFirstDamping);
    } else {
      damping = good ? std::max(kEase * damping, kLeast) : kStiffen * damping;
      tries_newton = ends_by_newton && good;
    }
  }
}

}  // namespace

bool Descent::note(Real damping) {
  const Real worst = worst_of(part);
  if (watch) watch({&part, iterations, worst, merit_of(part), damping});
  return worst <= effort.tolerance;
}

void Descent::perturb() {
  ++perturbations;
  lagrangian::Motions& s = part.m.scratch.state;
  for (std::size_t b = 0; b < part.m.count(); ++b) {
    s.q[b] = glm::normalize(from_rotation_vector(kPerturbation * random.direction()) * s.q[b]);
    s.x[b] += kPerturbation * std::sqrt(part.m.inertia[b].x) * random.direction();
  }
  look(world, part);
}

Ending descend_auto(Descent& d) { return descend(d, Style::fast); }
Ending descend_levenberg(Descent& d) { return descend(d, Style::monotone); }

Ending descend_gauss_newton(Descent& d) {
  for (;; ++d.iterations) {
    if (d.note(0)) {
      polish(d);
      return Ending::closed;
    }
    if (d.iterations >= d.effort.iterations) return Ending::unfinished;
    solve_step(d.part, kLeast);
    const Real turn = turn_of(d.part);
    displace(d.world, d.part, turn > kMostTurn ? kMostTurn / turn : 1);
    look(d.world, d.part), count(d.world, d.part);
    if (!std::isfinite(worst_of(d.part))) return Ending::unfinished;
  }
}

}  // namespace pantin::detail::assembly
