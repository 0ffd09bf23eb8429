// The search of `pantin tune` where groups of bodies never meet: frame steps from long to short; at
// each, every group under every method that may still be part of the best choice.
#include "tools/pantin/tune_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace pantin::program {
namespace {

constexpr double kReferencePart = 0.35, kRunsPart = 0.75;  // of the time
constexpr double kLarge = 2;     // this many times the cheapest is too much
constexpr double kPart = 0.3;    // unless it is less than this part of the whole
constexpr double kNoise = 1.05;  // costs within this factor are equal
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

class GroupTuner {
 public:
  GroupTuner(const TuneChoices& c, Journal& journal, double begin)
      : c_(c), journal_(journal), begin_(begin), progress_(c.scene) {}
  Result<GroupTuning> make(Subject subject, Grouping grouping);

 private:
  Result<Tuning> begin_kind(const Group& group);
  Result<Done> search();
  Result<Done> measure_step(double steps);
  Result<Done> measure_kind(std::size_t kind, double steps);
  Result<Done> measure_tolerances(std::size_t kind, Ladder& ladder, double steps);
  Result<Done> even_tolerances(double steps);
  void drop_methods(std::size_t kind, double step);
  bool is_enough(const Attempt& a) const;
  double count(std::size_t kind) const {
    return static_cast<double>(t_.grouping.kinds[kind].groups.size());
  }
  double floored(std::size_t kind, const Attempt& a) const {
    return std::max(a.error, error_floor(t_.kinds[kind].reference));
  }
  std::optional<Pick> cheapest(std::size_t kind, double step, double error) const;
  std::optional<Composition> mixed_at(double step, double error) const;
  std::optional<Composition> uniform_at(double step) const;
  void finish(Composition& c) const;
  std::optional<Composition> best_at(double step) const;
  std::optional<Composition> closest_at(double step) const;
  double least_at(double step) const;
  bool is_better(const Composition& a, const std::optional<Composition>& b) const;
  void time_again();
  void compose();
  void verify(Composition& c);
  void time_whole();
  void choose();
  double left(double part) const { return begin_ + part * c_.within - wall_seconds(); }
  Measuring measuring(std::size_t kind) const {
    const Tuning& t = t_.kinds[kind];
    return {t.subject, t.reference, journal_, begin_ + kRunsPart * c_.within};
  }

  const TuneChoices& c_;
  Journal& journal_;
  double begin_;  // s
  Progress progress_;
  GroupTuning t_;
  std::vector<double> steps_;                                 // s, that were measured
  std::map<std::pair<std::size_t, std::string>, int> rungs_;  // of tolerances, by kind and method
};

bool GroupTuner::is_enough(const Attempt& a) const {
  return a.is_ok() && std::isfinite(a.cost) && (!c_.error || a.error <= *c_.error);
}

/// A group alone under all methods, with its reference. Errors are fractions of the size of its own
/// motion, or of itself if that is larger: a group at rest moves by rounding only.
Result<Tuning> GroupTuner::begin_kind(const Group& group) {
  Tuning t;
  const Subject& whole = t_.subject;
  const Scene part = part_of(whole.own(), group);
  t.subject = {whole.path, {}, whole.key + "|" + group.name, {}, whole.sampling, whole.coarsest};
  for (const Loaded& l : whole.loaded)
    t.subject.loaded.push_back(
        group.has_laminas && l.method.choices.solver
            ? Loaded{l.method, std::nullopt, "laminas always use \"quasistatic\""}
            : load_part(part, l.method));
  const double step = whole.sampling.interval / whole.coarsest_steps();
  const double seconds = kReferencePart * c_.within / static_cast<double>(t_.grouping.kinds.size());
  Result<Reference> reference =
      reference_of(t.subject, journal_, {whole.sampling, step / 16, seconds});
  if (!reference) return reference.errors();
  t.reference = std::move(*reference);
  rerun(t.subject, t.reference);
  t.reference.size = std::max(t.reference.size, extent_of(part.world, group));
  t.ladders = ladders_of(t.subject, c_);
  t.unseen = event_unseen(t.subject, t.reference);
  return t;
}

/// The cheapest attempt of a group at a step with at most that error.
std::optional<Pick> GroupTuner::cheapest(std::size_t kind, double step, double error) const {
  std::optional<Pick> best;
  double least = kInfinite;
  const std::vector<Ladder>& ladders = t_.kinds[kind].ladders;
  for (std::size_t l = 0; l < ladders.size(); ++l)
    for (std::size_t i = 0; i < ladders[l].attempts.size(); ++i) {
      const Attempt& a = ladders[l].attempts[i];
      if (a.is_ok() && a.step == step && floored(kind, a) <= error && a.cost < least)
        best = Pick{l, i}, least = a.cost;
    }
  return best;
}

void GroupTuner::finish(Composition& c) const {
  for (std::size_t k = 0; k < c.picks.size(); ++k) {
    const Attempt& a = t_.attempt(c, k);
    c.error = std::max(c.error, floored(k, a));
    c.foreseen += count(k) * a.cost;
  }
}

std::optional<Composition> GroupTuner::mixed_at(double step, double error) const {
  Composition c;
  c.step = step;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k) {
    const double floor = error_floor(t_.kinds[k].reference);
    const auto pick = cheapest(k, step, std::max(error, floor));
    if (!pick) return std::nullopt;
    c.picks.push_back(*pick);
  }
  finish(c);
  return c;
}

