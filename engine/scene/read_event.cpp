// Timed events, each by the keys of its type.
#include <string>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

using enum TimedEventKind;

constexpr Real kNever = 1e300;

std::optional<Real> number_if(const Reader& from, std::string_view key) {
  if (!from.has(key)) return std::nullopt;
  return from.number(key, 0);
}

/// "from", "to" and "every", of those types that have them.
void read_times(const Reader& from, TimedEvent& e) {
  if (from.accepts("at")) e.from = from.number("at", 0);
  if (from.accepts("over")) e.over = from.number("over", 0);
  if (from.accepts("every")) e.every = from.number("every", 0);
  if (!from.accepts("from")) return;
  e.from = from.number("from", 0);
  e.to = from.number("to", kNever);
  if (e.to < e.from) {
    from.diagnostics.error(from.find("to"), "found " + written(e.to) + " s, before the begin at " +
                                                written(e.from) + " s, expected a later time");
    e.to = e.from;
  }
  if (e.every > 0 && e.to < kNever && e.to - e.from > e.every)
    from.diagnostics.error(from.find("every"), "found " + written(e.every) + " s, expected " +
                                                   written(e.to - e.from) +
                                                   " s or more: it starts again when it has ended");
}

void read_push(const Reader& from, EventRecipe& r) {
  const bool lasts = r.event.kind == push;
  (lasts ? r.event.force : r.event.impulse) = from.vec(lasts ? "force" : "impulse");
  (lasts ? r.event.torque : r.event.angular_impulse) =
      from.vec(lasts ? "torque" : "angular_impulse");
}

void read_wind(const Reading& reading, const Reader& from, EventRecipe& r) {
  TimedEvent& e = r.event;
  e.velocity = from.vec("velocity");
  e.gusts = from.vec_or_number("gusts");
  e.gust_time = from.number("gust_time");
  e.seed = static_cast<std::uint64_t>(from.whole("seed"));
  e.drag = from.number("drag", -1);
  r.bodies = read_names(reading, from, "bodies");
}

void read_pull(const Reader& from, EventRecipe& r) {
  TimedEvent& e = r.event;
  e.target = from.vec("target", Vec3(0));
  e.stiffness = from.number("stiffness"), e.damping = from.number("damping");
  if (!from.has("over")) e.over = e.to < kNever ? e.to - e.from : 1;
}

void read_motor(const Reader& from, EventRecipe& r) {
  constexpr Real kDegree = kPi / 180;
  JointMotor& m = r.event.motor;
  const bool goes = from.has("position") || from.has("position_deg");
  const bool turns = from.has("velocity") || from.has("velocity_deg");
  if (goes || turns) m.kind = goes ? MotorKind::position : MotorKind::velocity;
  m.target = from.number(goes ? "position" : "velocity", 0);
  const std::string_view deg = goes ? "position_deg" : "velocity_deg";
  r.in_degrees = from.has(deg);
  if (r.in_degrees) m.target = kDegree * from.number(deg, 0);
  r.gain = number_if(from, "gain"), r.damping = number_if(from, "damping");
  r.most = number_if(from, "cap");
}

void read_what(const Reading& reading, const Reader& from, EventRecipe& r) {
  TimedEvent& e = r.event;
  switch (e.kind) {
    case push:
    case impulse:
      return read_push(from, r);
    case wind:
      return read_wind(reading, from, r);
    case pull:
      return read_pull(from, r);
    case cut:
      return;
    case motor:
      return read_motor(from, r);
    case drive:
      r.gain = number_if(from, "stiffness"), r.damping = number_if(from, "damping");
      r.most = number_if(from, "max_torque");
      return;
    case winch:
      e.length = from.number("length", 1);
      return;
    case gravity:
      e.gravity = from.vec("gravity", Vec3(0));
      return;
    case solver:
      e.solver = static_cast<Solver>(from.word("solver", 0));
      return;
  }
}

/// What it happens to, by the key that names it; false if that could not be read.
bool read_object(const Reader& from, EventRecipe& r) {
  for (const std::string_view key : {"body", "joint", "cable", "pin", "gear"}) {
    if (!from.accepts(key) || !from.has(key)) continue;
    const auto name = from.reference(key);
    if (!name) return false;
    r.member = key, r.on = *name;
    return true;
  }
  return r.event.kind == wind || r.event.kind == gravity || r.event.kind == solver;
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
  const auto type = read_type(reading, node, kTimedEventNames);
  if (!type) return std::nullopt;
  const Reader from = reading.open(node, std::string(kTimedEventNames[*type]) + "_event");
  EventRecipe r;
  r.event.kind = static_cast<TimedEventKind>(*type);
  read_times(from, r.event);
  if (from.accepts("anchor")) r.point = {from.vec_if("point"), from.vec_if("anchor")};
  read_what(reading, from, r);
  if (!read_object(from, r)) return std::nullopt;
  return r;
}

}  // namespace pantin::detail
