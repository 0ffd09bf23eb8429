#include <algorithm>
#include <string>
#include <unordered_map>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

/// A group that is being read.
struct OpenGroup {
  const Reading& reading;
  std::uint32_t number;  // as in ElementId
  Group& group;

  void note(ElementKind kind, NodeId node) const { reading.places.add(number, kind, node); }

  /// Reads each item of an array; those that cannot be read are left out.
  template <class T, class Read>
  void read_all(const std::vector<NodeId>& nodes, ElementKind kind, Read read,
                std::vector<T>& into) const {
    into.reserve(nodes.size());
    for (NodeId node : nodes)
      if (auto item = read(reading, node)) {
        into.push_back(std::move(*item));
        note(kind, node);
      }
  }
};

void read_generators(const OpenGroup& open, const Reader& outer) {
  const NodeId node = outer.find("generators");
  if (node == kNoNode) return;
  const Reader from = open.reading.open(node, "generators");
  Group& group = open.group;
  open.read_all(from.items("grids"), ElementKind::grid, read_grid, group.grids);
  for (NodeId item : from.items("chains")) {
    ChainRecipe chain = read_chain(open.reading, item);
    if (chain.links > 0) {
      group.chains.push_back(std::move(chain));
      open.note(ElementKind::chain, item);
    } else {
      group.broken.push_back(chain.name);
    }
  }
  for (NodeId item : from.items("stairs")) {
    BodyRecipe stairs = read_stairs(open.reading, item);
    if (stairs.name.empty()) continue;
    group.bodies.push_back(std::move(stairs));
    open.note(ElementKind::body, item);
  }
}

/// Complains of a name that another element has, found at `named`.
void refuse_repeated(const Reading& reading, NodeId named, const std::string& name, NodeId first) {
  reading.diagnostics.error(reading.json.member(named, "name"),
                            "found the name \"" + name + "\" again, expected one that " +
                                reading.json.pointer(first) + " does not have");
}

/// Complains of names given twice; one name space for all that a group contains.
void check_names(const OpenGroup& open) {
  std::unordered_map<std::string_view, NodeId> known;
  const auto see = [&](const auto& items, ElementKind kind, const auto& name_of) {
    for (std::uint32_t i = 0; i < items.size(); ++i) {
      const std::string& name = name_of(items[i]);
      if (name.empty()) continue;
      const NodeId at = open.reading.places.node({kind, open.number, i});
      const auto [first, is_new] = known.try_emplace(name, at);
      if (!is_new) refuse_repeated(open.reading, at, name, first->second);
    }
  };
  const auto own = [](const auto& x) -> const std::string& { return x.name; };
  const Group& group = open.group;
  see(group.bodies, ElementKind::body, own);
  see(group.instances, ElementKind::instance, own);
  see(group.grids, ElementKind::grid,
      [](const GridRecipe& g) -> const std::string& { return g.each.name; });
  see(group.chains, ElementKind::chain, own);
  see(group.joints, ElementKind::joint, own);
  see(group.gears, ElementKind::ratio, own);
  see(group.cables, ElementKind::string, own);
  see(group.pins, ElementKind::pin, own);
}

void read_group(const OpenGroup& open, const Reader& from) {
  Group& group = open.group;
  open.note(ElementKind::group, from.node);
  for (NodeId node : from.items("bodies")) {
    BodyRecipe body = read_body(open.reading, node);
    if (body.name.empty()) continue;
    group.bodies.push_back(std::move(body));
    open.note(ElementKind::body, node);
  }
  open.read_all(from.items("joints"), ElementKind::joint, read_joint, group.joints);
  open.read_all(from.items("gears"), ElementKind::ratio, read_gear, group.gears);
  open.read_all(from.items("cables"), ElementKind::string, read_cable, group.cables);
  open.read_all(from.items("pins"), ElementKind::pin, read_pin, group.pins);
  open.read_all(from.items("paths"), ElementKind::drive, read_path, group.paths);
  open.read_all(from.items("instances"), ElementKind::instance, read_instance, group.instances);
  read_generators(open, from);
  check_names(open);
}

void read_prefabs(const Reading& reading, const Reader& from, std::vector<Group>& prefabs) {
  std::unordered_map<std::string, NodeId> known;
  for (NodeId node : from.items("prefabs")) {
    const Reader item = reading.open(node, "prefab");
    if (!item.is_object()) continue;
    Group& prefab = prefabs.emplace_back();
    prefab.name = item.name();
    read_group({reading, static_cast<std::uint32_t>(prefabs.size()), prefab}, item);
    const auto [first, is_new] = known.try_emplace(prefab.name, node);
    if (!is_new && !prefab.name.empty()) refuse_repeated(reading, node, prefab.name, first->second);
  }
}

