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

Why failing(const Ladder& l) {
  if (l.attempts.empty())
    return {"not_run", "its first run takes too much of the time; repeat with a longer --within"};
  const Attempt& last = l.attempts.back();
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
    case stalls:
      return {"misses", error + "; shorter steps do not lessen it enough"};
    case time:
      return {"not_run", error + "; shorter steps take too much of the time that was left"};
    case fails:
      return {"fails", error + "; " + words_of_failure(l.attempts.back()) + " at shorter steps"};
    default:
      return {"misses", error + ", the finest setting that is tried"};
  }
}

}  // namespace

std::string words_of(const Attempt& a) {
  return a.tolerance > 0 ? fmt::format("tolerance {:.1e}", a.tolerance)
                         : fmt::format("step {:.4g} ms", 1e3 * a.step);
}

Why why_of(const Tuning& t, const TuneChoices& c, std::size_t ladder) {
  const Ladder& l = t.ladders[ladder];
  if (!l.loaded->scene) return {"refused", l.loaded->refusal};
  const auto by_cost = [](const Attempt& a) { return a.cost; };
  const auto by_error = [](const Attempt& a) { return a.error; };
  const Attempt *precise = least(l, by_error), *cheap = least(l, by_cost);
  if (!precise || !t.choice) return failing(l);
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
