#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <unordered_map>

#include "engine/scene/read/lamina_bodies.hpp"
#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

/// A group that is being read.
struct OpenGroup {
  const Reading& reading;
  std::uint32_t number;  // as in ElementId
  Group& group;

  void note(ElementKind kind, NodeId node) const { reading.places.add(number, kind, node); }

  /// Reads each item of an array; invalid items are left out.
  template <class T>
  void read_all(const Reader& from, std::string_view key, ElementKind kind,
                std::vector<T>& into) const {
    const std::vector<NodeId> nodes = from.items(key);
    into.reserve(nodes.size());
    for (NodeId node : nodes)
      if (auto item = read_object<T>(reading, node, from.row(key).object)) {
        into.push_back(std::move(*item));
        note(kind, node);
      }
  }
};

/// Reads "free": paths, or objects with bounds.
void read_free(const OpenGroup& open, const Reader& from) {
  const Reading& reading = open.reading;
  for (const NodeId node : from.items("free")) {
    std::optional<FreeRecipe> item;
    if (reading.json[node].kind == JsonKind::string)
      item = FreeRecipe{std::string(reading.json[node].text), {}, {}};
    else if (reading.json[node].kind == JsonKind::object)
      item = read_object<FreeRecipe>(reading, node, from.row("free").object);
    else
      reading.diagnostics.error_value(node, "a path such as \"joints/3/length\", or an object");
    if (!item) continue;
    item->length_unit = reading.length_unit;
    open.group.free.push_back(std::move(*item));
    open.note(ElementKind::free, node);
  }
}

void read_generators(const OpenGroup& open, const Reader& outer) {
  const NodeId node = outer.find("generators");
  if (node == kNoNode) return;
  const Reader from = open.reading.open(node, "generators");
  Group& group = open.group;
  open.read_all(from, "grids", ElementKind::grid, group.grids);
  open.read_all(from, "rings", ElementKind::grid, group.grids);
  open.read_all(from, "mirrors", ElementKind::mirror, group.mirrors);
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

/// Reports a name, at `named`, that another element has already.
void refuse_repeated(const Reading& reading, NodeId named, const std::string& name, NodeId first) {
  reading.diagnostics.error(reading.json.member(named, "name"),
                            "found the name \"" + name + "\" again, expected one that " +
                                reading.json.pointer(first) + " does not have");
}

/// Reports repeated names; a group has one name space.
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
  see(group.belts, ElementKind::belt, own);
  see(group.surface_joints, ElementKind::surface_joint, own);
  see(group.cables, ElementKind::string, own);
  see(group.pins, ElementKind::pin, own);
  see(group.sensors, ElementKind::sensor, own);
}

/// The kinds that act on a particular entity: "push, impulse ... or winch".
std::string own_events() {
  std::vector<std::string_view> names;
  const auto add = [&]<class... Kinds>(const std::variant<Kinds...>*) {
    ((kHasTarget<Kinds> ? names.push_back(Kinds::name) : void()), ...);
  };
  add(static_cast<const EventKinds*>(nullptr));
  std::string all(names.front());
  for (std::size_t i = 1; i < names.size(); ++i)
    all += (i + 1 < names.size() ? ", " : " or ") + std::string(names[i]);
  return all;
}

/// An event that acts on the prefab's own entities. Other events, of a file that is also a scene,
/// are ignored.
std::optional<EventRecipe> read_event_of_prefab(const Reading& reading, NodeId node) {
  std::optional<EventRecipe> event = read_event(reading, node);
  if (!event) return std::nullopt;
  if (!event->member.empty()) return event;
  const std::string name(name_of(event->event));
  const bool is_of_file = reading.json[reading.json[node].parent].parent == 0;
  if (is_of_file)
    reading.diagnostics.warn(
        node, "event of a scene",
        "the event \"" + name + "\" applies to the whole scene; in a prefab it is ignored");
  else
    reading.diagnostics.error_value(reading.json.member(node, "type"),
                                    "an event on objects of the prefab: " + own_events());
  return std::nullopt;
}

