#include <algorithm>
#include <filesystem>
#include <map>

#include "engine/base/disjoint_sets.hpp"
#include "engine/base/utf8.hpp"
#include "engine/scene/build/build.hpp"
#include "engine/scene/build/joint_place.hpp"
#include "engine/scene/json/text_file.hpp"
#include "engine/scene/read/json_recipe.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/ties.hpp"

namespace pantin {

using namespace detail;

namespace {

/// A sensor with its entities.
Sensor placed(const BuiltSensor& built, const std::vector<Entity>& bodies,
              const std::vector<Entity>& links) {
  Sensor sensor = built.sensor;
  const auto on = [&](std::uint32_t body) { return body == kWorldBody ? Entity{} : bodies[body]; };
  sensor.a.on = is_of_joint(sensor.kind) ? links[built.joint] : on(built.a);
  sensor.b.on = on(built.b), sensor.c.on = on(built.c);
  return sensor;
}

}  // namespace

void detail::build_world(const BuiltScene& built, World& world, std::vector<Sensor>* sensors) {
  std::vector<Entity> entities;
  entities.reserve(built.bodies.size());
  for (const BuiltBody& b : built.bodies) {
    const Entity e = world.add_body(b.body, b.name);
    entities.push_back(e);
    if (b.mass_properties->is_moved) world.origins.add(e, inverse(b.mass_properties->centre));
    if (!b.mass_properties->shapes.empty()) {
      Shapes& shapes = world.shapes.add(e, {b.mass_properties->shapes});
      if (b.material != UINT32_MAX)
        for (Shape& s : shapes.list) s.material = b.material;
    }
    if (b.solver) world.settings.add(e, *b.solver);
    if (b.collision) world.collisions.add(e, *b.collision);
  }
  Entity ground;  // one body for everything fixed to the world
  const auto entity = [&](std::uint32_t body) {
    if (body != kWorldBody) return entities[body];
    if (ground) return ground;
    Body fixed;
    fixed.motion = Motion::fixed;
    return ground = world.add_body(fixed, "world");
  };
  std::vector<Entity> links;
  links.reserve(built.joints.size());
  for (const BuiltJoint& j : built.joints) {
    const Entity a = entity(j.a), b = entity(j.b);
    links.push_back(add_link(world, {a, b, j.joint}, j.name));
    if (j.drive) world.joint_drives.add(links.back(), *j.drive);
  }
  std::vector<Entity> gears, cables, pins;
  for (const BuiltGear& r : built.gears) {
    Gear ratio = r.ratio;
    ratio.first = links[r.first], ratio.second = links[r.second];
    gears.push_back(add_gear(world, ratio, r.name));
  }
  for (const BuiltBelt& b : built.belts) {
    Belt belt = b.belt;
    for (std::size_t i = 0; i < b.bodies.size(); ++i) belt.pulleys[i].body = entities[b.bodies[i]];
    world.store<LaidBelt>().add(add_belt(world, belt, b.name), {b.laid});
  }
  for (const BuiltSurfaceJoint& s : built.surface_joints) {
    SurfaceContact contact = s.contact;
    contact.a = entity(s.a), contact.b = entity(s.b);
    add_surface_contact(world, contact, s.name);
  }
  for (const BuiltCable& s : built.cables) {
    const Entity a = entity(s.a), b = entity(s.b);
    cables.push_back(add_cable(world, {a, b, s.joint}, s.name));
    for (const BuiltGuide& g : s.guides) {
      CableGuide guide = g.guide;
      guide.body = entity(g.body);
      world.cables[cables.back()].guides.push_back(guide);
    }
  }
  for (const BuiltPin& p : built.pins) {
    Pin pin = p.pin;
    pin.body = entities[p.body];
    if (p.to != kWorldBody) pin.to = entities[p.to];
    pins.push_back(world.add_pin(pin, p.name));
  }
  for (const BuiltPath& d : built.paths) world.paths.add(entities[d.body], d.path);
  const std::vector<Entity>* const lists[] = {nullptr, &entities, &links, &cables, &pins, &gears};
  for (const BuiltEvent& e : built.events) {
    TimedEvent event = e.event;
    std::visit(
        [&](auto& kind) {
          const auto* list = lists[static_cast<std::size_t>(e.object)];
          if (Entity* on = target_of(kind); on && list) *on = (*list)[e.on];
          if constexpr (requires { kind.bodies; })
            for (const std::uint32_t body : e.bodies) kind.bodies.push_back(entities[body]);
        },
        event.kind);
    add_event(world, event);
  }
  for (std::size_t i = 0; sensors && i < built.sensors.size(); ++i)
    sensors->push_back(placed(built.sensors[i], entities, links));
}

void SolverChoices::apply(SolverSettings& settings) const {
  settings.solver = solver.value_or(settings.solver);
  settings.integrator = integrator.value_or(settings.integrator);
  settings.stabilisation = stabilisation.value_or(settings.stabilisation);
  settings.jacobians = jacobians.value_or(settings.jacobians);
  settings.step_tolerance = step_tolerance.value_or(settings.step_tolerance);
  if (!info_of(settings.integrator).takes_tolerance) settings.step_tolerance = 0;
}

namespace {

/// The joint gap that the solvers of a World guarantee, as a fraction of the size. `auto` and its
/// kin close loops by impulses; all other joints are closed to rounding.
Real promised_gap(const World& world) {
  constexpr Real kTrees = 1e-12, kLoops = 1e-5;
  const auto ground = static_cast<std::uint32_t>(world.bodies.size());
  std::vector<bool> own(ground, false);
  for (const IslandPlan& island : find_islands(world)) {
    const bool is_exact = info_of(island.settings.solver).closes_loops;
    for (const std::uint32_t slot : island.slots) own[slot] = !is_exact;
  }
  DisjointSets joined(ground + 1);
  const auto place_of = [&](Entity body) {
    const std::uint32_t slot = world.bodies.slot(body);
    return slot < ground && own[slot] ? slot : ground;
  };
  for (const Link& l : world.links.values()) {
    const std::uint32_t a = place_of(l.a), b = place_of(l.b);
    if (a == b) continue;  // of other solvers
    if (joined.root(a) == joined.root(b)) return kLoops;
    joined.join(a, b);
  }
  return kTrees;
}

/// The models of a scene that is not built yet.
std::vector<ModelChoice> models_of(const BuiltScene& built, const World& start, Real error) {
  World world = start;
  build_world(built, world);
  std::vector<ModelChoice> choices = choose_models(world, error);
  withdraw_refused(built, start.gravity, choices);
  return choices;
}

struct Wanted {
  const SceneLimits& limits;
  const SolverChoices& choices;
  Start start = Start::in_contact;
};

Result<Scene> parse_whole(std::string_view text, std::string_view name, const Wanted& wanted) {
  const auto& [limits, choices, start] = wanted;
  if (text.size() > limits.bytes) return Error{too_long(name, limits.bytes, "a scene file")};
  SceneFiles files(limits);
  if (!files.open(name, text).is_json()) return files.errors();

  JsonPlaces places(files);
  Recipe recipe = read_recipe(files, places, limits);
  BuiltScene built = build_scene(recipe, places, limits, start);
  if (files.any_errors()) return files.errors();
  Scene scene = std::move(recipe.scene);
  Solver& solver = scene.world.default_settings.solver;
  const bool chooses = recipe.error > 0 && !choices.solver;
  SolverSettings planar = scene.world.default_settings;
  planar.solver = Solver::planar;
  if (chooses && solver != Solver::articulated)
    places.error({}, "error",
                 "found \"error\" with the solver \"" + std::string(name_of(solver)) +
                     "\", expected it with \"auto\", which chooses the cheapest model");
  else if (chooses)
    solver = give_models(models_of(built, scene.world, recipe.error), planar, built);
  std::vector<Solver> solvers = solvers_of(built, solver);
  if (choices.solver) solvers.assign(solvers.size(), *choices.solver);
  check_solvers(built, solvers, places);
  check_planes(built, solvers, scene.world.gravity, places);
  check_laminas(built, solvers, places);
  check_events(built, solvers, places);
  if (files.any_errors()) return files.errors();
  warn_of_structure(built, solvers, places);
  warn_of_contacts(built, scene.world.gravity, places);
  warn_of_events(built, scene.duration, places);
  build_world(built, scene.world, &scene.sensors);
  if (scene.laminas) add_laminas(*scene.laminas, scene.world);
  if (recipe.plane && !choices.solver) choose_plane(scene.world, places);
  choices.apply(scene.world.default_settings);
  for (SolverSettings& s : scene.world.settings.values()) choices.apply(s);
  if (scene.drift_bound == 0) scene.drift_bound = promised_gap(scene.world);
  if (scene.title.empty()) scene.title = std::filesystem::path(name).stem().string();
  scene.warnings = files.warnings();
  return scene;
}

}  // namespace

Result<Scene> parse_scene(std::string_view text, std::string_view name, const SceneLimits& limits,
                          const SolverChoices& choices) {
  try {
    return parse_whole(text, name, {limits, choices});
  } catch (const Cancelled&) {
    return Error{printable(name) + ": reading was cancelled"};
  }
}

Result<Scene> load_scene(const std::string& path, const SceneLimits& limits,
                         const SolverChoices& choices) {
  const Result<std::string> text = read_text(path, limits.bytes, "a scene file");
  if (!text) return text.errors();
  return parse_scene(*text, path, limits, choices);
}

namespace detail {

Result<Scene> load_scene_in_parts(const std::string& path, const SolverChoices& solver) {
  const SceneLimits limits;
  const Result<std::string> text = read_text(path, limits.bytes, "a scene file");
  if (!text) return text.errors();
  return parse_whole(*text, path, {limits, solver, Start::anywhere});
}

namespace {

/// The element that a joint is built from.
std::optional<ElementId> element_of(const BuiltScene& built, std::string_view joint) {
  std::optional<ElementId> at;
  const auto look_in = [&](const auto& list) {
    for (const auto& one : list)
      if (!at && one.name == joint) at = one.at;
  };
  look_in(built.joints), look_in(built.surface_joints), look_in(built.cables);
  look_in(built.gears), look_in(built.pins);
  return at;
}

}  // namespace

std::vector<std::string> lines_of_models(const std::string& path) {
  const SceneLimits limits;
  const Result<std::string> text = read_text(path, limits.bytes, "a scene file");
  SceneFiles files(limits);
  if (!text || !files.open(path, *text).is_json()) return {};
  JsonPlaces places(files);
  const Recipe recipe = read_recipe(files, places, limits);
  const BuiltScene built = build_scene(recipe, places, limits);
  if (files.any_errors() || !(recipe.error > 0) || recipe.plane) return {};
  struct Line {
    std::string name;
    std::size_t bodies = 0, groups = 0;
  };
  std::map<std::pair<std::string, std::string>, Line> lines;  // by solver and reason
  for (const ModelChoice& c : models_of(built, recipe.scene.world, recipe.error)) {
    Line& line = lines[{name_of(c.solver), c.why}];
    if (line.groups == 0) line.name = built.bodies[c.slots.front()].name;
    line.bodies += c.slots.size(), ++line.groups;
  }
  std::vector<std::string> all;
  for (const auto& [key, line] : lines)
    all.push_back("model \"" + key.first + "\" for " + std::to_string(line.bodies) +
                  (line.bodies == 1 ? " body" : " bodies") + " in " + std::to_string(line.groups) +
                  (line.groups == 1 ? " group" : " groups") + ", with \"" + line.name +
                  "\": " + key.second);
  return all;
}

Error error_of_joint(const std::string& path, std::string_view joint, const std::string& message) {
  const SceneLimits limits;
  const Result<std::string> text = read_text(path, limits.bytes, "a scene file");
  SceneFiles files(limits);
  if (!text || !files.open(path, *text).is_json()) return {path + ": " + message};
  JsonPlaces places(files);
  const Recipe recipe = read_recipe(files, places, limits);
  const BuiltScene built = build_scene(recipe, places, limits, Start::anywhere);
  const auto at = element_of(built, joint);
  if (!at || files.any_errors()) return {path + ": " + message};
  places.error(*at, "", message);
  return files.errors().front();
}

namespace {

/// Its law in the World, and its element in the file.
void place_free(const BuiltScene& built, const World& world, const BuiltFree& found,
                SceneFree& to) {
  const auto place = [&](const auto& list, const auto& store, const char* key) {
    const ElementId at = list[found.law].at;
    if (at.kind == found.kind && at.group == 0) to.element = at.index;
    to.list = key, to.variable.law = store.owners()[found.law];
  };
  if (found.kind == ElementKind::joint) place(built.joints, world.links, "joints");
  if (found.kind == ElementKind::string) place(built.cables, world.cables, "cables");
  if (found.kind == ElementKind::ratio) place(built.gears, world.gears, "gears");
  if (found.kind == ElementKind::belt) place(built.belts, world.belts, "belts");
  if (found.kind != ElementKind::surface_joint) return;
  place(built.surface_joints, world.surface_contacts, "surface_joints");
  to.list = found.net->surface ? "surfaces" : "curves", to.element = found.net->element;
}

}  // namespace

Result<std::vector<SceneFree>> free_numbers(const std::string& file, const World& world,
                                            const FurtherFree& further) {
  const SceneLimits limits;
  const Result<std::string> text = read_text(file, limits.bytes, "a scene file");
  if (!text) return text.errors();
  SceneFiles files(limits);
  if (!files.open(file, *text).is_json()) return files.errors();
  JsonPlaces places(files);
  const Recipe recipe = read_recipe(files, places, limits);
  const BuiltScene built = build_scene(recipe, places, limits, Start::anywhere);
  if (files.any_errors()) return files.errors();
  if (built.joints.size() > world.links.size() || built.cables.size() > world.cables.size() ||
      built.gears.size() > world.gears.size() || built.belts.size() > world.belts.size() ||
      built.surface_joints.size() > world.surface_contacts.size())
    return Error{file + ": the file has changed since it was read"};
  std::vector<SceneFree> all;
  const auto add = [&](const FreeRecipe& from, std::string& fault) {
    const auto found = find_free({built, recipe.nets}, from, fault);
    if (!found) return;
    SceneFree one{from.of, found->variable, {}, {}, found->images};
    place_free(built, world, *found, one);
    const bool is_new = std::none_of(all.begin(), all.end(), [&](const SceneFree& other) {
      return other.variable.is_same(one.variable);
    });
    if (is_new) all.push_back(std::move(one));
  };
  std::string fault;
  for (const FreeRecipe& from : recipe.top.free) add(from, fault);
  for (const std::string& path : further.paths) {
    add({path, {}, {}}, fault);
    if (!fault.empty()) return Error{further.option + ": " + fault};
  }
  return all;
}

}  // namespace detail
}  // namespace pantin
