#include <algorithm>
#include <map>
#include <string>

#include "engine/scene/read.hpp"

namespace pantin {
namespace {

/// Reads each item of an array; those that cannot be read are left out.
template <class T, class Read>
void read_all(const Reading& reading, const Reader& from, std::string_view key, Read read,
              std::vector<T>& into) {
  const std::vector<NodeId> nodes = from.items(key);
  into.reserve(nodes.size());
  for (NodeId node : nodes)
    if (auto item = read(reading, node)) into.push_back(std::move(*item));
}

void read_generators(const Reading& reading, const Reader& outer, Group& group) {
  const NodeId node = outer.find("generators");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "generators");
  read_all(reading, from, "grids", read_grid, group.grids);
  for (NodeId item : from.items("chains")) {
    ChainRecipe chain = read_chain(reading, item);
    if (chain.links > 0)
      group.chains.push_back(std::move(chain));
    else
      group.broken.push_back(chain.name);
  }
  for (NodeId item : from.items("stairs")) {
    BodyRecipe stairs = read_stairs(reading, item);
    if (!stairs.name.empty()) group.bodies.push_back(std::move(stairs));
  }
}

/// Complains of names given twice; one name space for all that a group contains.
void refuse_repeated_names(const Reading& reading, const Group& group) {
  std::map<std::string_view, NodeId> known;
  const auto see = [&](const std::string& name, NodeId at) {
    if (name.empty()) return;
    const auto [first, is_new] = known.try_emplace(name, at);
    if (!is_new)
      reading.complaints.refuse(reading.json.member(at, "name"),
                                "found the name \"" + name + "\" again, expected one that " +
                                    reading.json.pointer(first->second) + " does not have");
  };
  for (const auto& x : group.bodies) see(x.name, x.at);
  for (const auto& x : group.instances) see(x.name, x.at);
  for (const auto& x : group.grids) see(x.each.name, x.each.at);
  for (const auto& x : group.chains) see(x.name, x.at);
  for (const auto& x : group.joints) see(x.name, x.at);
  for (const auto& x : group.ratios) see(x.name, x.at);
  for (const auto& x : group.strings) see(x.name, x.at);
  for (const auto& x : group.pins) see(x.name, x.at);
}

void read_group(const Reading& reading, const Reader& from, Group& group) {
  group.at = from.node;
  for (NodeId node : from.items("bodies")) {
    BodyRecipe body = read_body(reading, node);
    if (!body.name.empty()) group.bodies.push_back(std::move(body));
  }
  read_all(reading, from, "joints", read_joint, group.joints);
  read_all(reading, from, "gears", read_ratio, group.ratios);
  read_all(reading, from, "cables", read_string, group.strings);
  read_all(reading, from, "pins", read_pin, group.pins);
  read_all(reading, from, "paths", read_drive, group.drives);
  read_all(reading, from, "instances", read_instance, group.instances);
  read_generators(reading, from, group);
  refuse_repeated_names(reading, group);
}

void read_prefabs(const Reading& reading, const Reader& from, std::vector<Group>& prefabs) {
  std::map<std::string, NodeId> known;
  for (NodeId node : from.items("prefabs")) {
    const Reader item = reading.open(node, "prefab");
    if (!item.is_object()) continue;
    Group& prefab = prefabs.emplace_back();
    prefab.name = item.name();
    read_group(reading, item, prefab);
    const auto [first, is_new] = known.try_emplace(prefab.name, node);
    if (!is_new && !prefab.name.empty())
      reading.complaints.refuse(item.find("name"),
                                "found the name \"" + prefab.name + "\" again, expected one that " +
                                    reading.json.pointer(first->second) + " does not have");
  }
}

void read_materials(Reading& reading, const Reader& from) {
  reading.materials.assign(1, Material{});
  std::map<std::string, NodeId> known;
  for (NodeId node : from.items("materials")) {
    const Reader item = reading.open(node, "material");
    if (!item.is_object()) continue;
    Material material;
    material.name = item.name();
    material.colour = item.colour("colour", material.colour);
    material.roughness = item.number("roughness", material.roughness, kUnit);
    material.metallic = item.number("metallic", material.metallic, kUnit);
    const auto [first, is_new] = known.try_emplace(material.name, node);
    if (!is_new && !material.name.empty())
      reading.complaints.refuse(
          item.find("name"), "found the name \"" + material.name + "\" again, expected one that " +
                                 reading.json.pointer(first->second) + " does not have");
    reading.materials.push_back(std::move(material));
  }
}

void read_camera(const Reading& reading, const Reader& outer, Camera& camera) {
  const NodeId node = outer.find("camera");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "camera");
  constexpr Range kOpening{1, 170, "an angle from 1 to 170 degrees"};
  camera.eye = from.vec("eye", camera.eye);
  camera.target = from.vec("target", camera.target);
  if (camera.eye == camera.target)
    reading.complaints.refuse(node, "found the eye at the target, expected two different places");
  if (from.has("field_of_view_deg"))
    camera.field_of_view = from.number("field_of_view_deg", 40, kOpening) * (kPi / 180);
  // Whoever places both ends of the view wants that view.
  camera.automatic = from.flag("automatic", !(from.has("eye") && from.has("target")));
}