/// Adds laminas and their fingers as bodies of the scene.
void add_bodies_of_laminas(const OpenGroup& open) {
  const Reading& reading = open.reading;
  const Scene& scene = reading.scene.recipe.scene;
  for (std::size_t i = 0; scene.laminas && i < scene.laminas->size(); ++i) {
    const std::size_t before = open.group.bodies.size();
    const NodeId node = reading.scene.lamina_nodes[i];
    if (!is_body((*scene.laminas)[i])) {
      reading.diagnostics.warn(
          node, "lamina without a body",
          "lamina \"" + (*scene.laminas)[i].name +
              "\" has no outline or no mass: only `pantin modes` uses it, it does not move");
      continue;
    }
    add_lamina_bodies((*scene.laminas)[i], reading.solver, {open.group.bodies, reading.materials});
    for (std::size_t k = before; k < open.group.bodies.size(); ++k)
      open.note(ElementKind::body, node);
  }
}

void read_group(const OpenGroup& open, const Reader& from) {
  Group& group = open.group;
  group.scope = open.reading.scope;
  open.reading.places.open_group(open.number, open.reading.file);
  open.note(ElementKind::group, from.node);
  open.read_all(from, "bodies", ElementKind::body, group.bodies);
  open.read_all(from, "joints", ElementKind::joint, group.joints);
  open.read_all(from, "gears", ElementKind::ratio, group.gears);
  open.read_all(from, "belts", ElementKind::belt, group.belts);
  open.read_all(from, "surface_joints", ElementKind::surface_joint, group.surface_joints);
  open.read_all(from, "cables", ElementKind::string, group.cables);
  open.read_all(from, "pins", ElementKind::pin, group.pins);
  open.read_all(from, "paths", ElementKind::drive, group.paths);
  open.read_all(from, "instances", ElementKind::instance, group.instances);
  if (open.number == 0) open.read_all(from, "poses", ElementKind::pose, group.poses);
  if (open.number == 0) open.read_all(from, "sensors", ElementKind::sensor, group.sensors);
  if (open.number == 0) read_free(open, from);
  for (NodeId node : from.items("events"))
    if (auto event = open.number == 0 ? read_event(open.reading, node)
                                      : read_event_of_prefab(open.reading, node)) {
      group.events.push_back(std::move(*event));
      open.note(ElementKind::event, node);
    }
  read_generators(open, from);
  if (open.number == 0) add_bodies_of_laminas(open);
  check_names(open);
}

std::optional<std::uint32_t> read_prefab(const Reading& reading, const Reader& item,
                                         const std::string& name) {
  std::vector<Group>& prefabs = reading.scene.recipe.prefabs;
  prefabs.emplace_back().name = name;
  const auto number = static_cast<std::uint32_t>(prefabs.size());
  read_group({reading, number, prefabs.back()}, item);
  return number - 1;
}

std::string full_path(const std::string& path) {
  std::error_code trouble;
  const std::filesystem::path full = std::filesystem::weakly_canonical(path, trouble);
  return trouble ? path : full.string();
}

/// Whether a file may be opened now; reports an error at the value that names it if not.
bool may_open(const Reading& reading, NodeId at, const std::string& full) {
  const std::vector<std::string>& open = reading.scene.open_files;
  if (open.size() >= reading.limits.depth) {
    reading.diagnostics.error_value(
        at, "files nested at most " + std::to_string(reading.limits.depth) + " deep");
    return false;
  }
  const auto same = std::find(open.begin(), open.end(), full);
  if (same == open.end()) return true;
  std::string way;
  for (auto it = same; it != open.end(); ++it)
    way += std::filesystem::path(*it).filename().string() + " -> ";
  reading.diagnostics.error_value(at, "a file that does not include itself (" + way +
                                          std::filesystem::path(full).filename().string() + ")");
  return false;
}