bool GroupTuner::is_better(const Composition& a, const std::optional<Composition>& b) const {
  if (!b) return true;
  if (c_.error) return a.foreseen < b->foreseen;
  return std::pair(a.error, a.foreseen) < std::pair(b->error, b->foreseen);
}

/// The best composition at a step that meets what is asked.
std::optional<Composition> GroupTuner::best_at(double step) const {
  if (c_.error) return mixed_at(step, *c_.error);
  std::set<double> errors;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k)
    for (const Ladder& l : t_.kinds[k].ladders)
      for (const Attempt& a : l.attempts)
        if (a.is_ok() && a.step == step) errors.insert(floored(k, a));
  for (const double error : errors)
    if (auto c = mixed_at(step, error); c && c->foreseen <= 1e-6 * *c_.time) return c;
  return std::nullopt;
}

/// The composition at a step that comes closest to what is asked.
std::optional<Composition> GroupTuner::closest_at(double step) const {
  if (!c_.error) return mixed_at(step, kInfinite);
  double error = 0;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k) {
    double least = kInfinite;
    for (const Ladder& l : t_.kinds[k].ladders)
      for (const Attempt& a : l.attempts)
        if (a.is_ok() && a.step == step) least = std::min(least, floored(k, a));
    error = std::max(error, least);
  }
  return mixed_at(step, error);
}

/// The best one of one method and tolerance for all groups.
std::optional<Composition> GroupTuner::uniform_at(double step) const {
  std::optional<Composition> best;
  const std::vector<Ladder>& first = t_.kinds[0].ladders;
  for (std::size_t l = 0; l < first.size(); ++l)
    for (const Attempt& of : first[l].attempts) {
      if (of.step != step) continue;
      Composition c;
      c.step = step;
      for (const Tuning& t : t_.kinds) {
        const std::vector<Attempt>& all = t.ladders[l].attempts;
        const auto same = std::ranges::find_if(all, [&](const Attempt& a) {
          return a.step == step && a.tolerance == of.tolerance && is_enough(a);
        });
        if (same == all.end()) break;
        c.picks.push_back({l, static_cast<std::size_t>(same - all.begin())});
      }
      if (c.picks.size() < t_.kinds.size()) continue;
      finish(c);
      const bool is_in_time = c_.error || c.foreseen <= 1e-6 * *c_.time;
      if (is_in_time && is_better(c, best)) best = std::move(c);
    }
  return best;
}

/// What all groups cost at a step at least, whatever their errors.
double GroupTuner::least_at(double step) const {
  double sum = 0;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k)
    if (const auto pick = cheapest(k, step, kInfinite))
      sum += count(k) * t_.kinds[k].ladders[pick->ladder].attempts[pick->attempt].cost;
  return sum;
}

