#include <algorithm>
#include <filesystem>

#include "engine/scene/assembly.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/text_file.hpp"

namespace pantin {

void build_world(const Assembly& assembly, World& world) {
  std::vector<Entity> entities;
  entities.reserve(assembly.bodies.size());
  for (const PlacedBody& b : assembly.bodies) {
    const Entity e = world.add_body(b.body, b.name);
    entities.push_back(e);
    if (b.matter->is_moved) world.origins.add(e, inverse(b.matter->centre));
    if (!b.matter->shapes.empty()) {
      Shapes& shapes = world.shapes.add(e, {b.matter->shapes});
      if (b.material != UINT32_MAX)
        for (Shape& s : shapes.parts) s.material = b.material;
    }
    if (b.solver) world.settings.add(e, *b.solver);
    if (b.collision) world.collisions.add(e, *b.collision);
  }
  Entity ground;  // one body for all that is tied to the world
  const auto entity = [&](std::uint32_t body) {
    if (body != kWorldBody) return entities[body];
    if (ground) return ground;
    Body fixed;
    fixed.motion = Motion::fixed;
    return ground = world.add_body(fixed, "world");
  };
  std::vector<Entity> links;
  links.reserve(assembly.joints.size());
  for (const PlacedJoint& j : assembly.joints) {
    const Entity a = entity(j.a), b = entity(j.b);
    links.push_back(world.add_link(a, b, j.joint, j.name));
    if (j.drive) world.pose_drives.add(links.back(), *j.drive);
  }
  for (const PlacedRatio& r : assembly.ratios) {
    Ratio ratio = r.ratio;
    ratio.first = links[r.first], ratio.second = links[r.second];
    world.add_ratio(ratio, r.name);
  }
  for (const PlacedString& s : assembly.strings) {
    const Entity a = entity(s.a), b = entity(s.b);
    world.add_string(a, b, s.joint, s.name);
  }
  for (const PlacedPin& p : assembly.pins) {
    Pin pin = p.pin;
    pin.body = entities[p.body];
    if (p.to != kWorldBody) pin.to = entities[p.to];
    world.add_pin(pin, p.name);
  }
  for (const PlacedDrive& d : assembly.drives) world.drives.add(entities[d.body], d.drive);
}

void SolverChoices::apply(SolverSettings& settings) const {
  settings.solver = solver.value_or(settings.solver);
  settings.integrator = integrator.value_or(settings.integrator);
  settings.stabilisation = stabilisation.value_or(settings.stabilisation);
  settings.step_tolerance = step_tolerance.value_or(settings.step_tolerance);
  if (!info_of(settings.integrator).takes_tolerance) settings.step_tolerance = 0;
}

Result<Scene> parse_scene(std::string_view text, std::string_view name, const SceneLimits& limits,
                          const SolverChoices& choices) {
  if (text.size() > limits.bytes) return Error{too_long(name, limits.bytes, "a scene file")};
  const JsonDocument json = parse_json(text, {limits.values, limits.depth});
  Complaints complaints(json, std::string(name));
  const bool is_json = std::none_of(json.faults.begin(), json.faults.end(),
                                    [](const JsonFault& f) { return f.node == kNoNode; });
  if (!is_json) return complaints.errors();

  Recipe recipe = read_recipe(json, complaints, limits,
                              std::filesystem::path(name).parent_path().string());
  const Assembly assembly = assemble(recipe, json, complaints, limits);
  if (complaints.any_errors()) return complaints.errors();
  Scene scene = std::move(recipe.scene);
  std::vector<Solver> solvers = solvers_of(assembly, scene.world.default_settings.solver);
  if (choices.solver) solvers.assign(solvers.size(), *choices.solver);
  refuse_unsolved(assembly, solvers, json, complaints);
  if (complaints.any_errors()) return complaints.errors();
  warn_of_structure(assembly, solvers, complaints);
  build_world(assembly, scene.world);
  choices.apply(scene.world.default_settings);
  for (SolverSettings& s : scene.world.settings.values()) choices.apply(s);
  if (scene.title.empty()) scene.title = std::filesystem::path(name).stem().string();
  scene.warnings = complaints.warnings();
  return scene;
}

Result<Scene> load_scene(const std::string& path, const SceneLimits& limits,
                         const SolverChoices& choices) {
  const Result<std::string> text = read_text(path, limits.bytes, "a scene file");
  if (!text) return text.errors();
  return parse_scene(*text, path, limits, choices);
}

}  // namespace pantin
