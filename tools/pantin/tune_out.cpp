// What `pantin tune` says of each method.
#include <fmt/format.h>

#include "tools/pantin/tune.hpp"

namespace pantin::program {
namespace {

/// The best attempt by a measure of attempts, or null.
template <typename By>
const Attempt* least(const Ladder& ladder, By by) {
  const Attempt* best = nullptr;
  for (const Attempt& a : ladder.attempts)
    if (a.is_ok() && (!best || by(a) < by(*best))) best = &a;
  return best;
}

/// "diverged" with its reason.
std::string words_of_failure(const Attempt& a) {
  return a.status + (a.reason.empty() ? "" : ", " + a.reason);
}

Why failing(const Tuning& t, const Ladder& l) {
  if (!t.reference.holds()) return {"not_run", "there is no reference"};
  if (t.unseen) return {"not_run", "an event is outside of what can be compared"};
  if (l.attempts.empty())
    return {"not_run", "its first run takes too much of the time; repeat with a longer --within"};
  const Attempt& last = l.attempts.back();
  if (l.end == Ladder::End::time)
    return {"not_run",
            fmt::format("{} at {}; shorter steps take too much of the time that was left",
                        words_of_failure(last), words_of(last))};
  return {"fails", fmt::format("fails at all {} settings, down to {}: {}", l.attempts.size(),
                               words_of(last), words_of_failure(last))};
}

/// Of a method that does not meet the error.
Why missing(const Ladder& l, const Attempt& best) {
  using enum Ladder::End;
  const std::string error = fmt::format("error {:.2g} at {}", best.error, words_of(best));
  switch (l.end) {
    case dearer:
      return {"dearer", error + ", where it costs more than the choice already"};
    case time:
      return {"not_run", error + "; shorter steps take too much of the time that was left"};
    case fails:
      return {"fails", error + "; " + words_of_failure(l.attempts.back()) + " at shorter steps"};
    default:
      return {"misses", &best == &l.attempts.back()
                            ? error + ", the finest setting that was tried"
                            : fmt::format("{}, the best of {} settings down to {}", error,
                                          l.attempts.size(), words_of(l.attempts.back()))};
  }
}

}  // namespace

std::string words_of(const Attempt& a) {
  return a.tolerance > 0 ? fmt::format("tolerance {:.1e}", a.tolerance)
                         : fmt::format("step {:.4g} ms", 1e3 * a.step);
}

std::string words_of_unseen(const Tuning& t) {
  const Reference& r = t.reference;
  const double spacing = t.subject.sampling.spacing();
  return fmt::format(
      "no choice is vouched for: refined runs part after {:.3g} s, so that errors are known for "
      "the "
      "first {:.3g} s, before the event at {:.3g} s; repeat with a longer --within, or with "
      "--duration {:.6g} for what is before it",
      static_cast<double>(r.agreed - 1) * spacing, static_cast<double>(r.compared - 1) * spacing,
      *t.unseen, *t.unseen);
}

std::string words_of_tried(const Tuning& t) {
  std::size_t settings = 0, cut = 0;
  for (const Ladder& l : t.ladders)
    settings += l.attempts.size(), cut += l.end == Ladder::End::time;
  return fmt::format("the {} settings that were tried{}", settings,
                     cut > 0 ? fmt::format(" (for shorter steps of {} methods the time was too "
                                           "short: repeat with a longer --within)",
                                           cut)
                             : "");
}

Why why_of(const Tuning& t, const TuneChoices& c, std::size_t ladder) {
  const Ladder& l = t.ladders[ladder];
  if (!l.loaded->scene) return {"refused", l.loaded->refusal};
  const auto by_cost = [](const Attempt& a) { return a.cost; };
  const auto by_error = [](const Attempt& a) { return a.error; };
  const Attempt *precise = least(l, by_error), *cheap = least(l, by_cost);
  if (!precise || !t.choice) return failing(t, l);
  const Attempt& choice = t.attempt();
  if (t.choice->ladder == ladder)
    return {t.is_met ? "chosen" : "best", fmt::format("error {:.2g} at {}, {:.3g} us", choice.error,
                                                      words_of(choice), 1e6 * choice.cost)};
  if (c.time) {
    const Attempt* within = nullptr;
    for (const Attempt& a : l.attempts)
      if (a.is_ok() && a.cost <= 1e-6 * *c.time && (!within || a.error < within->error))
        within = &a;
    if (!within)
      return {"dearer", fmt::format("its cheapest run takes {:.3g} us, at {}", 1e6 * cheap->cost,
                                    words_of(*cheap))};
    const bool worse = within->error > choice.error;
    return {worse ? "misses" : "dearer",
            fmt::format("error {:.2g} within the time, at {}{}", within->error, words_of(*within),
                        worse ? "" : ": no better than the choice, as far as the reference tells")};
  }
  const Attempt* met = nullptr;
  for (const Attempt& a : l.attempts)
    if (a.is_ok() && a.error <= *c.error && (t.frame == 0 || a.step == t.frame) &&
        (!met || a.cost < met->cost))
      met = &a;
  if (met)
    return {"dearer", fmt::format("meets the error at {}, for {:.3g} times the cost of the choice",
                                  words_of(*met), met->cost / choice.cost)};
  return missing(l, *precise);
}

}  // namespace pantin::program