/// Tolerances, from the one that was enough at the step before on, until one is enough.
Result<Done> GroupTuner::measure_tolerances(std::size_t kind, Ladder& l, double steps) {
  int& rung = rungs_[{kind, l.loaded->method.name}];
  const double step = t_.subject.sampling.interval / steps;
  for (int tried = 0; tried < c_.rungs && rung < 2 * c_.rungs; ++tried, ++rung) {
    const std::size_t n = l.attempts.size();
    if (auto done = try_setting(measuring(kind), l, {step, std::pow(10.0, -2 - rung)}); !done)
      return done;
    if (l.attempts.size() == n) return Done{};
    const Attempt& a = l.attempts.back();
    if (c_.error && is_enough(a)) return Done{};
    if (!c_.error && a.is_ok() && count(kind) * a.cost > 1e-6 * *c_.time) return Done{};
  }
  l.end = Ladder::End::finest;
  return Done{};
}

/// Ends the ladders of a group that can be part of no good choice at shorter steps.
void GroupTuner::drop_methods(std::size_t kind, double step) {
  const double whole = least_at(step);
  const auto best = cheapest(kind, step, c_.error ? *c_.error : kInfinite);
  if (!best) return;
  std::vector<Ladder>& ladders = t_.kinds[kind].ladders;
  const double least = ladders[best->ladder].attempts[best->attempt].cost;
  for (Ladder& l : ladders) {
    if (l.end != Ladder::End::none || l.attempts.empty()) continue;
    const Attempt& a = l.attempts.back();
    if (a.is_ok() && a.cost > kLarge * least && count(kind) * (a.cost - least) > kPart * whole)
      l.end = Ladder::End::dearer;
  }
}

Result<Done> GroupTuner::measure_kind(std::size_t kind, double steps) {
  const double step = t_.subject.sampling.interval / steps;
  for (Ladder& l : t_.kinds[kind].ladders) {
    if (l.end != Ladder::End::none || interrupted()) continue;
    progress_.show(1 - left(1) / c_.within);
    auto done = l.loaded->method.is_adaptive ? measure_tolerances(kind, l, steps)
                                             : try_setting(measuring(kind), l, {step, 0});
    if (!done) return done;
    const auto failed = [](const Attempt& a) { return !a.is_ok(); };
    const auto n = static_cast<int>(l.attempts.size());
    if (n >= kMostFailures && l.end == Ladder::End::none &&
        std::all_of(l.attempts.end() - kMostFailures, l.attempts.end(), failed))
      l.end = Ladder::End::fails;
  }
  return Done{};
}

/// The tightest tolerance that one of the groups needs, for all: a choice of one method has one.
Result<Done> GroupTuner::even_tolerances(double steps) {
  const double step = t_.subject.sampling.interval / steps;
  const auto met = [&](const Ladder& l) {
    return std::ranges::find_if(l.attempts,
                                [&](const Attempt& a) { return a.step == step && is_enough(a); });
  };
  for (std::size_t l = 0; l < t_.kinds[0].ladders.size(); ++l) {
    if (!t_.kinds[0].ladders[l].loaded->method.is_adaptive) continue;
    double tightest = kInfinite;
    for (const Tuning& t : t_.kinds)
      tightest = met(t.ladders[l]) == t.ladders[l].attempts.end()
                     ? 0
                     : std::min(tightest, met(t.ladders[l])->tolerance);
    if (!(tightest > 0)) continue;
    for (std::size_t k = 0; k < t_.kinds.size(); ++k)
      if (Ladder& ladder = t_.kinds[k].ladders[l]; met(ladder)->tolerance != tightest)
        if (auto done = try_setting(measuring(k), ladder, {step, tightest}); !done) return done;
  }
  return Done{};
}

Result<Done> GroupTuner::measure_step(double steps) {
  for (std::size_t k = 0; k < t_.kinds.size() && !interrupted(); ++k)
    if (auto done = measure_kind(k, steps); !done) return done;
  if (auto done = even_tolerances(steps); !done) return done;
  steps_.push_back(t_.subject.sampling.interval / steps);
  for (std::size_t k = 0; k < t_.kinds.size(); ++k) drop_methods(k, steps_.back());
  return Done{};
}

