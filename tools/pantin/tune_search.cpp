// The search of `pantin tune`: all methods over ladders of steps, the cheapest next run first.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/pantin/tune.hpp"

namespace pantin::program {
namespace {

constexpr double kReferencePart = 0.35, kRunsPart = 0.85;  // of the time
constexpr double kNear = 2;  // within this factor a finer step may be the cheaper one

class Tuner {
 public:
  Tuner(const TuneChoices& c, Journal& journal, double begin)
      : c_(c), journal_(journal), begin_(begin), progress_(c.scene) {}
  Result<Tuning> make(Subject subject);

 private:
  Result<Done> climb(Ladder& ladder);
  Result<Done> refine(Ladder& ladder);
  Result<Done> go_finer(Ladder& ladder, int rung);
  Result<Done> attempt(Ladder& ladder, double steps, double tolerance);
  Result<Done> attempt_rung(Ladder& ladder, int rung);
  Ladder::End end_of(const Ladder& ladder) const;
  void time_again();
  void choose();
  bool meets(const Attempt& a) const;
  bool is_better(const Attempt& a, const Attempt& b) const;
  /// The cost of the cheapest attempt that meets what is asked.
  double least_cost() const;
  double left(double part) const { return begin_ + part * c_.within - wall_seconds(); }
  double floored(const Attempt& a) const { return std::max(a.error, error_floor(t_.reference)); }

  const TuneChoices& c_;
  Journal& journal_;
  double begin_;  // s
  Progress progress_;
  Tuning t_;
};

bool Tuner::meets(const Attempt& a) const {
  if (!a.is_ok() || !std::isfinite(a.cost)) return false;
  return c_.error ? a.error <= *c_.error : a.cost <= 1e-6 * *c_.time;
}

/// Whether `a` is the better choice of two that both meet what is asked, or both do not.
bool Tuner::is_better(const Attempt& a, const Attempt& b) const {
  if (meets(a) != meets(b)) return meets(a);
  const bool by_cost = meets(a) == c_.error.has_value();
  if (by_cost) return a.cost < b.cost;
  return std::pair(floored(a), a.cost) < std::pair(floored(b), b.cost);
}

double Tuner::least_cost() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Ladder& l : t_.ladders)
    for (const Attempt& a : l.attempts)
      if (meets(a)) least = std::min(least, a.cost);
  return least;
}

Result<Done> Tuner::attempt(Ladder& ladder, double steps, double tolerance) {
  const double step = t_.subject.sampling.interval / steps;
  return try_setting({t_.subject, t_.reference, journal_, begin_ + kRunsPart * c_.within}, ladder,
                     {step, tolerance});
}

/// Whether a ladder ends with its last attempt.
Ladder::End Tuner::end_of(const Ladder& l) const {
  using enum Ladder::End;
  const std::vector<Attempt>& all = l.attempts;
  const int n = static_cast<int>(all.size());
  const Attempt& a = all.back();
  if (!a.is_ok()) {
    const auto failed = [](const Attempt& one) { return !one.is_ok(); };
    const bool all_fail =
        n >= kMostFailures && std::all_of(all.end() - kMostFailures, all.end(), failed);
    return all_fail ? fails : n == c_.rungs ? finest : none;
  }
  if (c_.error && meets(a)) return met;
  if (c_.error && a.cost >= least_cost()) return dearer;
  if (!c_.error && !meets(a)) return over;
  if (!c_.error && a.error <= error_floor(t_.reference)) return met;
  return n == c_.rungs ? finest : none;
}

/// One setting between the last two, where one of them meets what is asked and the other does not.
Result<Done> Tuner::refine(Ladder& l) {
  const std::size_t n = l.attempts.size();
  if (n < 2 || meets(l.attempts[n - 1]) == meets(l.attempts[n - 2])) return Done{};
  const Attempt &coarse = l.attempts[n - 2], &fine = l.attempts[n - 1];
  const double interval = t_.subject.sampling.interval;
  const double few = std::round(interval / coarse.step), many = std::round(interval / fine.step);
  if (fine.tolerance > 0) return attempt(l, many, std::sqrt(coarse.tolerance * fine.tolerance));
  const double between = steps_between(t_.subject.sampling, few, many);
  if (between == 0) return Done{};
  return attempt(l, between, 0);
}

/// Rungs below one that meets the error, while they are cheaper: at shorter steps bodies may come
/// to rest sooner, or iterations end sooner.
Result<Done> Tuner::go_finer(Ladder& l, int rung) {
  for (; rung < c_.rungs; ++rung) {
    double best = std::numeric_limits<double>::infinity();
    for (const Attempt& a : l.attempts)
      if (meets(a)) best = std::min(best, a.cost);
    if (best > kNear * least_cost()) return Done{};
    const std::size_t n = l.attempts.size();
    if (auto done = attempt_rung(l, rung); !done) return done;
    if (l.attempts.size() == n || !meets(l.attempts.back()) || l.attempts.back().cost >= best)
      return Done{};
  }
  return Done{};
}

