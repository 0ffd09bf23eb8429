#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/scene/build/joint_place.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/solvers/takeover.hpp"
#include "engine/world/surface_start.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr int kSteps = 60;
constexpr double kMostSeconds = 5;  // of CPU time, for the steps of a scene

struct CheckChoices {
  std::vector<std::string> scenes;
  SceneChoices how;
  bool json = false;
};

/// The result of checking one scene and its first steps.
struct Finding {
  int exit_code = kOk;
  Json json;
};

/// Degrees of freedom of bodies under solver `planar`: three each, minus those that joints, gears,
/// belts and exact pins remove in the plane.
std::int64_t freedoms_of_plane(const World& world) {
  std::int64_t sum = 0;
  const auto is_there = [&](Entity e) {
    const std::uint32_t slot = world.bodies.slot(e);
    return slot != kNoSlot && is_planar(world, slot);
  };
  for (const Entity e : world.bodies.owners()) sum += is_there(e) ? 3 : 0;
  for (const Link& l : world.links.values()) {
    if (!is_there(l.a) && !is_there(l.b)) continue;
    const JointKind kind = l.joint.kind;
    if (kind == JointKind::spring) continue;
    sum -= kind == JointKind::fixed ? 3 : kind == JointKind::distance ? 1 : 2;
  }
  for (const Gear& g : world.gears.values())
    if (const Link* l = world.links.find(g.first)) sum -= is_there(l->a) || is_there(l->b);
  for (const Belt& b : world.belts.values())
    if (std::any_of(b.pulleys.begin(), b.pulleys.end(),
                    [&](const BeltPulley& p) { return is_there(p.body); }))
      sum -= static_cast<std::int64_t>(held_spans(world, b));
  for (const Pin& p : world.pins.values())
    if (p.kind == PinKind::exact && is_there(p.body)) sum -= 2;
  return sum;
}

/// The first joint of an island that has a motor, or none.
Entity motor_of(const World& world, const lagrangian::Island& m) {
  for (const lagrangian::Block& b : m.blocks) {
    if (b.kind != lagrangian::BlockKind::joint) continue;
    const JointParameters& p = *world.links.values()[b.source].joint.parameters;
    if (p.rotation.motor.kind != MotorKind::none || p.translation.motor.kind != MotorKind::none)
      return world.links.owners()[b.source];
  }
  return {};
}

struct Freedoms {
  std::int64_t count = 0;
  std::vector<Entity> stuck;  // joints with a motor, of mechanisms without freedom
};

/// Degrees of freedom left by joints, belts, surface contacts and exact pins: 6 per body, minus the
/// rank of their rows. Counted by the solver that has rows for every kind of joint, whichever
/// solver runs the scene.
Freedoms degrees_of_freedom(const World& world) {
  World counted = world;
  counted.default_settings.solver = Solver::lagrangian;
  for (SolverSettings& settings : counted.settings.values()) settings.solver = Solver::lagrangian;
  counted.mark_dirty();
  compile_if_changed(counted);
  Freedoms all{freedoms_of_plane(world), {}};
  for (std::size_t i = 0; i < lagrangian::islands_of(counted).size(); ++i) {
    const lagrangian::Island& m = lagrangian::islands_of(counted)[i];
    if (m.count() > 0 && is_planar(world, m.slots[0])) continue;
    std::int64_t own = 6 * static_cast<std::int64_t>(m.count());
    for (const lagrangian::Block& b : m.blocks)
      if (b.kind == lagrangian::BlockKind::joint || b.kind == lagrangian::BlockKind::pin ||
          b.kind == lagrangian::BlockKind::gear || b.kind == lagrangian::BlockKind::belt ||
          b.kind == lagrangian::BlockKind::roll ||
          (b.kind == lagrangian::BlockKind::surface && b.lock))
        own -= b.rows;
    for (const lagrangian::Fault& f : lagrangian::inspect(counted, i))
      if (f.kind == lagrangian::Fault::redundant) own += f.rows;
    all.count += own;
    if (const Entity joint = motor_of(counted, m); joint && own <= 0) all.stuck.push_back(joint);
  }
  return all;
}

/// Joints with springs or motors that are too stiff for the integrator at the scene's step.
std::vector<std::string> stiff_joints(const Scene& scene) {
  std::vector<std::string> found;
  const World& world = scene.world;
  for (std::size_t i = 0; i < lagrangian::islands_of(world).size(); ++i)
    if (const Entity joint =
            lagrangian::too_stiff_joint(world, i, scene.step / std::max(1, scene.substeps)))
      found.push_back(
          fmt::format("joint {}: its spring, damper or motor is too stiff for the moved mass; {} "
                      "cannot take steps of {:.3g} s with it, and Euler's method takes them. "
                      "\"integrator\": \"radau\" follows it",
                      world.name_of(joint),
                      name_of(lagrangian::islands_of(world)[i].settings.integrator), scene.step));
  return found;
}

