#include "tools/pantin/modes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "engine/scene/json/words.hpp"
#include "tools/pantin/command_line.hpp"

namespace pantin::program {
namespace {

/// The requested lamina, or the first; null after an error.
const LaminaPlan* lamina_of(const Scene& scene, const ModesChoices& c) {
  if (!scene.laminas) {
    complain(fmt::format("{}: found no \"laminas\", expected one or more", c.scene));
    return nullptr;
  }
  if (c.lamina.empty()) return &scene.laminas->front();
  std::vector<std::string_view> names;
  for (const LaminaPlan& plan : *scene.laminas) {
    if (plan.name == c.lamina) return &plan;
    names.push_back(plan.name);
  }
  complain(fmt::format("{}: --lamina: found \"{}\", expected the name of a lamina{}", c.scene,
                       c.lamina, hint(c.lamina, names)));
  return nullptr;
}

/// Applies --mu instead of the fingers' friction; returns false after an error.
bool set_friction(LaminaPlan& plan, const std::vector<double>& mu) {
  if (mu.empty()) return true;
  if (mu.size() != 1 && mu.size() != plan.fingers.size()) {
    complain(fmt::format("--mu: found {} numbers, expected 1, or {}: one for each finger",
                         mu.size(), plan.fingers.size()));
    return false;
  }
  for (std::size_t i = 0; i < plan.fingers.size(); ++i) {
    FingerPlan& f = plan.fingers[i];
    f.roll = f.slide = mu[mu.size() == 1 ? 0 : i];
    f.spread = Spread::at(f.slide);
  }
  return true;
}

int modes(ModesChoices c) {
  const EndsAtOnce while_nothing_is_written;
  if (c.range[0] >= c.range[1]) {
    complain(fmt::format("--range: found {:g},{:g}, expected the lower bound first", c.range[0],
                         c.range[1]));
    return kUsage;
  }
  std::optional<Scene> scene = open_scene(c.scene, {});
  if (!scene) return kUsage;
  const LaminaPlan* found = lamina_of(*scene, c);
  if (!found) return kUsage;
  LaminaPlan plan = *found;
  if (!set_friction(plan, c.mu)) return kUsage;
  if (c.duration == 0) c.duration = scene->duration;
  if (!c.against.empty()) return compare_with_dynamics(*scene, plan, c);
  if (!c.path.empty()) return follow_path(plan, c);
  if (!c.move.empty()) return move_on(*scene, plan, c);
  if (c.at > 0) {
    auto moved = plan_at(*scene, std::move(plan), c);
    if (!moved) return interrupted() ? kInterrupted : kUsage;
    plan = std::move(*moved);
  }
  if (std::ranges::none_of(plan.fingers, &FingerPlan::touches)) {
    complain(
        fmt::format("{}: lamina \"{}\": found no finger in contact at {:g} s, expected one: "
                    "without contacts there are no modes{}",
                    c.scene, plan.name, c.at, c.running.empty() ? "" : " (" + c.running + ")"));
    return kFailed;
  }
  std::optional<Grasp> grasp = grasp_of(plan, c.scene);
  if (!grasp) return kUsage;
  if (!c.axes.empty()) return draw_map(*grasp, c);
  if (c.advise) return print_advice(*grasp, c);
  if (c.uncertain) return print_outlook(*grasp, c);
  return print_modes(*grasp, c);
}

constexpr const char* kExamples =
    R"(A planar part that fingers hold or push slowly moves in one of a few contact modes: each
contact sticks (R, it rolls), slides (S) or separates (B). Prints the modes that hold, their motions
and forces, and the friction that allows them. A scene describes such parts under "laminas"; see
assets/README.md.

Examples:
  pantin modes assets/laminas/rod.json
  pantin modes assets/laminas/grasp.json --mu 0.3 --json
  pantin modes assets/laminas/grasp.json --map mu1,mu2
  pantin modes assets/laminas/grasp.json --map mu1,mu2 --out out/map.svg
  pantin modes assets/laminas/rod.json --at 12.6
  pantin modes assets/laminas/grasp.json --uncertain
  pantin modes assets/laminas/grasp.json --advise
  pantin modes assets/laminas/rod.json --move out/rod.csv
  pantin modes assets/laminas/rod.json --move out/rod.json && pantin run out/rod.json --gif out/rod.gif
  pantin modes assets/laminas/push.json --path out/bound.csv
  pantin modes assets/laminas/rod.json --against dynamics --duration 2 --out out/both.svg

A map shows where in the plane of two coefficients each mode holds: 1 all three contacts slide,
2 R1S2, 3 R1S3, 4 R2S1, 5 R2S3, 6 R3S1, 7 R3S2 of up to three contacts (R2S1: the second sticks, the
first slides); with more contacts, numbers as in the legend. Where there is no number, no mode
holds. With --json it prints the modes of the map and the fraction of its cells in which each holds.

--move moves the part as its fingers move and writes time, pose of the mass centre, mode (a letter
for each finger, + and - for the two ways to slide, . where it does not touch) and forces; it stops where no mode holds.
--path does so without friction and writes the bound of friction at each pose.
--at runs the scene to a time first, as `pantin run` does.
--against dynamics runs the same part with its mass, by the solver lagrangian, at decreasing finger
speed, and reports where they diverge and which assumptions fail there: inertia against friction, a
contact that should stick and slips, one that is lost, a choice among several modes.

Exit codes: 0 ok, 1 not possible here, 2 usage or bad input, 4 could not write.)";

void add_friction(const Subcommand& command, ModesChoices& c) {
  command.option("--lamina", c.lamina, "name of the lamina; default: the first");
  command
      .option("--mu", c.mu,
              "friction of all fingers, or of each: 0.3 or 0.3,0.4,0.5; default: that of the scene")
      .separated_by(',')
      .between(0, 1e6);
  command.flag("--uncertain", c.uncertain,
               "probabilities and worst cases where fingers have \"friction_between\"");
  command.flag("--advise", c.advise,
               "the smallest displacement of one finger along its edge that makes a mode certain");
}

void add_outputs(const Subcommand& command, ModesChoices& c) {
  command.option("--map", c.axes, "map over two coefficients, as in mu1,mu2").type("MU,MU");
  command.option("--range", c.range, "of the map's coefficients, default 0,1")
      .separated_by(',')
      .count(2)
      .between(0, 1e6);
  command.option("--size", c.size, "columns of a map, default 256").within(2, 4096);
  command.option("--out", c.out, "draw the map, or the comparison, into this file instead")
      .ends_in({".svg", ".png", ".csv"})
      .type(kFileType);
  command.option("--path", c.path, "write the bound of friction along the motion")
      .ends_in({".csv"})
      .type(kFileType);
  command.option("--move", c.move, "move it, and write its motion: a table, or a scene to draw")
      .ends_in({".csv", ".json"})
      .type(kFileType);
  command
      .option("--at", c.at,
              "the modes, map or advice at this time of the scene's run, s; default 0")
      .between(0, 1e6);
  command.option("--against", c.against, "compare the motion with another model")
      .one_of({"dynamics"});
  command.option("--samples", c.samples, "rows of --path and --move, default 101")
      .within(2, 1'000'000);
  command.option("--duration", c.duration, "of the motion, s; default: the scene's")
      .between(1e-9, 1e6);
  command.flag("--json", c.json, "print one JSON object instead of text");
}

}  // namespace

void add_modes(CommandLine& program) {
  auto c = std::make_shared<ModesChoices>();
  const Subcommand command =
      program.add("modes", "Reports which contacts stick or slide, for which friction");
  command.option("scene", c->scene, "a scene file with \"laminas\"").required().type(kSceneType);
  add_friction(command, *c);
  add_outputs(command, *c);
  constexpr const char* kAnswers[] = {"--map",     "--path",      "--move",
                                      "--against", "--uncertain", "--advise"};
  for (std::size_t i = 0; i < std::size(kAnswers); ++i)
    for (std::size_t k = 0; k < i; ++k)
      command.added(kAnswers[i]).excludes(command.added(kAnswers[k]));
  for (const char* other : {"--path", "--move", "--uncertain", "--advise"})
    command.added("--out").excludes(command.added(other));
  for (const char* other : {"--path", "--move", "--against"})
    command.added("--at").excludes(command.added(other));
  command.footer(kExamples);
  command.runs([c] { return modes(*c); });
}

}  // namespace pantin::program