Result<Done> Tuner::attempt_rung(Ladder& l, int rung) {
  const double whole = t_.subject.coarsest_steps();
  const bool adapts = l.loaded->method.is_adaptive;
  return attempt(l, adapts ? whole : std::ldexp(whole, rung),
                 adapts ? std::pow(10.0, -2 - rung) : 0);
}

/// The next rung of a ladder.
Result<Done> Tuner::climb(Ladder& l) {
  const std::size_t n = l.attempts.size();
  const auto rung = static_cast<int>(n);
  if (auto done = attempt_rung(l, rung); !done) return done;
  if (l.attempts.size() == n) return Done{};
  l.end = end_of(l);
  if (l.end != Ladder::End::met && l.end != Ladder::End::over) return Done{};
  const Ladder::End end = l.end;
  auto done = refine(l);
  if (done && end == Ladder::End::met && c_.error) done = go_finer(l, rung + 1);
  l.end = end;
  return done;
}

/// Rounds that time the best attempts in turn. The least time counts: load only adds to it.
void Tuner::time_again() {
  std::vector<Pick> close;
  const double least = least_cost();
  for (std::size_t l = 0; l < t_.ladders.size(); ++l)
    for (std::size_t i = 0; i < t_.ladders[l].attempts.size(); ++i) {
      const Attempt& a = t_.ladders[l].attempts[i];
      const bool near = c_.error ? meets(a) && a.cost <= kClose * least
                                 : a.is_ok() && a.cost <= kClose * 1e-6 * *c_.time;
      if (near) close.push_back({l, i});
    }
  std::vector<std::vector<double>> costs(close.size());
  for (int round = 0; round < kRounds;
       ++round, std::ranges::reverse(close), std::ranges::reverse(costs))
    for (std::size_t i = 0; i < close.size(); ++i) {
      const Ladder& l = t_.ladders[close[i].ladder];
      const Attempt& a = l.attempts[close[i].attempt];
      const double duration = t_.subject.sampling.duration();
      if (interrupted() || left(1) < a.cost * duration) continue;
      const double seconds =
          time_run({&*l.loaded->scene, a.step, a.tolerance, t_.subject.sampling});
      if (std::isfinite(seconds)) costs[i].push_back(seconds / duration);
    }
  for (std::size_t i = 0; i < close.size(); ++i)
    if (!costs[i].empty())
      t_.ladders[close[i].ladder].attempts[close[i].attempt].cost = std::ranges::min(costs[i]);
}

void Tuner::choose() {
  for (std::size_t l = 0; l < t_.ladders.size(); ++l)
    for (std::size_t i = 0; i < t_.ladders[l].attempts.size(); ++i) {
      const Attempt& a = t_.ladders[l].attempts[i];
      if (a.is_ok() && (!t_.choice || is_better(a, t_.attempt()))) t_.choice = Pick{l, i};
    }
  t_.is_met = t_.choice && meets(t_.attempt());
}

Result<Tuning> Tuner::make(Subject subject) {
  t_.subject = std::move(subject);
  const double step = t_.subject.sampling.interval / t_.subject.coarsest_steps();
  Result<Reference> reference = reference_of(
      t_.subject, journal_, {t_.subject.sampling, step / 16, kReferencePart * c_.within});
  if (!reference) return reference.errors();
  t_.reference = std::move(*reference);
  rerun(t_.subject, t_.reference);
  t_.ladders = ladders_of(t_.subject, c_);
  t_.unseen = event_unseen(t_.subject, t_.reference);
  if (!t_.reference.holds() || t_.unseen) return std::move(t_);
  while (!interrupted()) {
    progress_.show(1 - left(1) / c_.within);
    Ladder* next = nullptr;
    for (Ladder& l : t_.ladders)
      if (l.end == Ladder::End::none && (!next || l.next < next->next)) next = &l;
    if (!next) break;
    if (auto done = climb(*next); !done) return done.errors();
  }
  if (!interrupted()) time_again();
  if (!interrupted()) choose();
  return std::move(t_);
}

}  // namespace

double error_floor(const Reference& reference) {
  return 2 * reference.own.position / reference.size;
}

Result<Tuning> tune_whole(const TuneChoices& choices, Journal& journal, Begun begun) {
  return Tuner(choices, journal, begun.at).make(std::move(begun.subject));
}

}  // namespace pantin::program
