// Design variables of `pantin assemble`: their values in the units of scene files, and in the file.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/scene/json/words.hpp"
#include "engine/scene/read/units.hpp"
#include "tools/pantin/assemble.hpp"

namespace pantin::program {
namespace {

/// The body of an end of a joint or cable, and the frame that the scene places it by.
struct End {
  const World& world;
  Entity body;

  Pose origin() const {
    const Pose* found = world.origins.find(body);
    return found ? *found : Pose{};
  }
  Vec3 point(Vec3 anchor) const { return to_local(origin(), anchor); }
  Vec3 direction(Vec3 d) const { return glm::conjugate(origin().rotation) * d; }
};

enum class Side { a, b };
Side side_of(Quantity q) {
  return q == Quantity::anchor_b || q == Quantity::axis_b ? Side::b : Side::a;
}

End end_of(const World& world, const DesignVariable& v, Side side) {
  const bool of_b = side == Side::b;
  if (const Link* link = world.links.find(v.law)) return {world, of_b ? link->b : link->a};
  const Cable& cable = world.cables[v.law];
  return {world, of_b ? cable.b : cable.a};
}

std::string vector_text(Vec3 v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

/// The members of the element that change, and those that would contradict them.
struct Members {
  std::vector<std::pair<std::string, std::string>> set;  // key and value
  std::vector<std::string> removed;
};

/// Anchors are written on both sides, since one that is absent follows from the other. So are axes.
/// `unit` is the file's unit of length, m.
Members members_of(const World& world, const SceneFree& f, Real unit) {
  const DesignVariable& v = f.variable;
  if (v.quantity == Quantity::ratio) {
    const Gear& gear = world.gears[v.law];
    const Real scale = (gear.first_travels ? unit : 1) / (gear.second_travels ? unit : 1);
    return {{{"ratio", fmt::format("{}", scale * value_of(world, v).numbers.x)}}, {}};
  }
  if (world.belts.find(v.law)) return {};
  const End a = end_of(world, v, Side::a), b = end_of(world, v, Side::b);
  const Link* link = world.links.find(v.law);
  const Cable* cable = world.cables.find(v.law);
  Members m;
  const Real length = link ? link->joint.parameters->length : cable->joint.length;
  if (cable || link->joint.kind == JointKind::distance) {
    m.set.emplace_back("length", fmt::format("{}", length / unit));
    m.removed = {"slack"};
  }
  if (v.quantity == Quantity::pitch)
    m.set.emplace_back("pitch", fmt::format("{}", link->joint.parameters->pitch / unit));
  if (v.quantity == Quantity::anchor_a || v.quantity == Quantity::anchor_b) {
    const auto& [at_a, at_b] = link ? std::pair(link->joint.anchor_a, link->joint.anchor_b)
                                    : std::pair(cable->joint.anchor_a, cable->joint.anchor_b);
    m.set.emplace_back("anchor_a", vector_text(a.point(at_a) / unit));
    m.set.emplace_back("anchor_b", vector_text(b.point(at_b) / unit));
    m.removed.insert(m.removed.end(), {"anchor", "point_a", "point_b"});
  }
  if (v.quantity == Quantity::axis_a || v.quantity == Quantity::axis_b) {
    const auto add = [&](const char* side, const End& end, Quat axes) {
      m.set.emplace_back(fmt::format("axis_{}", side),
                         vector_text(end.direction(axes * Vec3(1, 0, 0))));
      m.set.emplace_back(fmt::format("across_{}", side),
                         vector_text(end.direction(axes * Vec3(0, 1, 0))));
    };
    add("a", a, link->joint.frames.a()), add("b", b, link->joint.frames.b());
    m.removed = {"axis", "across", "rest", "rest_deg"};
  }
  return m;
}

/// Where a member stands: in the element itself, or in one of its list: a guide or pulley, a face.
enum class Place { law, part };

/// Item of an array by number.
NodeId item_of(const JsonDocument& json, NodeId array, std::uint32_t number) {
  NodeId at = array == kNoNode ? kNoNode : json[array].first_child;
  for (; at != kNoNode && number > 0; --number) at = json[at].next;
  return at;
}

/// The element of a law, guide, pulley, face or curve in a scene.
NodeId element_of(const JsonDocument& json, const SceneFree& f, Place place) {
  NodeId list = json.member(0, f.list);
  if (list == kNoNode && f.list == "cables") list = json.member(0, "strings");
  if (list == kNoNode && f.list == "gears") list = json.member(0, "ratios");
  const NodeId element = item_of(json, list, *f.element);
  if (place == Place::law || element == kNoNode) return element;
  if (f.list == "surfaces") return item_of(json, json.member(element, "faces"), f.variable.face);
  return item_of(json, json.member(element, f.list == "belts" ? "pulleys" : "over"),
                 f.variable.guide);
}

JsonDocument parsed(std::string_view text) {
  JsonLimits limits;
  limits.style = JsonStyle::json5;
  return parse_json(text, limits);
}

/// Replaces a value of a document in its text.
void set_text(std::string& text, const JsonDocument& json, NodeId node, const std::string& value) {
  const std::size_t from = json[node].offset;
  text.replace(from, end_of_member(json, node) - from, value);
}

void set_member(std::string& text, const SceneFree& f, Place place,
                const std::pair<std::string, std::string>& member) {
  const std::string before = text;
  const JsonDocument json = parsed(before);
  const NodeId element = element_of(json, f, place);
  if (element == kNoNode) return;
  const auto& [key, value] = member;
  if (const NodeId old = json.member(element, key); old != kNoNode)
    return set_text(text, json, old, value);
  NodeId last = json[element].first_child;
  while (json[last].next != kNoNode) last = json[last].next;
  text.insert(end_of_member(json, last), fmt::format(", \"{}\": {}", key, value));
}

/// Replaces one number or point of a list.
void set_item(std::string& text, const SceneFree& f, std::pair<const char*, std::uint32_t> at,
              const std::string& value) {
  const std::string before = text;
  const JsonDocument json = parsed(before);
  const NodeId element = element_of(json, f, f.list == "surfaces" ? Place::part : Place::law);
  if (element == kNoNode) return;
  const NodeId item = item_of(json, json.member(element, at.first), at.second);
  if (item != kNoNode) set_text(text, json, item, value);
}

/// Writes a control point and its weight, in the form that the file has.
void set_control_point(std::string& text, const World& world, const SceneFree& f) {
  const nurbs::Weighted in_metres = control_point_of(world, f.variable);
  const Real unit = length_unit_of(parsed(text));
  const nurbs::Weighted point(in_metres.x / unit, in_metres.y / unit, in_metres.z / unit,
                              in_metres.w);
  const Place place = f.list == "surfaces" ? Place::part : Place::law;
  const std::string before = text;
  const JsonDocument json = parsed(before);
  const NodeId element = element_of(json, f, place);
  if (element == kNoNode) return;
  if (json.member(element, "homogeneous") != kNoNode) {
    for (const std::uint32_t i : f.images)
      for (const auto& [k, number] :
           {std::pair(0u, point.x), {1u, point.y}, {2u, point.z}, {3u, point.w}})
        set_item(text, f, {"homogeneous", 4 * i + k}, fmt::format("{}", number));
    return;
  }
  if (is_point(f.variable.quantity)) {
    for (const std::uint32_t i : f.images)
      set_item(text, f, {"points", i}, vector_text(point.point()));
    return;
  }
  if (json.member(element, "weights") == kNoNode) {
    const std::vector<int> ones(json[json.member(element, "points")].count, 1);
    set_member(text, f, place, {"weights", fmt::format("[{}]", fmt::join(ones, ", "))});
  }
  for (const std::uint32_t i : f.images)
    set_item(text, f, {"weights", i}, fmt::format("{}", point.w));
}

void remove_member(std::string& text, const SceneFree& f, const std::string& key) {
  const std::string before = text;
  const JsonDocument json = parsed(before);
  const NodeId element = element_of(json, f, Place::law);
  const NodeId old = element == kNoNode ? kNoNode : json.member(element, key);
  if (old == kNoNode) return;
  // With the comma behind it, or else that before it, which is behind the member before.
  std::size_t from = json[old].key_offset, to = end_of_member(json, old);
  if (json[old].next != kNoNode) {
    to = json[json[old].next].key_offset;
  } else {
    NodeId last = json[element].first_child;
    while (json[last].next != old && json[last].next != kNoNode) last = json[last].next;
    from = end_of_member(json, last);
  }
  text.erase(from, to - from);
}

std::vector<double> shown_value(const World& world, const DesignVariable& v,
                                const DesignValue& value) {
  if (numbers_of(v.quantity) == 1) return {value.numbers.x};
  if (is_point(v.quantity)) return {value.numbers.x, value.numbers.y, value.numbers.z};
  const End end = end_of(world, v, side_of(v.quantity));
  const bool is_axis = v.quantity == Quantity::axis_a || v.quantity == Quantity::axis_b;
  const Vec3 x = is_axis ? end.direction(value.axes * Vec3(1, 0, 0)) : end.point(value.numbers);
  return {x.x, x.y, x.z};
}

}  // namespace

std::string with_design(std::string_view text, const World& world,
                        const std::vector<SceneFree>& free) {
  std::string written(text);
  const Real unit = length_unit_of(parsed(text));
  for (const SceneFree& f : free) {
    if (!f.element) continue;
    const Quantity q = f.variable.quantity;
    if (is_point(q) || is_weight(q)) {
      set_control_point(written, world, f);
      continue;
    }
    const Members members = members_of(world, f, unit);
    for (const auto& member : members.set) set_member(written, f, Place::law, member);
    for (const std::string& key : members.removed) remove_member(written, f, key);
    if (q == Quantity::radius)
      set_member(written, f, Place::part,
                 {"radius", fmt::format("{}", value_of(world, f.variable).numbers.x / unit)});
  }
  return written;
}

std::string words_of(const World& world, const SceneFree& f, const assembly::DesignChange& change) {
  const auto text = [&](const DesignValue& value) {
    const std::vector<double> numbers = shown_value(world, f.variable, value);
    return numbers.size() == 1 ? fmt::format("{:.9g}", numbers[0])
                               : fmt::format("[{:.9g}]", fmt::join(numbers, ", "));
  };
  return fmt::format("{} {} -> {}{}", f.path, text(change.before), text(change.after),
                     change.is_at_bound ? " (at its bound)" : "");
}

nlohmann::json design_to_json(const World& world, const std::vector<SceneFree>& free,
                              const std::vector<assembly::DesignChange>& changes) {
  nlohmann::json all = nlohmann::json::array();
  for (std::size_t i = 0; i < std::min(free.size(), changes.size()); ++i) {
    const auto value = [&](const DesignValue& of) -> nlohmann::json {
      const std::vector<double> numbers = shown_value(world, free[i].variable, of);
      return numbers.size() == 1 ? nlohmann::json(numbers[0]) : nlohmann::json(numbers);
    };
    all.push_back({{"of", free[i].path},
                   {"law", world.name_of(free[i].variable.law)},
                   {"before", value(changes[i].before)},
                   {"after", value(changes[i].after)},
                   {"at_bound", changes[i].is_at_bound},
                   {"in_file", free[i].element.has_value()}});
  }
  return all;
}

}  // namespace pantin::program
