#include <fmt/format.h>

#include <memory>

#include "engine/base/utf8.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/tune_groups.hpp"

namespace pantin::program {
namespace {

Json attempt_json(const Attempt& a) {
  return {{"step_s", a.step},
          {"tolerance", a.tolerance > 0 ? Json(a.tolerance) : Json(nullptr)},
          {"status", a.status},
          {"reason", a.reason},
          {"error", json_number(a.error)},
          {"cost_us", json_number(1e6 * a.cost)}};
}

constexpr double kGroupsPart = 0.1;  // of the time, for the run that finds the groups

/// The simulated seconds of so many samples.
double time_of(const Tuning& t, std::size_t samples) {
  return samples > 0 ? static_cast<double>(samples - 1) * t.subject.sampling.spacing() : 0.0;
}

/// What is the same for one choice and for groups.
Json head_of(const Subject& subject, const TuneChoices& c) {
  Json j = build_and_machine();
  j["scene"] = c.scene, j["title"] = subject.own().title;
  j["duration_s"] = subject.sampling.duration();
  j["error"] = c.error ? Json(*c.error) : Json(nullptr);
  j["time_us"] = c.time ? Json(*c.time) : Json(nullptr);
  return j;
}

Json reference_json(const Tuning& t) {
  const Reference& r = t.reference;
  return {{"method", r.method},
          {"step_s", r.step},
          {"error", json_number(r.own.position / r.size)},
          {"size_m", r.size},
          {"compared_s", time_of(t, r.compared)}};
}

Json methods_json(const Tuning& t, const TuneChoices& c) {
  Json all = Json::array();
  for (std::size_t l = 0; l < t.ladders.size(); ++l) {
    const Why why = why_of(t, c, l);
    Json method{{"method", t.ladders[l].loaded->method.name},
                {"verdict", why.verdict},
                {"why", why.sentence},
                {"runs", Json::array()}};
    for (const Attempt& a : t.ladders[l].attempts) method["runs"].push_back(attempt_json(a));
    all.push_back(std::move(method));
  }
  return all;
}

Json as_json(const Tuning& t, const TuneChoices& c) {
  Json j = head_of(t.subject, c);
  j["reference"] = reference_json(t), j["methods"] = methods_json(t, c);
  j["groups"] = Json::array();
  j["met"] = t.is_met;
  j["choice"] = nullptr;
  if (t.choice) {
    j["choice"] = attempt_json(t.attempt());
    j["choice"]["method"] = t.method().loaded->method.name;
  }
  return j;
}

Json as_json(const GroupTuning& t, const TuneChoices& c) {
  Json j = head_of(t.subject, c);
  j["reference"] = nullptr, j["methods"] = Json::array(), j["groups"] = Json::array();
  for (std::size_t k = 0; k < t.kinds.size(); ++k) {
    const std::vector<std::size_t>& groups = t.grouping.kinds[k].groups;
    const Group& first = t.grouping.groups[groups.front()];
    Json group{{"group", first.name},
               {"alike", groups.size()},
               {"bodies", first.bodies.size()},
               {"reference", reference_json(t.kinds[k])},
               {"why", why_of_kind(t, k)},
               {"methods", methods_json(t.kinds[k], c)},
               {"choice", nullptr}};
    if (const Composition* choice = t.choice()) {
      group["choice"] = attempt_json(t.attempt(*choice, k));
      group["choice"]["method"] = t.ladder(*choice, k).loaded->method.name;
    }
    j["groups"].push_back(std::move(group));
  }
  j["met"] = t.is_met, j["why"] = why_of_scene(t);
  j["mixed"] = composition_json(t, t.mixed), j["uniform"] = composition_json(t, t.uniform);
  j["choice"] = t.choice() ? j[t.is_mixed ? "mixed" : "uniform"] : Json(nullptr);
  return j;
}

void print_tuning(const Tuning& t, const TuneChoices& c) {
  const double duration = t.subject.sampling.duration();
  fmt::print("{}\n", bold(fmt::format("{}: {:.3g} s", c.scene, duration)));
  const Reference& r = t.reference;
  if (r.holds())
    fmt::print(
        "  reference   {}, steps of {:.3g} ms, own error {:.1e} of the size{}\n", r.method,
        1e3 * r.step, r.own.position / r.size,
        r.compared == t.subject.sampling.samples()
            ? ""
            : fmt::format("; errors are those of the first {:.3g} s", time_of(t, r.compared)));
  for (std::size_t l = 0; l < t.ladders.size(); ++l) {
    const Why why = why_of(t, c, l);
    fmt::print("  {:<28} {:<8} {}\n", t.ladders[l].loaded->method.name, why.verdict,
               printable(why.sentence));
  }
  if (!t.choice) return;
  const Attempt& a = t.attempt();
  const std::string part =
      r.compared == t.subject.sampling.samples()
          ? ""
          : fmt::format(" in the first {:.3g} s of {:.3g} s", time_of(t, r.compared), duration);
  fmt::print(
      "  {}      {}, {}: error {:.2g} of the size{}, {:.3g} us for a simulated second ({:.2g} % "
      "of a core)\n",
      t.is_met ? "choice" : "best  ", t.method().loaded->method.name, words_of(a), a.error, part,
      1e6 * a.cost, 100 * a.cost);
}

/// What keeps a search from its end, or an empty string.
std::string fault_of(const Tuning& t, const TuneChoices& c) {
  if (!t.reference.holds())
    return t.reference.tried.empty()
               ? "no reference: the time was too short for two runs of any method; repeat with a "
                 "longer --within"
               : "no reference: no method agrees with itself";
  if (t.unseen) return words_of_unseen(t);
  if (!t.choice) return "no run succeeded within the time";
  if (t.is_met) return {};
  return c.error
             ? fmt::format("no setting meets an error of {:g} among {}; the best one has {:.2g}",
                           *c.error, words_of_tried(t), t.attempt().error)
             : fmt::format("no setting runs within {:g} us; the cheapest one takes {:.3g} us",
                           *c.time, 1e6 * t.attempt().cost);
}

int complain_of(const std::vector<Error>& errors, int code) {
  for (const Error& e : errors) print_error(e.message);
  return code;
}

/// Prints what was found, and writes the choice if one is asked for.
template <class T, class Print, class Write>
int finish(const Result<T>& t, const TuneChoices& c, Print print, Write write) {
  if (interrupted()) {
    complain("interrupted; the same command goes on from here");
    return kInterrupted;
  }
  if (!t) return complain_of(t.errors(), kUsage);
  if (c.json)
    print_json(as_json(*t, c));
  else
    print(*t, c);
  if (const std::string fault = fault_of(*t, c); !fault.empty()) {
    complain(c.scene + ": " + fault);
    return kDiverged;
  }
  if (c.out.empty()) return kOk;
  const Result<std::string> text = write(*t);
  if (!text) return complain_of(text.errors(), kFailed);
  return write_or_complain(c.out, *text);
}

int tune(const TuneChoices& c) {
  if (c.error.has_value() == c.time.has_value()) {
    complain(fmt::format("found {}, expected one of --error and --time",
                         c.error ? "both" : "neither --error nor --time"));
    return kUsage;
  }
  if (const auto made = make_folder(c.results); !made)
    return complain_of(made.errors(), kUnwritable);
  Journal journal;
  if (const auto opened =
          journal.open(c.results + "/runs.jsonl",
                       c.afresh ? Journal::Earlier::discarded : Journal::Earlier::kept);
      !opened)
    return complain_of(opened.errors(), kUnwritable);
  const double begin = wall_seconds();
  Result<Subject> subject = read_subject(c.scene, {c.duration, c.coarsest, 4});
  if (!subject) return complain_of(subject.errors(), kUsage);
  const Sampling& s = subject->sampling;
  subject->key += fmt::format("|{}|{}|{}|", s.interval, s.count, s.between);
  Grouping grouping = groups_of(subject->own(), subject->sampling, kGroupsPart * c.within);
  if (grouping.groups.size() > 1 && grouping.kinds.size() <= kMostKinds)
    return finish(tune_groups(c, journal, {std::move(*subject), begin}, std::move(grouping)), c,
                  print_groups, with_groups);
  return finish(tune_whole(c, journal, {std::move(*subject), begin}), c, print_tuning, with_choice);
}

constexpr const char* kExamples =
    R"(Chooses the cheapest solver, integrator and step (or tolerance) whose error is at most --error,
or the most accurate one that takes at most --time. Every method that runs the scene is tried: steps
are halved, tolerances divided by ten, the cheapest run next, until the method meets the error, costs
more than one that does, fails four times, or the time is over; then one setting between the last two. The best ones are timed again in turn. A sentence says of each method why it was
or was not chosen. Results are kept in the folder of --results: the same command goes on.

Examples:
  pantin tune assets/scenes/planar_four_bar.json --error 1e-2 --within 10 --out out/tuned.json
  pantin tune assets/scenes/chain10.json --time 20000 --duration 1 --within 10
  pantin tune assets/scenes/pendulum.json --error 1e-4 --within 10 --json

Groups of bodies that never meet (no joint or other tie joins them, and those that collide stay apart
in a run of the scene's own settings) may have methods of their own at one common step. Each is
searched alone, with the fixed and kinematic bodies; copies share a search. Errors are then fractions
of the size of each group, and the choice is verified by a run of the whole scene. One method for all
groups is chosen where it is as cheap. Scenes with more than 24 kinds of groups have one method.

Error: the greatest distance of any point of a body from the reference, plus the reference's own
error, as a fraction of the size of the motion (the diagonal of the box around all positions, or the
diameter of the largest body if that is longer). The distance of a body is that of its mass centre
plus the angle between its rotations times its radius (to the farthest point of its shapes; without
shapes, the radius of gyration). It is looked at after every step, at 200 times or more; of a body
that moves so fast that a cubic between the steps misses a tenth of its way, as a wheel that turns
once a step, also between them. The reference is that of `pantin chart`: a run that is refined until
it agrees with itself; where refinements part, as those of chaotic motions do, errors are those of
the first half of the time until then. If an event of the scene follows that part, nothing is vouched
for: exit code 3. Cost: CPU time of the steps alone, microseconds for a simulated second; 1e6 is one
core in real time; the least of five rounds where costs are close.

--out writes the scene with the keys "solver" and "step" of the choice, groups of their own as "solver"
of a body, chain, instance, grid or ring; the rest of the file stays as it is, but for "error" and
"plane", by which a scene chooses itself. The file is written only if it moves exactly as what was measured.

--json prints the build and machine, scene, title, duration_s, error, time_us, reference (method,
step_s, error, size_m, compared_s), methods (method, verdict: chosen, best, dearer, misses, fails,
refused or not_run, why, runs), groups, met and choice (method and those of a run); a run has step_s,
tolerance, status, reason, error, cost_us. Of several groups, groups lists each kind (group, alike:
how many, bodies, reference, why, methods, choice), mixed and uniform are the best choice by groups
and of one method, with foreseen_us, the sum of the groups alone, and why says which was chosen.

Exit codes: 0 ok, 1 the choice cannot be written, 2 usage or bad input, 3 nothing meets what is asked
(the best one is printed, and nothing written), 4 could not write, 130 interrupted.)";

}  // namespace

void add_tune(CommandLine& program) {
  auto c = std::make_shared<TuneChoices>();
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  const Subcommand command =
      program.add("tune", "Chooses the cheapest solver and step that are accurate enough");
  command.option("scene", c->scene, "scene file").required().type(kSceneType);
  command.option("--error", c->error, "largest error, as a fraction of the size of the motion")
      .between(1e-15, 1);
  command.option("--time", c->time, "most CPU time, microseconds for a simulated second")
      .between(1e-3, 1e12);
  command.option("--out", c->out, "scene file to write").type(kSceneType);
  command.option("--methods", c->methods, "these only, commas between")
      .separated_by(',')
      .one_of(names)
      .one_at_a_time();
  command.option("--coarsest", c->coarsest, "the longest step, s; default: four times the scene's")
      .between(1e-6, 1.0);
  command.option("--rungs", c->rungs, "most settings of a method; default 8").within(1, 20);
  command.option("--duration", c->duration, "simulated seconds").between(1e-6, 1e6);
  command.option("--within", c->within, "seconds for the search; default 60").between(0.1, 1e6);
  command.option("--results", c->results, "folder of what was measured; default out/tune")
      .type(kFolderType);
  command.flag("--afresh", c->afresh, "discard the results of earlier runs in that folder");
  command.flag("--json", c->json, "print one JSON object instead of text");
  command.footer(kExamples);
  command.runs([c] { return tune(*c); });
}

}  // namespace pantin::program