/// Takes sixty steps, or as many as time permits; the second half twice: directly and from a copy.
/// Returns why it failed, or an empty string.
std::string step_through(const Scene& scene, Json& j) {
  const StepSettings how{scene.step, scene.substeps, 1, true};
  Simulation sim = Simulation::copy_of(scene.world, how), copy;
  double worst = 0;
  const double start = cpu_seconds();
  int steps = 0;
  for (int i = 0; i < kSteps && cpu_seconds() - start < kMostSeconds; ++i, ++steps) {
    if (i == kSteps / 2) copy = Simulation::copy_of(sim.world, how);
    const StepReport report = sim.step();
    if (report.status == Status::diverged)
      return fmt::format("diverged at {:.6g} s: body {}, worst joint gap {:.3g} m", report.time,
                         sim.world.name_of(report.body), report.residual);
    if (report.status == Status::contact_lost)
      return fmt::format("contact lost at {:.6g} s: {}", report.time,
                         words_of_lost_contact(sim.world, report));
    if (report.status == Status::inconsistent && report.body)
      return fmt::format("inconsistent at {:.6g} s: {}", report.time,
                         words_of_inconsistency(sim.world, report));
    if (report.status == Status::energy_grew)
      return fmt::format("energy grew severalfold without work at {:.6g} s: body {}", report.time,
                         sim.world.name_of(report.body));
    worst = std::max(worst, report.measures.worst_gap_rel);
    if (worst > scene.drift_bound)
      return fmt::format(
          "drifted at {:.6g} s: joint {} is open by {:.3g} of the size, allowed {:.3g}",
          report.time, sim.world.name_of(report.measures.worst_link), worst, scene.drift_bound);
  }
  j["steps"] = steps;
  j["worst_gap_rel"] = worst;
  for (int i = kSteps / 2; i < steps; ++i) copy.step();
  const std::uint64_t hash = state_hash(sim.world);
  j["hash"] = hex(hash);
  if (steps > kSteps / 2 && state_hash(copy.world) != hash)
    return "a copy of the World did not end in the same bits";
  return {};
}

/// How far the surfaces of a joint are apart, m, or, below 0, within one another; nothing where
/// they do not face one another. Those that may part may be apart.
std::optional<Real> surface_gap(const World& world, const SurfaceContact& c) {
  constexpr Real kReach = 1e3;  // m
  const Body *a = world.bodies.find(c.a), *b = world.bodies.find(c.b);
  if (!a || !b) return std::nullopt;
  const Pose a_in_b =
      compose(inverse(compose(b->pose, c.on_b.pose)), compose(a->pose, c.on_a.pose));
  nurbs::CommonNormal found[8];
  const std::size_t count = find_pairs(c, a_in_b, {kReach, found});
  if (count == 0) return std::nullopt;
  const auto nearest = std::min_element(found, found + count, [](const auto& x, const auto& y) {
    return std::abs(x.gap) < std::abs(y.gap);
  });
  return c.lifts ? std::min(nearest->gap, Real(0)) : nearest->gap;
}

/// The largest gap at the start, with a warning of surfaces that the first step moves.
Real start_gap(const std::string& path, Scene& scene) {
  constexpr Real kLarge = 0.1;  // of the smaller surface
  const auto size_of = [](const ContactSurface& s) {
    return s.skin ? s.skin->size() : s.curve ? s.curve->size() : 0;
  };
  const World& world = scene.world;
  Real most = measure(world).worst_gap;
  for (std::size_t i = 0; i < world.surface_contacts.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    const Real gap = surface_gap(world, c).value_or(0);
    most = std::max(most, std::abs(gap));
    if (std::abs(gap) <= kLarge * std::min(size_of(c.on_a), size_of(c.on_b))) continue;
    scene.warnings.push_back(fmt::format(
        "{}: the surfaces of {} start {:.3g} m {}; the first step moves them together, which "
        "changes the energy: `pantin assemble` places them",
        path, world.name_of(world.surface_contacts.owners()[i]), std::abs(gap),
        gap < 0 ? "within one another" : "apart"));
  }
  return most;
}