/// A prefab that is a scene file of its own; read once, however many prefabs name it.
std::optional<std::uint32_t> read_prefab_file(const Reading& reading, const Reader& item) {
  const auto file = item.reference("file");
  if (!file) return std::nullopt;
  SceneReading& scene = reading.scene;
  const NodeId at = item.find("file");
  const std::string path = (std::filesystem::path(reading.folder) / *file).string(),
                    full = full_path(path);
  if (const auto known = scene.prefab_of.find(full); known != scene.prefab_of.end())
    return known->second;
  if (!may_open(reading, at, full)) return std::nullopt;
  SceneFile* opened = scene.files.open(path, reading.file, at);
  if (!opened || !opened->is_json()) return std::nullopt;
  Reading inner = reading_of(scene, *opened);
  inner.solver = reading.solver;
  const Reader from = inner.open(0, "scene");
  if (!from.is_object()) return std::nullopt;
  from.word("units");
  scene.open_files.push_back(full);
  std::vector<Group>& prefabs = scene.recipe.prefabs;
  prefabs.emplace_back().name = item.name();
  const auto number = static_cast<std::uint32_t>(prefabs.size());
  if (from.has("laminas"))
    inner.diagnostics.warn(from.find("laminas"), "laminas of a scene",
                           "laminas belong to the whole scene; in a prefab they are ignored");
  read_content(inner, from, number);
  scene.open_files.pop_back();
  scene.prefab_of.emplace(full, number - 1);
  return number - 1;
}

void read_materials(Reading& reading, const Reader& from) {
  if (reading.materials.empty()) reading.materials.emplace_back();
  reading.first_material = reading.materials.size();
  std::vector<NodeId> nodes;  // of the laminas of this file
  for (NodeId node : from.items("materials")) {
    const Reader item = reading.open(node, "material");
    if (!item.is_object()) continue;
    Material material;
    read_rows(reading, item, material);
    if (!material.name.empty()) {
      const std::string_view name = reading.json[item.find("name")].text;
      const auto number = static_cast<std::uint32_t>(reading.materials.size());
      const auto [first, is_new] = reading.material_of.try_emplace(name, number);
      if (!is_new)
        refuse_repeated(reading, node, material.name,
                        nodes[first->second - reading.first_material]);
    }
    reading.materials.push_back(std::move(material));
    nodes.push_back(node);
  }
}

void read_laminas(const Reading& reading, const Reader& from, Scene& scene) {
  std::unordered_map<std::string, NodeId> known;
  std::vector<LaminaPlan> all;
  for (const NodeId node : from.items("laminas")) {
    auto lamina = read_lamina(reading, node, scene.world.gravity);
    if (!lamina) continue;
    const auto [first, is_new] = known.try_emplace(lamina->name, node);
    if (!is_new) {
      refuse_repeated(reading, node, lamina->name, first->second);
      continue;
    }
    all.push_back(std::move(*lamina));
    reading.scene.lamina_nodes.push_back(node);
  }
  if (!all.empty()) scene.laminas = std::make_shared<const std::vector<LaminaPlan>>(std::move(all));
}

/// Whether a surface, face or curve is in the scene as its numbers give it.
bool is_as_given(const JsonDocument& json, NodeId node) {
  for (const char* key : {"file", "scale", "position", "rotation", "rotation_deg", "inside_out"})
    if (json.member(node, key) != kNoNode) return false;
  return true;
}

/// Whether it is one of NURBS by their control points.
bool is_by_points(const JsonDocument& json, NodeId node) {
  const NodeId type = json[node].kind == JsonKind::object ? json.member(node, "type") : kNoNode;
  return type != kNoNode && json[type].text == "nurbs" && is_as_given(json, node);
}

/// Lists the named surfaces and curves of the scene itself.
void note_nets(const Reading& reading, const Reader& from, std::vector<NetRecipe>& nets) {
  const JsonDocument& json = reading.json;
  const auto list = [&](const char* key, const auto& known, const auto& note) {
    std::uint32_t element = 0;
    for (const NodeId node : from.items(key)) {
      NetRecipe net{key, element++, {}, {}, {}};
      const NodeId name = json[node].kind == JsonKind::object ? json.member(node, "name") : kNoNode;
      const auto found = name == kNoNode ? known.end() : known.find(json[name].text);
      if (found == known.end() || !found->second) continue;
      net.path.append("/").append(json[name].text);
      note(net, node, found->second);
      nets.push_back(std::move(net));
    }
  };
  list("surfaces", reading.surface_of, [&](NetRecipe& net, NodeId node, const auto& surface) {
    net.surface = surface;
    const NodeId faces = json.member(node, "faces");
    if (faces == kNoNode || json[faces].kind != JsonKind::array) return;
    for (NodeId face = json[faces].first_child; face != kNoNode; face = json[face].next)
      net.is_plain.push_back(is_as_given(json, node) && is_by_points(json, face));
  });
  list("curves", reading.curve_of, [&](NetRecipe& net, NodeId node, const auto& curve) {
    net.curve = curve, net.is_plain = {is_by_points(json, node)};
  });
}

