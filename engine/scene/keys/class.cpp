// Keys of classes and defaults: inherited values of bodies, joints, cables and pins.
#include <algorithm>
#include <string>

#include "engine/scene/read/named.hpp"

namespace pantin::detail {
namespace {

using namespace rows;

constexpr Key kOfBodies = object("body", "body_class",
                                 "Of bodies, and of the links of chains: shapes, mass, drag, "
                                 "gravity_scale, solver and collision.");
constexpr Key kOfJoints =
    object("joint", "joint_class",
           "Of joints, and of those of chains: kind, limits, drive, spring, friction and motor. "
           "Keys that do not apply to a joint's kind are ignored.");
constexpr Key kOfCables = object("cable", "cable_class", "Of cables.");
constexpr Key kOfPins = object("pin", "pin_class", "Of pins.");
constexpr Key kDefaults[] = {kOfBodies, kOfJoints, kOfCables, kOfPins};
constexpr Key kObjectClass[] = {
    needed_name(),
    reference("class", "the name of a class",
              "Name of a parent class: keys absent here are inherited from it."),
    kOfBodies,
    kOfJoints,
    kOfCables,
    kOfPins,
};

constexpr std::size_t kDeepest = 8;  // classes that inherit from one another

// The keys that joints of a chain inherit; other keys have a different meaning there.
constexpr std::string_view kOfTheirJoints = "kind limits drive spring friction motor";

/// The keys that links of a chain inherit from a class of bodies: those with the same meaning.
const std::string& keys_of_links() {
  static const std::string words = [] {
    std::string all;
    for (const Key& key : keys::body_class.keys)
      if (const Key* same = keys::chain.find(key.name); same && same->about == key.about)
        all.append(key.name).append(" ");
    return all;
  }();
  return words;
}

/// Reads numbers and words of a class, so that their faults are reported even if it is unused.
/// Other values are checked where they are used.
void check_value(const Reading& reading, const Reader& from, const Key& key) {
  const std::string_view name = key.name;
  if (key.type == ValueType::number) from.number(name, 0);
  if (key.type == ValueType::whole) from.whole(name, 0);
  if (key.type == ValueType::word) from.word(name, 0);
  if (key.type == ValueType::vector) from.vec(name, Vec3(0));
  if (key.type == ValueType::direction) from.direction(name, Vec3(1, 0, 0));
  if (key.type == ValueType::object && key.object != "shape")
    reading.open(from.find(name), key.object);
  if (name == "collision") read_collision(reading, from, std::nullopt);
  if (name == "material") read_material(reading, from, 0);
}

/// The value of a key of a class; kNoNode if it has more keys than any valid object.
NodeId read_part(const Reading& reading, const Reader& from, std::string_view key) {
  const NodeId node = from.find(key);
  if (node == kNoNode) return kNoNode;
  const KeySet& set = keys_of(std::string(key) + "_class");
  const Reader part(reading.json, reading.diagnostics, node, set);
  if (!part.is_object() || reading.json[node].count > set.keys.size()) return kNoNode;
  for (const Key& row : set.keys)
    if (part.has(row.name)) check_value(reading, part, row);
  return node;
}

ClassParts read_parts(const Reading& reading, const Reader& from) {
  return {read_part(reading, from, "body"), read_part(reading, from, "joint"),
          read_part(reading, from, "cable"), read_part(reading, from, "pin")};
}

/// The class with the name at a node; null after an error.
const std::vector<ClassParts>* find_class(const Reading& reading, NodeId node) {
  const JsonNode& value = reading.json[node];
  const std::string_view name = value.kind == JsonKind::string ? value.text : "";
  const auto found = reading.classes.find(name);
  if (found != reading.classes.end() && !name.empty()) return &found->second;
  refuse_unknown(reading, node, reading.classes, "the name of a class");
  return nullptr;
}

void read_class(Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "class");
  if (!from.is_object()) return;
  const std::string name = from.name();
  std::vector<ClassParts> line{read_parts(reading, from)};
  if (from.has("class"))
    if (const auto* base = find_class(reading, from.find("class")))
      line.insert(line.end(), base->begin(), base->end());
  if (line.size() > kDeepest)
    from.error_value(
        "class", "a class that inherits from " + std::to_string(kDeepest - 2) + " others at most");
  if (name.empty()) return;
  const std::string_view text = reading.json[from.find("name")].text;
  if (!reading.classes.try_emplace(text, std::move(line)).second)
    from.error("name",
               "found the name \"" + name + "\" again, expected one that no earlier class has");
}

void add_sources(const ClassParts& parts, std::string_view what, ObjectSource& to) {
  const auto add = [&](NodeId part, std::string_view only = {}) {
    if (part != kNoNode) to.sources.push_back({part, only});
  };
  if (what == "body") add(parts.body);
  if (what == "joint") add(parts.joint);
  if (what == "cable") add(parts.cable);
  if (what == "pin") add(parts.pin);
  if (what == "chain") add(parts.body, keys_of_links()), add(parts.joint, kOfTheirJoints);
}

/// The kind of a joint, given by itself or inherited.
JointKind kind_of(const Reading& reading, const ObjectSource& from) {
  NodeId node = reading.json.member(from.node, "kind");
  for (const KeySource& source : from.sources)
    if (node == kNoNode) node = reading.json.member(source.node, "kind");
  JointKind kind = JointKind::ball;
  if (node != kNoNode && reading.json[node].kind == JsonKind::string)
    joint_kind_from_name(reading.json[node].text, kind);
  return kind;
}

/// Excludes inherited keys that a joint of this kind cannot have.
void leave_out(const Reading& reading, const KeySet& set, ObjectSource& from) {
  const JointKindInfo& kind = info_of(kind_of(reading, from));
  for (const Key& key : set.keys)
    if (key.fits && !key.fits(kind)) from.left_out.push_back(key.name);
  if (&set != &keys::joint) return;
  for (const Key& key : keys::joint_parameters())
    if (!keys::parameter_of(kind, key.name)) from.left_out.push_back(key.name);
}

}  // namespace

