// What the searches of `pantin tune` have in common: the methods, and runs at one setting.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/world/lamina.hpp"
#include "tools/pantin/tune.hpp"

namespace pantin::program {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Runs and times a setting. Status "stopped": it takes more than a quarter of the time that is
/// left.
Attempt measured(const Measuring& in, const Loaded& loaded, const Setting& setting) {
  Attempt a{setting.step, setting.tolerance, {}, {}, kUnknown, kUnknown};
  Trial trial{&*loaded.scene, setting.step, setting.tolerance, in.subject.sampling};
  const double until = wall_seconds() + 0.25 * (in.until - wall_seconds());
  trial.stop = [&](double) { return wall_seconds() > until; };
  const Outcome o = run_motion(trial);
  a.status = o.status, a.reason = o.reason;
  if (!a.is_ok()) return a;
  const Reference& r = in.reference;
  const Apart error = apart(o.track, r.track, std::min(r.compared, o.track.samples()));
  a.error = (error.position + r.own.position) / r.size;
  a.cost = time_run(trial) / in.subject.sampling.duration();
  if (!std::isfinite(a.cost)) a.status = "stopped";
  return a;
}

}  // namespace

Result<Done> try_setting(const Measuring& in, Ladder& ladder, const Setting& setting) {
  const std::string key = fmt::format("{}|tune|{}|{}|{}", in.subject.key,
                                      ladder.loaded->method.name, setting.step, setting.tolerance);
  const double from = wall_seconds();
  if (const Json* k = in.journal.find(key)) {
    const auto number = [&](const char* name) {
      return (*k)[name].is_number() ? (*k)[name].get<double>() : kUnknown;
    };
    ladder.attempts.push_back({setting.step, setting.tolerance, (*k)["status"].get<std::string>(),
                               (*k)["reason"].get<std::string>(), number("error"), number("cost")});
    ladder.next = 2 * number("took_s");
    return Done{};
  }
  if (in.until - from < ladder.next) {
    ladder.end = Ladder::End::time;
    return Done{};
  }
  Attempt a = measured(in, *ladder.loaded, setting);
  if (a.status == "stopped") {
    ladder.end = Ladder::End::time;
    return Done{};
  }
  const double took = wall_seconds() - from;
  ladder.next = 2 * took;  // half the step
  Json known{{"status", a.status},
             {"reason", a.reason},
             {"error", json_number(a.error)},
             {"cost", json_number(a.cost)},
             {"took_s", took}};
  ladder.attempts.push_back(std::move(a));
  return in.journal.add(key, std::move(known));
}

double steps_between(const Sampling& sampling, double few, double many) {
  const double mean = std::sqrt(few * many);
  double best = 0;
  for (double n = few + 1; n < many; ++n)
    if (std::fmod(sampling.between, n) == 0 || std::fmod(n, sampling.between) == 0)
      if (best == 0 || std::abs(std::log(n / mean)) < std::abs(std::log(best / mean))) best = n;
  return best;
}

std::vector<Ladder> ladders_of(const Subject& subject, const TuneChoices& c) {
  std::vector<Ladder> ladders;
  const World& world = subject.own().world;
  const auto* laminas = laminas_of(world);
  const bool is_mixed = world.settings.size() > 0 || (laminas && laminas->size() > 0);
  for (const Loaded& l : subject.loaded) {
    const std::string& name = l.method.name;
    const bool is_asked = c.methods.empty() ? name != "scene" || is_mixed
                                            : std::ranges::find(c.methods, name) != c.methods.end();
    if (!is_asked) continue;
    Ladder& ladder = ladders.emplace_back();
    ladder.loaded = &l;
    if (!l.scene) ladder.end = Ladder::End::fails;
  }
  return ladders;
}

}  // namespace pantin::program