void read_head(const Reading& reading, const Reader& from, Recipe& recipe) {
  from.number("version");
  from.word("units");
  from.text("$schema", "");
  Scene& scene = recipe.scene;
  scene.drift_bound = 0;  // by default what the solvers achieve, see parse_whole()
  read_rows(reading, from, scene), read_rows(reading, from, scene.view);
  read_rows(reading, from, recipe);
}

}  // namespace

void read_prefabs(const Reading& reading, const Reader& from) {
  Recipe& recipe = reading.scene.recipe;
  std::unordered_map<std::string, NodeId> known;
  for (NodeId node : from.items("prefabs")) {
    const Reader item = reading.open(node, "prefab");
    if (!item.is_object()) continue;
    const std::string name = item.name();
    const auto number =
        item.has("file") ? read_prefab_file(reading, item) : read_prefab(reading, item, name);
    recipe.prefab_names.push_back({reading.scope, name, number.value_or(kNoPrefab)});
    const auto [first, is_new] = known.try_emplace(name, node);
    if (!is_new && !name.empty()) refuse_repeated(reading, node, name, first->second);
  }
}

void read_content(Reading& reading, const Reader& from, std::uint32_t number) {
  read_materials(reading, from);
  read_surfaces(reading, from);
  read_curves(reading, from);
  read_scene_collision(reading, from);
  std::vector<MaterialPair>& pairs = reading.scene.recipe.scene.world.material_pairs;
  for (const MaterialPair& pair : read_material_pairs(reading, from)) pairs.push_back(pair);
  read_classes(reading, from);
  read_prefabs(reading, from);
  Recipe& recipe = reading.scene.recipe;
  if (number == 0) note_nets(reading, from, recipe.nets);
  Group& group = number == 0 ? recipe.top : recipe.prefabs[number - 1];
  read_group({reading, number, group}, from);
}

Reading reading_of(SceneReading& scene, SceneFile& file) {
  Reading reading{scene,
                  file,
                  file.json,
                  file.diagnostics,
                  scene.places,
                  scene.limits,
                  scene.poll,
                  scene.surfaces,
                  scene.recipe.scene.world.materials};
  reading.scope = scene.scopes++;
  reading.length_unit = length_unit_of(file.json);
  convert_to_si(file.json);
  reading.folder = std::filesystem::path(file.name).parent_path().string();
  return reading;
}

Recipe read_recipe(SceneFiles& files, JsonPlaces& places, const SceneLimits& limits) {
  Recipe recipe;
  recipe.scene.world.materials.clear();
  SceneReading whole{recipe, files, places, limits, Poll(limits.is_cancelled)};
  Reading reading = reading_of(whole, files.first());
  const Reader from = reading.open(0, "scene");
  if (!from.is_object()) return recipe;
  whole.open_files.push_back(full_path(files.first().name));
  Scene& scene = recipe.scene;
  read_head(reading, from, recipe);
  if (const NodeId solver = from.find("solver"); solver != kNoNode)
    read_members(reading, reading.open(solver, "solver"), reading.solver);
  scene.world.default_settings = reading.solver;
  read_laminas(reading, from, scene);
  read_content(reading, from, 0);
  scene.files = files.names();
  for (const auto& [file, surface] : whole.surfaces)  // one file may be both a hull and a mesh
    if (const std::string& path = std::get<1>(file);
        std::find(scene.files.begin(), scene.files.end(), path) == scene.files.end())
      scene.files.push_back(path);
  return recipe;
}

}  // namespace pantin::detail
