// Timed events, each by the keys of its kind.
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

/// "from", "to" and "every", of those kinds that have them.
template <class E>
void check_times(const Reader& from, E& e) {
  if constexpr (requires { e.to; })
    if (e.to < e.from) {
      from.diagnostics.error(from.find("to"), "found " + written(e.to) +
                                                  " s, before the start at " + written(e.from) +
                                                  " s, expected a later time");
      e.to = e.from;
    }
  if constexpr (Lasts<E>)
    if (e.every > 0 && e.to < kNever && e.to - e.from > e.every)
      from.diagnostics.error(from.find("every"),
                             "found " + written(e.every) + " s, expected " +
                                 written(e.to - e.from) +
                                 " s or more: it can restart only after it has ended");
}

// ---- Defaults that depend on other values ----

void prepare(auto&) {}
void finish(const Reader&, const auto&, EventRecipe&) {}

void finish(const Reader& from, PullEvent& e, EventRecipe&) {
  if (!from.has("over")) e.over = e.to < kNever ? e.to - e.from : 1;
}

void prepare(MotorEvent& e) { e.motor.gain = e.motor.damping = e.motor.cap = kAsBefore; }

void finish(const Reader& from, MotorEvent& e, EventRecipe& r) {
  const bool goes = from.has("position") || from.has("position_deg");
  const bool turns = from.has("velocity") || from.has("velocity_deg");
  if (goes || turns) e.motor.kind = goes ? MotorKind::position : MotorKind::velocity;
  r.in_degrees = from.has(goes ? "position_deg" : "velocity_deg");
}

void prepare(DriveEvent& e) { e.stiffness = e.damping = e.max_torque = kAsBefore; }

// ---- Keys ----

/// Reads the value of each key into its member; names go into the recipe.
struct KeyReader {
  const Reading& reading;
  const Reader& from;
  EventRecipe& recipe;

  void operator()(const EventKey& key, Entity&) const {
    if (!recipe.member.empty() || !from.has(key.key)) return;
    const auto name = from.reference(key.key);
    if (name) recipe.member = key.key, recipe.on = *name;
  }
  void operator()(const EventKey& key, std::vector<Entity>&) const {
    recipe.bodies = read_names(reading, from, key.key);
  }
  void operator()(const EventKey& key, Solver& solver) const {
    solver = static_cast<Solver>(from.word(key.key, static_cast<std::size_t>(solver)));
  }
  void operator()(const EventKey& key, std::uint64_t& whole) const {
    whole = static_cast<std::uint64_t>(from.whole(key.key, static_cast<int>(whole)));
  }
  void operator()(const EventKey& key, Real& number) const {
    if (from.has(key.key)) number = key.scale * from.number(key.key, number / key.scale);
  }
  void operator()(const EventKey& key, std::optional<DriveMotion>& motion) const {
    if (!from.has(key.key)) return;
    const UnboundMotion read =
        read_drive_motion(reading.open(from.find(key.key), "drive_motion"), reading);
    motion = read.motion, recipe.in_degrees = read.in_degrees, recipe.says_along = read.says_along;
  }
  void operator()(const EventKey& key, Vec3& v) const {
    if (key.form == EventForm::anchor)
      recipe.point = {from.vec_if("point"), from.vec_if(key.key)};
    else
      v = key.form == EventForm::vector_or_number ? from.vec_or_number(key.key, v)
                                                  : from.vec(key.key, v);
  }
};

/// Returns false if the target of the event is unknown.
template <class Event>
bool read_kind(const Reading& reading, const Reader& from, EventRecipe& recipe) {
  Event e;
  prepare(e);
  Event::scene_keys(e, KeyReader{reading, from, recipe});
  check_times(from, e);
  finish(from, e, recipe);
  recipe.event.kind = std::move(e);
  return !kHasTarget<Event> || !recipe.member.empty();
}

template <class... Kinds>
bool read_kind_at(std::size_t index, const Reading& reading, const Reader& from,
                  EventRecipe& recipe) {
  using Read = bool (*)(const Reading&, const Reader&, EventRecipe&);
  static constexpr Read all[] = {&read_kind<Kinds>...};
  return all[index](reading, from, recipe);
}

}  // namespace

std::vector<std::string> read_names(const Reading& reading, const Reader& from,
                                    std::string_view key) {
  std::vector<std::string> names;
  for (const NodeId node : from.items(key)) {
    const JsonNode& name = reading.json[node];
    if (name.kind == JsonKind::string && !name.text.empty())
      names.emplace_back(name.text);
    else
      reading.diagnostics.error_value(node, "the name of a body");
  }
  return names;
}

std::optional<EventRecipe> read_event(const Reading& reading, NodeId node) {
  const auto type = read_type(reading, node, kEventNames);
  if (!type) return std::nullopt;
  const Reader from = reading.open(node, std::string(kEventNames[*type]) + "_event");
  EventRecipe recipe;
  const auto read = [&]<class... Kinds>(const std::variant<Kinds...>*) {
    return read_kind_at<Kinds...>(*type, reading, from, recipe);
  };
  if (!read(static_cast<const EventKinds*>(nullptr))) return std::nullopt;
  recipe.length_unit = reading.length_unit;
  return recipe;
}

}  // namespace pantin::detail