void read_light(const Reading& reading, const Reader& outer, Light& light) {
  const NodeId node = outer.find("light");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "light");
  constexpr Range kStrength{0, 1000, "a number from 0 to 1000"};
  light.direction = from.direction("direction", light.direction);
  light.colour = from.colour("colour", light.colour, 100);
  light.strength = from.number("strength", light.strength, kStrength);
  light.sky = from.colour("sky", light.sky, 100);
  light.ground = from.colour("ground", light.ground, 100);
}

void read_ground(const Reading& reading, const Reader& outer, View& view) {
  const NodeId node = outer.find("ground");
  if (node == kNoNode) return;
  if (reading.json[node].kind == JsonKind::boolean) {
    view.ground = reading.json[node].boolean;
    return;
  }
  const Reader from = reading.open(node, "ground");
  view.ground = from.flag("visible", true);
  view.ground_height = from.number("height", 0, kAnyNumber);
}

void read_output(const Reading& reading, const Reader& outer, OutputDefaults& output) {
  const NodeId node = outer.find("output");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "output");
  constexpr Range kPixels{16, 16384, "a whole number of pixels from 16 to 16384"};
  constexpr Range kRate{0, 1000, "a number of frames a second above 0, at most 1000", true};
  Real size[2];
  const NodeId at = from.find("size");
  if (at != kNoNode && read_numbers(reading.json, reading.complaints, at, size, kPixels)) {
    output.width = static_cast<int>(size[0]), output.height = static_cast<int>(size[1]);
    if (output.width != size[0] || output.height != size[1])
      reading.complaints.refuse_value(at, "whole numbers of pixels");
  }
  output.fps = from.number("fps", output.fps, kRate);
}

void read_head(const Reader& from, Scene& scene) {
  constexpr Range kVersion{1, 1, "1, the version this program reads"};
  constexpr Range kStep{0, 1, "a step above 0, at most 1 s", true};
  constexpr Range kDuration{0, 1e6, "a duration above 0, at most 1e6 s", true};
  from.need("version", "the version of the format: 1");
  from.number("version", 1, kVersion);
  from.text("$schema", "");
  scene.title = from.text("title", scene.title);
  scene.world.gravity = from.vec("gravity", scene.world.gravity);
  scene.step = from.number("step", scene.step, kStep);
  scene.substeps = from.whole("substeps", scene.substeps, 1, 1000);
  scene.duration = from.number("duration", scene.duration, kDuration);
  scene.drift_bound = from.number("drift_bound", scene.drift_bound, kPositive);
}

}  // namespace

Recipe read_recipe(const JsonDocument& json, Complaints& complaints, const SceneLimits& limits,
                   const std::string& folder) {
  Recipe recipe;
  Reading reading{json, complaints, limits};
  reading.folder = folder;
  const Reader from = reading.open(0, "scene");
  if (!from.is_object()) return recipe;
  Scene& scene = recipe.scene;
  read_head(from, scene);
  read_materials(reading, from);
  if (const auto solver = read_solver(reading, from, reading.solver)) reading.solver = *solver;
  read_scene_collision(reading, from);
  scene.world.materials = reading.materials;
  scene.world.default_settings = reading.solver;
  read_camera(reading, from, scene.view.camera);
  read_light(reading, from, scene.view.light);
  read_ground(reading, from, scene.view);
  read_output(reading, from, scene.output);
  read_prefabs(reading, from, recipe.prefabs);
  read_group(reading, from, recipe.top);
  return recipe;
}

}  // namespace pantin