/// All rungs down to one at which even the cheapest runs cost too much; then one step between the
/// best one and the next longer one.
Result<Done> GroupTuner::search() {
  const double whole = t_.subject.coarsest_steps();
  std::optional<Composition> best;
  int best_rung = 0;
  for (int rung = 0; rung < c_.rungs && !interrupted() && left(kRunsPart) > 0; ++rung) {
    if (auto done = measure_step(std::ldexp(whole, rung)); !done) return done;
    if (auto now = best_at(steps_.back()); now && is_better(*now, best))
      best = std::move(now), best_rung = rung;
    const double least = least_at(steps_.back());
    if (c_.error ? best && (least > kLarge * best->foreseen || rung > best_rung + 1)
                 : least > 1e-6 * *c_.time)
      break;
  }
  if (!best || best_rung == 0) return Done{};
  const double many = std::ldexp(whole, best_rung), few = many / 2;
  const double between = steps_between(t_.subject.sampling, few, many);
  return between > 0 ? measure_step(between) : Result<Done>(Done{});
}

/// The best compositions by groups, and of one method.
void GroupTuner::compose() {
  t_.mixed.reset(), t_.uniform.reset();
  for (const double step : steps_) {
    if (auto c = best_at(step); c && is_better(*c, t_.mixed)) t_.mixed = std::move(c);
    if (auto c = uniform_at(step); c && is_better(*c, t_.uniform)) t_.uniform = std::move(c);
  }
  const auto is_closer = [&](const Composition& a, const Composition& b) {
    return c_.error ? a.error < b.error : a.foreseen < b.foreseen;
  };
  const bool any = t_.mixed || t_.uniform;
  for (const double step : steps_)
    if (auto c = closest_at(step); !any && c && (!t_.mixed || is_closer(*c, *t_.mixed)))
      t_.mixed = std::move(c);
  if (!t_.mixed) return;
  const auto method = [&](std::size_t k) {
    return std::pair(t_.ladder(*t_.mixed, k).loaded->method.name,
                     t_.attempt(*t_.mixed, k).tolerance);
  };
  bool differs = false;
  for (std::size_t k = 1; k < t_.kinds.size(); ++k) differs = differs || method(k) != method(0);
  if (differs) return;
  if (!t_.uniform || is_better(*t_.mixed, t_.uniform)) t_.uniform = t_.mixed;
  t_.mixed.reset();
}

/// Rounds that time what may be part of the choice in turn.
void GroupTuner::time_again() {
  struct Close {
    std::size_t kind;
    Pick pick;
    std::vector<double> costs = {};
  };
  std::vector<Close> close;
  for (const auto* c : {&t_.mixed, &t_.uniform})
    for (std::size_t k = 0; *c && k < t_.kinds.size(); ++k) {
      const double least = t_.attempt(**c, k).cost;
      const std::vector<Ladder>& ladders = t_.kinds[k].ladders;
      for (std::size_t l = 0; l < ladders.size(); ++l)
        for (std::size_t i = 0; i < ladders[l].attempts.size(); ++i)
          if (const Attempt& a = ladders[l].attempts[i];
              a.step == (*c)->step && is_enough(a) && a.cost <= kClose * least)
            close.push_back({k, {l, i}});
    }
  const double duration = t_.subject.sampling.duration();
  for (int round = 0; round < kRounds; ++round, std::ranges::reverse(close))
    for (Close& one : close) {
      const Ladder& l = t_.kinds[one.kind].ladders[one.pick.ladder];
      const Attempt& a = l.attempts[one.pick.attempt];
      if (interrupted() || left(0.9) < a.cost * duration) continue;
      const double seconds =
          time_run({&*l.loaded->scene, a.step, a.tolerance, t_.subject.sampling});
      if (std::isfinite(seconds)) one.costs.push_back(seconds / duration);
    }
  for (const Close& one : close)
    if (!one.costs.empty())
      t_.kinds[one.kind].ladders[one.pick.ladder].attempts[one.pick.attempt].cost =
          std::ranges::min(one.costs);
}