constinit const KeySet keys::defaults{
    "defaults",
    "Default values: the keys of the object itself take precedence, then its class, then these.",
    kDefaults};
constinit const KeySet keys::object_class{
    "class",
    "A named set of keys. A body takes those under \"body\", a joint those under \"joint\" and so "
    "on; a value is taken whole, also an object.",
    kObjectClass};

void read_classes(Reading& reading, const Reader& scene) {
  if (const NodeId node = scene.find("defaults"); node != kNoNode) {
    const Reader from = reading.open(node, "defaults");
    reading.defaults = read_parts(reading, from);
    const NodeId joint = reading.defaults.joint;
    const NodeId kind = joint == kNoNode ? kNoNode : reading.json.member(joint, "kind");
    if (kind != kNoNode)
      reading.diagnostics.error_at_key(
          kind, "found a \"kind\" for all joints, expected it in a class or a joint");
  }
  for (const NodeId node : scene.items("classes")) read_class(reading, node);
}

Reader open_object(const Reading& reading, NodeId node, std::string_view what) {
  reading.poll();
  const KeySet& set = keys_of(what);
  ObjectSource from(node);
  const bool is_object = reading.json[node].kind == JsonKind::object;
  const NodeId name = is_object && set.find("class") ? reading.json.member(node, "class") : kNoNode;
  const auto* line = name == kNoNode ? nullptr : find_class(reading, name);
  from.is_class_unknown = name != kNoNode && !line;
  if (line)
    for (const ClassParts& parts : *line) add_sources(parts, what, from);
  add_sources(reading.defaults, what, from);
  if (!from.sources.empty() && is_object && (what == "joint" || what == "chain"))
    leave_out(reading, set, from);
  return Reader(reading.json, reading.diagnostics, std::move(from), set);
}

}  // namespace pantin::detail
