// What a run suffers from. Each criterion is a measured quantity and a bound.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/world/solver_list.hpp"
#include "tools/pantin/stability.hpp"

namespace pantin::program {
namespace {

constexpr std::array<std::string_view, 10> kWords = {
    "refused", "blows up", "does not converge", "tears",  "gains energy",
    "sinks",   "freezes",  "jitters",           "stalls", "ok"};

constexpr double kJitterSpeed = 5e-3;  // m/s, rms; bodies at rest stay below half of it
constexpr double kJitterPart = 0.25;   // of the steps that reverse the velocity
constexpr double kWatched = 0.25;      // of the run, at its end, for jitter
constexpr double kFewest = 16;         // steps in that time: fewer tell nothing
constexpr double kStill = 0.01;        // of the motion's size: what stays within is at rest
// Of the run, or s, in which dynamics moves laminas because the quasi-static problem has no
// solution.
constexpr double kUndeterminedPart = 0.05, kUndetermined = 0.25;

std::optional<Symptom> symptom_of(FindingKind kind) {
  switch (kind) {
    case FindingKind::energy_gained:
    case FindingKind::flung:
      return Symptom::gains_energy;
    case FindingKind::energy_lost:
    case FindingKind::energy_limited:
    case FindingKind::angular_momentum_changed:
    case FindingKind::spring_unresolved:  // its oscillation is damped
      return Symptom::freezes;
    case FindingKind::joint_open:
    case FindingKind::limit_exceeded:
    case FindingKind::cable_overlong:
    case FindingKind::gear_slipped:
    case FindingKind::belt_slipped:
    case FindingKind::surfaces_apart:
      return Symptom::tears;
    case FindingKind::sunk:
    case FindingKind::passed_through:
      return Symptom::sinks;
    case FindingKind::pin_missed:
    case FindingKind::step_rescued:
    case FindingKind::contacts_unsolved:
      return Symptom::no_convergence;
    default:
      return std::nullopt;  // inaccurate, but stable
  }
}

/// Counts the steps that reverse the velocity of a body, with its speed and where it goes.
class Jitter {
 public:
  Jitter(double from, Json& measured) : from_(from), measured_(measured) {}

  void look(const World& world) {
    if (world.time < from_) return;
    const auto bodies = world.bodies.values();
    bodies_.resize(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].motion != Motion::dynamic) continue;
      Way& b = bodies_[i];
      const Vec3 v = bodies[i].velocity, x = bodies[i].pose.position;
      b.turns += glm::dot(v, b.last) < 0, b.squares += glm::dot(v, v), b.last = v;
      b.least = min(b.least, x), b.most = max(b.most, x);
    }
    ++steps_;
  }

  /// Whether a body that stays where it is turns back and forth from step to step.
  bool found(double size) const {
    double worst = 0;
    for (const Way& b : bodies_)
      if (steps_ >= kFewest && b.turns > kJitterPart * steps_ &&
          glm::length(b.most - b.least) < kStill * size)
        worst = std::max(worst, std::sqrt(b.squares / std::max(1.0, steps_)));
    measured_["jitter_m_s"] = worst;
    return worst > kJitterSpeed;
  }

 private:
  double from_;  // s
  Json& measured_;
  struct Way {
    Vec3 last{0};                                                        // m/s
    Vec3 least{std::numeric_limits<double>::infinity()}, most = -least;  // m, of its positions
    double turns = 0, squares = 0;
  };
  std::vector<Way> bodies_;
  double steps_ = 0;
};

}  // namespace

std::string_view word_of(Symptom symptom) { return kWords[static_cast<std::size_t>(symptom)]; }

std::optional<Symptom> symptom_named(std::string_view word) {
  const auto found = std::find(kWords.begin(), kWords.end(), word);
  if (found == kWords.end()) return std::nullopt;
  return static_cast<Symptom>(found - kWords.begin());
}

Verdict judge(const Case& run) {
  Verdict verdict;
  if (!run.loaded->scene) {
    verdict.worst = Symptom::refused, verdict.all = {Symptom::refused};
    verdict.measured = {{"reason", run.loaded->refusal}};
    return verdict;
  }
  const double steps = std::max(1.0, std::round(run.duration / run.step));
  const double each = std::ceil(steps / 50);
  Trial trial;
  trial.scene = &*run.loaded->scene, trial.step = run.step;
  if (run.loaded->method.is_adaptive) trial.tolerance = run.tolerance;
  trial.sampling = {each * run.step, static_cast<int>(std::ceil(steps / each))};
  trial.watch = true;
  // Slower than real time by far: the rest would tell nothing else.
  trial.stop = [&](double seconds) { return seconds > 2 * run.duration + 0.1; };
  Jitter jitter((1 - kWatched) * run.duration, verdict.measured);
  double undetermined = 0;  // s
  trial.look = [&](const World& world, const StepReport& report) {
    jitter.look(world);
    if (report.handed_over > 0) undetermined += run.step;
  };
  const Outcome o = run_motion(trial);
  std::array<bool, kWords.size()> has{};
  const auto note = [&](Symptom s) { has[static_cast<std::size_t>(s)] = true; };
  Json found = Json::array();
  for (const Finding& f : o.findings) {
    found.push_back(info_of(f.kind).name);
    if (const auto symptom = symptom_of(f.kind)) note(*symptom);
  }
  if (o.status == "inconsistent")
    note(Symptom::no_convergence);
  else if (!o.is_ok() && o.status != "stopped")
    note(Symptom::blows_up);
  if (undetermined > std::min(kUndetermined, kUndeterminedPart * run.duration))
    note(Symptom::no_convergence);
  if (jitter.found(size_of(o.track))) note(Symptom::jitters);
  if (o.seconds > run.duration) note(Symptom::stalls);
  for (std::size_t s = 0; s < has.size(); ++s)
    if (has[s]) verdict.all.push_back(static_cast<Symptom>(s));
  if (!verdict.all.empty()) verdict.worst = verdict.all.front();
  Json& m = verdict.measured;
  m["status"] = o.status, m["reason"] = o.reason, m["ended_at_s"] = o.ended_at;
  m["findings"] = found, m["joints_rel"] = o.gap_rel, m["depth_m"] = o.depth;
  m["cpu_s"] = o.seconds, m["undetermined_s"] = undetermined;
  return verdict;
}

}  // namespace pantin::program
