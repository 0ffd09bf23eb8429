// What `pantin tune` says of groups of bodies.
#include <fmt/format.h>

#include <algorithm>

#include "engine/base/utf8.hpp"
#include "tools/pantin/tune_groups.hpp"

namespace pantin::program {
namespace {

/// The cheapest attempt of another method of a group at the step of the choice that meets its
/// error, or null.
const Attempt* runner_up(const GroupTuning& t, const Composition& c, std::size_t kind,
                         std::string& method) {
  const Attempt* best = nullptr;
  const double error = std::max(t.attempt(c, kind).error, c.error);
  for (const Ladder& l : t.kinds[kind].ladders)
    for (const Attempt& a : l.attempts)
      if (&l != &t.ladder(c, kind) && a.is_ok() && a.step == c.step && a.error <= error &&
          (!best || a.cost < best->cost))
        best = &a, method = l.loaded->method.name;
  return best;
}

/// Why no other method is as good, a clause.
std::string words_of_others(const GroupTuning& t, const Composition& c, std::size_t kind) {
  std::string next, why;
  if (const Attempt* other = runner_up(t, c, kind, next))
    return fmt::format("{} would cost {:.3g} times as much", next,
                       other->cost / t.attempt(c, kind).cost);
  for (const Ladder& l : t.kinds[kind].ladders)
    if (why.empty() && !l.loaded->scene) why = l.loaded->refusal;
  return "no other method that is as accurate at this step was found" +
         (why.empty() ? "" : "; " + why);
}

}  // namespace

std::string words_of_kind(const GroupTuning& t, std::size_t kind) {
  const std::vector<std::size_t>& groups = t.grouping.kinds[kind].groups;
  const std::string& name = t.grouping.groups[groups.front()].name;
  return groups.size() == 1 ? name : fmt::format("{} ({} alike)", name, groups.size());
}

std::string why_of_kind(const GroupTuning& t, std::size_t kind) {
  const Group& group = t.grouping.groups[t.grouping.kinds[kind].groups.front()];
  const Tuning& own = t.kinds[kind];
  if (!own.reference.holds()) return "no method agrees with itself in the time";
  if (own.unseen) return "an event is outside of what can be compared";
  const Composition* c = t.choice();
  if (!c) return "no run succeeded within the time";
  if (group.has_laminas) return "laminas are moved by \"quasistatic\", which nothing else replaces";
  const Attempt& a = t.attempt(*c, kind);
  std::string words = fmt::format(
      "error {:.2g} for {:.3g} us; {}", a.error, 1e6 * a.cost,
      t.is_mixed ? words_of_others(t, *c, kind) : "as all groups, for no group gains enough");
  const double end = t.subject.sampling.duration();
  if (group.sleeps_from < 0.9 * end)
    words +=
        fmt::format("; it sleeps from {:.2g} s on, which costs next to nothing", group.sleeps_from);
  return words;
}

std::string why_of_scene(const GroupTuning& t) {
  if (!t.choice()) return "";
  if (!t.mixed) return "the same method is the best one for every group";
  if (!t.uniform || t.uniform->status != "ok")
    return "no single method is good enough for all groups";
  const double ratio = t.uniform->cost / t.mixed->cost;
  const std::string best = t.ladder(*t.uniform, 0).loaded->method.name;
  const std::string at = words_of(t.attempt(*t.uniform, 0));
  if (t.is_mixed)
    return fmt::format("the best single choice, {} at {}, costs {:.3g} times as much", best, at,
                       ratio);
  return fmt::format(
      "one method for all groups: methods of their own would cost {:.3g} times as "
      "much, which is not enough of a gain",
      1 / ratio);
}

Json composition_json(const GroupTuning& t, const std::optional<Composition>& c) {
  if (!c) return nullptr;
  const bool is_mixed = &c == &t.mixed;
  const Attempt& first = t.attempt(*c, 0);
  const bool adapts = !is_mixed && first.tolerance > 0;
  return {{"method", is_mixed ? "mixed" : t.ladder(*c, 0).loaded->method.name},
          {"step_s", c->step},
          {"tolerance", adapts ? Json(first.tolerance) : Json(nullptr)},
          {"status", c->status},
          {"reason", c->reason},
          {"error", json_number(c->measured_error)},
          {"cost_us", json_number(1e6 * c->cost)},
          {"foreseen_us", json_number(1e6 * c->foreseen)}};
}

void print_groups(const GroupTuning& t, const TuneChoices& c) {
  fmt::print("{}\n", bold(fmt::format("{}: {:.3g} s, {} groups that never meet", c.scene,
                                      t.subject.sampling.duration(), t.grouping.groups.size())));
  const Composition* choice = t.choice();
  for (std::size_t k = 0; k < t.kinds.size(); ++k)
    fmt::print("  {:<28} {}{}\n", printable(words_of_kind(t, k)),
               choice ? fmt::format("{}, {}: ", t.ladder(*choice, k).loaded->method.name,
                                    words_of(t.attempt(*choice, k)))
                      : "",
               printable(why_of_kind(t, k)));
  if (t.grouping.kinematic > 0)
    fmt::print("  {:<28} kinematic: they follow their paths, and no solver moves them\n",
               fmt::format("{} bodies", t.grouping.kinematic));
  if (!choice) return;
  fmt::print(
      "  {}      step {:.4g} ms: error {:.2g} of the size of {}, {:.3g} us for a simulated second "
      "({:.3g} foreseen); {}\n",
      t.is_met ? "choice" : "best  ", 1e3 * choice->step, choice->measured_error,
      printable(words_of_kind(t, choice->worst)), 1e6 * choice->cost, 1e6 * choice->foreseen,
      why_of_scene(t));
}

std::string fault_of(const GroupTuning& t, const TuneChoices& c) {
  for (std::size_t k = 0; k < t.kinds.size(); ++k)
    if (!t.kinds[k].reference.holds())
      return fmt::format("no reference for {}: no method agrees with itself in the time",
                         words_of_kind(t, k));
  for (std::size_t k = 0; k < t.kinds.size(); ++k)
    if (t.kinds[k].unseen)
      return fmt::format("{}: {}", words_of_kind(t, k), words_of_unseen(t.kinds[k]));
  const Composition* choice = t.choice();
  if (!choice) return "no run succeeded within the time";
  if (t.is_met) return {};
  if (choice->status != "ok")
    return fmt::format("the whole scene ends with \"{}\" under the choice for its groups",
                       choice->status);
  return c.error ? fmt::format("no setting meets an error of {:g}; the best one has {:.2g}",
                               *c.error, choice->measured_error)
                 : fmt::format("no setting runs within {:g} us; the cheapest one takes {:.3g} us",
                               *c.time, 1e6 * choice->cost);
}

}  // namespace pantin::program