Finding look_at(const std::string& path, const CheckChoices& c) {
  Finding found;
  found.json["scene"] = path;
  std::optional<Scene> scene = open_scene(path, c.how);
  if (!scene) {
    found.json["status"] = "refused";
    found.exit_code = kUsage;
    return found;
  }
  const World& world = scene->world;
  double mass = 0;
  for (const Body& b : world.bodies.values())
    if (b.motion == Motion::dynamic) mass += b.mass;
  Json& j = found.json;
  j["title"] = scene->title;
  j["status"] = "ok";
  j["bodies"] = world.bodies.size();
  j["joints"] = world.links.size();
  j["cables"] = world.cables.size();
  j["pins"] = world.pins.size();
  j["articulated_islands"] = articulated::islands_of(world).size();
  j["lagrangian_islands"] = lagrangian::islands_of(world).size();
  j["solver"] = solver_in_use(world);
  j["solvers"] = solvers_json(world);
  const Freedoms freedoms = degrees_of_freedom(world);
  j["freedoms"] = freedoms.count;
  j["mass_kg"] = mass;
  j["start_gap_m"] = start_gap(path, *scene);
  for (const Entity joint : freedoms.stuck)
    scene->warnings.push_back(
        fmt::format("{}: joint {} has a motor, but its mechanism has no degree of freedom: an axis "
                    "that is not parallel to the others locks it",
                    path, world.name_of(joint)));
  if (!c.json) print_warnings(*scene);
  std::string failure = step_through(*scene, j);
  const int steps = j.value("steps", kSteps);
  if (steps < kSteps)
    print_error(fmt::format(
        "warning: {}: took {} of {} steps in {:g} s of CPU time; the rest is not checked", path,
        steps, kSteps, kMostSeconds));
  for (const StructureFault& f : partition_of(world).faults)
    if (failure.empty() && !f.is_minor)
      failure = fmt::format("{} {}", world.name_of(f.link), f.reason);
  if (!failure.empty()) {
    j["status"] = "failed";
    j["failure"] = failure;
    complain(fmt::format("{}: {}", path, failure));
    found.exit_code = kDiverged;
  }
  std::vector<std::string> warnings = scene->warnings;
  for (const std::string& warning : stiff_joints(*scene)) {
    if (!c.json) print_error(fmt::format("warning: {}: {}", path, warning));
    warnings.push_back(warning);
  }
  j["warnings"] = warnings;
  const std::vector<std::string> beyond = lines_beyond_auto(world);
  j["beyond_auto"] = beyond;
  const bool is_as_written = !c.how.solver && c.how.set.empty();
  const std::vector<std::string> models =
      is_as_written ? lines_of_models(path) : std::vector<std::string>();
  j["models"] = models;
  if (!c.json)
    fmt::print(
        "{}  {}\n  {} bodies, {} joints, {} cables, {} pins in {} articulated and {} Lagrangian "
        "islands; {} "
        "freedoms, {:.4g} kg\n  solver {}; start gap {:.1e} m; {} steps: {}\n",
        failure.empty() ? "ok    " : "FAILED", printable(path), world.bodies.size(),
        world.links.size(), world.cables.size(), world.pins.size(),
        articulated::islands_of(world).size(), lagrangian::islands_of(world).size(),
        j["freedoms"].get<std::int64_t>(), mass, describe_solvers(world),
        j["start_gap_m"].get<double>(), steps,
        failure.empty()
            ? fmt::format("worst gap {:.1e} of the size, hash {}", j["worst_gap_rel"].get<double>(),
                          j["hash"].get<std::string>())
            : printable(failure));
  for (const auto* lines : {&models, &beyond})
    for (const std::string& line : *lines)
      if (!c.json) fmt::print("  {}\n", printable(line));
  std::fflush(stdout);  // whole lines, in case the next scene is interrupted
  return found;
}

int check(const CheckChoices& c) {
  const EndsAtOnce while_nothing_is_written;
  int worst = kOk;
  Json all = Json::array();
  for (const std::string& path : c.scenes) {
    const Finding found = look_at(path, c);
    // Bad input takes precedence, since nothing of that scene could be checked.
    if (found.exit_code == kUsage || worst == kOk) worst = found.exit_code;
    all.push_back(found.json);
  }
  if (c.json) print_json(Json{{"scenes", all}});
  return worst;
}

constexpr const char* kExamples =
    R"(Loads each scene, reports its contents and warnings, and takes 60 steps. Every number must be
finite, joint gaps within the scene's drift_bound (by default 1e-12 of the size, 1e-5 where joints
of auto close loops), and a copy made during the run must end in the same bits. A scene that is too
large for this machine is stepped for 5 s of CPU time, with a warning.

Examples:
  pantin check assets/scenes/marionette.json
  pantin check assets/scenes/*.json --json
  pantin check assets/scenes/chain10.json --solver lagrangian

--json prints {"scenes": [...]}, each with scene, title, status (ok, failed, refused), bodies,
joints, cables, pins, articulated_islands, lagrangian_islands, solver, solvers (bodies of each), freedoms,
mass_kg, start_gap_m, steps, worst_gap_rel, hash, warnings, models (what "error" in the scene chose
for which bodies, and why) and failure if there is one.

Exit codes: 0 ok, 2 usage or bad input, 3 a check failed.)";

}  // namespace

void add_check(CommandLine& program) {
  auto c = std::make_shared<CheckChoices>();
  const Subcommand command = program.add("check", "Checks scenes and their first steps");
  command.option("scene", c->scenes, "scene files").required().type(kSceneType);
  add_scene_choices(command, c->how);
  command.flag("--json", c->json, "print one JSON object instead of text");
  command.footer(kExamples);
  command.runs([c] { return check(*c); });
}

}  // namespace pantin::program