void read_materials(Reading& reading, const Reader& from) {
  reading.materials.assign(1, Material{});
  std::vector<NodeId> nodes{kNoNode};  // by number of the material
  for (NodeId node : from.items("materials")) {
    const Reader item = reading.open(node, "material");
    if (!item.is_object()) continue;
    Material material;
    material.name = item.name();
    material.colour = item.colour("colour", material.colour);
    material.roughness = item.number("roughness");
    material.metallic = item.number("metallic");
    if (!material.name.empty()) {
      const std::string_view name = reading.json[item.find("name")].text;
      const auto number = static_cast<std::uint32_t>(reading.materials.size());
      const auto [first, is_new] = reading.material_of.try_emplace(name, number);
      if (!is_new) refuse_repeated(reading, node, material.name, nodes[first->second]);
    }
    reading.materials.push_back(std::move(material));
    nodes.push_back(node);
  }
}

void read_camera(const Reading& reading, const Reader& outer, Camera& camera) {
  const NodeId node = outer.find("camera");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "camera");
  camera.eye = from.vec("eye", camera.eye);
  camera.target = from.vec("target", camera.target);
  if (camera.eye == camera.target)
    reading.diagnostics.error(node, "found the eye at the target, expected two different places");
  if (from.has("field_of_view_deg"))
    camera.field_of_view = from.number("field_of_view_deg", 40) * (kPi / 180);
  // A view with both ends given is kept as it is.
  camera.automatic = from.flag("automatic", !(from.has("eye") && from.has("target")));
}

void read_light(const Reading& reading, const Reader& outer, Light& light) {
  const NodeId node = outer.find("light");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "light");
  light.direction = from.direction("direction", light.direction);
  light.colour = from.colour("colour", light.colour);
  light.strength = from.number("strength");
  light.sky = from.colour("sky", light.sky);
  light.ground = from.colour("ground", light.ground);
}

void read_ground(const Reading& reading, const Reader& outer, View& view) {
  const NodeId node = outer.find("ground");
  if (node == kNoNode) return;
  if (reading.json[node].kind == JsonKind::boolean) {
    view.ground = reading.json[node].boolean;
    return;
  }
  const Reader from = reading.open(node, "ground");
  view.ground = from.flag("visible");
  view.ground_height = from.number("height");
}

void read_output(const Reading& reading, const Reader& outer, OutputDefaults& output) {
  const NodeId node = outer.find("output");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "output");
  Real size[2];
  if (from.numbers("size", size)) {
    output.width = static_cast<int>(size[0]), output.height = static_cast<int>(size[1]);
    if (output.width != size[0] || output.height != size[1])
      reading.diagnostics.error_value(from.find("size"), "whole numbers of pixels");
  }
  output.fps = from.number("fps");
}

void read_head(const Reader& from, Scene& scene) {
  from.number("version");
  from.text("$schema", "");
  scene.title = from.text("title", scene.title);
  scene.world.gravity = from.vec("gravity");
  scene.step = from.number("step");
  scene.substeps = from.whole("substeps");
  scene.duration = from.number("duration");
  scene.drift_bound = from.number("drift_bound");
}

}  // namespace

Recipe read_recipe(const JsonDocument& json, JsonPlaces& places, const ReadContext& context) {
  Recipe recipe;
  Poll poll(context.limits.is_cancelled);
  SurfaceFiles surfaces;
  Reading reading{json, places.diagnostics(), places, context.limits, poll, surfaces};
  reading.folder = context.folder;
  const Reader from = reading.open(0, "scene");
  if (!from.is_object()) return recipe;
  Scene& scene = recipe.scene;
  read_head(from, scene);
  read_materials(reading, from);
  if (const auto solver = read_solver(reading, from, reading.solver)) reading.solver = *solver;
  read_scene_collision(reading, from);
  scene.world.materials = reading.materials;
  scene.world.material_pairs = read_material_pairs(reading, from);
  scene.world.default_settings = reading.solver;
  read_camera(reading, from, scene.view.camera);
  read_light(reading, from, scene.view.light);
  read_ground(reading, from, scene.view);
  read_output(reading, from, scene.output);
  read_prefabs(reading, from, recipe.prefabs);
  const OpenGroup top{reading, 0, recipe.top};
  read_group(top, from);
  top.read_all(from.items("events"), ElementKind::event, read_event, recipe.top.events);
  for (const auto& [key, surface] : surfaces)  // one file may be a hull and a mesh
    if (std::find(scene.files.begin(), scene.files.end(), key.second) == scene.files.end())
      scene.files.push_back(key.second);
  return recipe;
}

}  // namespace pantin::detail