/// Runs the whole scene and compares each group with its reference; copies by where they start.
void GroupTuner::verify(Composition& c) {
  const Scene scene = composed(t_, c);
  const Outcome o = run_motion({&scene, c.step, 0, t_.subject.sampling});
  c.status = o.status, c.reason = o.reason, c.measured_error = 0, c.cost = kUnknown;
  if (!o.is_ok()) return;
  for (std::size_t k = 0; k < t_.kinds.size(); ++k)
    for (const std::size_t g : t_.grouping.kinds[k].groups) {
      const Reference& r = t_.kinds[k].reference;
      Track own = track_of(o.track, t_.subject.own().world, t_.grouping.groups[g]);
      if (own.poses.empty()) continue;
      const Vec3 shift = r.track.poses[0].position - own.poses[0].position;
      for (Pose& p : own.poses) p.position += shift;
      const Apart error = apart(own, r.track, std::min(r.compared, own.samples()));
      const double part = (error.position + r.own.position) / r.size;
      if (part > c.measured_error) c.measured_error = part, c.worst = k;
    }
}

/// Times the whole scene under both choices in turn.
void GroupTuner::time_whole() {
  std::vector<std::pair<Composition*, Scene>> both;
  for (auto* c : {&t_.mixed, &t_.uniform})
    if (*c && (*c)->status == "ok") both.emplace_back(&**c, composed(t_, **c));
  const double duration = t_.subject.sampling.duration();
  for (int round = 0; round < kRounds; ++round, std::ranges::reverse(both))
    for (auto& [c, scene] : both) {
      if (interrupted() || (round > 0 && left(1) < c->cost * duration)) continue;
      const double cost = time_run({&scene, c->step, 0, t_.subject.sampling}) / duration;
      if (!(cost >= c->cost)) c->cost = cost;
    }
}

void GroupTuner::choose() {
  const auto meets = [&](const std::optional<Composition>& c) {
    if (!c || c->status != "ok") return false;
    return c_.error ? c->measured_error <= *c_.error : c->cost <= kNoise * 1e-6 * *c_.time;
  };
  const bool mixed = meets(t_.mixed), uniform = meets(t_.uniform);
  t_.is_mixed = t_.mixed && (!uniform || mixed);
  // No more than the scene needs: one choice for all where it is as good.
  if (mixed && uniform)
    t_.is_mixed = c_.error ? t_.uniform->cost > kNoise * t_.mixed->cost
                           : t_.uniform->error > kNoise * t_.mixed->error;
  t_.is_met = t_.is_mixed ? mixed : uniform;
  const Composition* choice = t_.choice();
  for (std::size_t k = 0; choice && k < t_.kinds.size(); ++k)
    t_.kinds[k].choice = choice->picks[k], t_.kinds[k].is_met = true,
    t_.kinds[k].frame = choice->step;
}

Result<GroupTuning> GroupTuner::make(Subject subject, Grouping grouping) {
  t_.subject = std::move(subject), t_.grouping = std::move(grouping);
  for (const GroupKind& kind : t_.grouping.kinds) {
    progress_.show(1 - left(1) / c_.within);
    Result<Tuning> begun = begin_kind(t_.grouping.groups[kind.groups.front()]);
    if (!begun) return begun.errors();
    t_.kinds.push_back(std::move(*begun));
    const Tuning& kind_begun = t_.kinds.back();
    if (interrupted() || !kind_begun.reference.holds() || kind_begun.unseen) return std::move(t_);
  }
  if (auto done = search(); !done) return done.errors();
  compose();
  if (!interrupted()) time_again(), compose();
  for (auto* c : {&t_.mixed, &t_.uniform})
    if (*c && !interrupted()) verify(**c);
  if (!interrupted()) time_whole(), choose();
  return std::move(t_);
}

}  // namespace

Scene composed(const GroupTuning& t, const Composition& c) {
  Scene scene = t.subject.own();
  for (std::size_t k = 0; k < t.kinds.size(); ++k)
    for (const std::size_t g : t.grouping.kinds[k].groups)
      apply_method(scene.world, t.grouping.groups[g], t.ladder(c, k).loaded->method,
                   t.attempt(c, k).tolerance);
  settle(t.subject.path, scene);
  return scene;
}

Result<GroupTuning> tune_groups(const TuneChoices& choices, Journal& journal, Begun begun,
                                Grouping grouping) {
  return GroupTuner(choices, journal, begun.at).make(std::move(begun.subject), std::move(grouping));
}

}  // namespace pantin::program
