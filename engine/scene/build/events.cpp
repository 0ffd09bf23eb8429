// Timed events: looks up the entities that they act on.
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/joints/kinds.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"
#include "engine/world/drive_motion.hpp"

namespace pantin::detail {
namespace {

EventObject object_of(std::string_view member) {
  if (member == "body" || member == "bodies") return EventObject::body;
  if (member == "joint") return EventObject::joint;
  if (member == "cable") return EventObject::cable;
  if (member == "pin") return EventObject::pin;
  return member == "gear" ? EventObject::gear : EventObject::none;
}

template <class T>
std::vector<std::string_view> names_in(const std::vector<T>& list) {
  std::vector<std::string_view> names;
  names.reserve(list.size());
  for (const T& x : list) names.push_back(x.name);
  return names;
}

std::vector<std::string_view> names_of(const BuiltScene& built, EventObject object) {
  switch (object) {
    case EventObject::body:
      return names_in(built.bodies);
    case EventObject::joint:
      return names_in(built.joints);
    case EventObject::cable:
      return names_in(built.cables);
    case EventObject::pin:
      return names_in(built.pins);
    case EventObject::gear:
      return names_in(built.gears);
    case EventObject::none:
      break;
  }
  return {};
}

/// Whether the joint lacks the motor or drive that the event changes.
bool lacks(const BuiltJoint& j, const TimedEvent& event) {
  if (const auto* drive = std::get_if<DriveEvent>(&event.kind))
    return !j.drive || (drive->motion && !j.drive->exact);
  if (!std::holds_alternative<MotorEvent>(event.kind)) return false;
  const JointParameters& own = *j.joint.parameters;
  return own.rotation.motor.kind == MotorKind::none &&
         own.translation.motor.kind == MotorKind::none;
}

/// The given value, or the previous one if none is given.
Real or_before(Real said, Real before) { return std::isnan(said) ? before : said; }

}  // namespace

/// The entities of one type by name, and by the names of the chains, instances and grids that
/// contain them.
const GroupBuilder::Index& GroupBuilder::index_of(EventObject object) {
  Index& index = indices_[static_cast<std::size_t>(object)];
  if (!index.names.empty() || object == EventObject::none) return index;
  index.names = names_of(made_, object);
  for (std::uint32_t i = 0; i < index.names.size(); ++i) {
    const std::string_view name = index.names[i];
    index.found[name].push_back(i);
    for (std::size_t end = name.find('/'); end != name.npos; end = name.find('/', end + 1))
      index.found[name.substr(0, end)].push_back(i);
  }
  return index;
}

/// All entities that a name denotes; null after an error.
const std::vector<std::uint32_t>* GroupBuilder::look_up_all(EventObject object,
                                                            const std::string& name,
                                                            const Wanted& wanted) {
  const Index& index = index_of(object);
  const auto it = index.found.find(name);
  if (it != index.found.end()) return &it->second;
  if (is_below_broken(name) || broken_.contains(name)) return nullptr;
  std::vector<std::string_view> near;
  if (messages_.hints().any_left()) near = index.names;
  messages_.error(wanted.from, wanted.member,
                  "found " + quoted_name(name) + ", expected " + std::string(wanted.what) +
                      messages_.hints().of(name, near));
  return nullptr;
}

bool GroupBuilder::can_be_pushed(Element<EventRecipe> e, std::uint32_t body) {
  if (made_.is_dynamic(body)) return true;
  messages_.error(e.id, e.recipe.member,
                  "found " + quoted_name(e.recipe.on) +
                      ", expected a dynamic body: forces do not move this one");
  return false;
}

/// Completes a motor with the values it keeps; returns false after an error.
bool GroupBuilder::set_motor(Element<EventRecipe> e, std::uint32_t joint, JointMotor& m) {
  const BuiltJoint& j = made_.joints[joint];
  const JointKindInfo& kind = info_of(j.joint.kind);
  const bool turns = kind.is_used(Coordinate::angle, kActuated),
             slides = kind.is_used(Coordinate::travel, kActuated);
  const auto error = [&](const std::string& what) {
    messages_.error(e.id, "joint",
                    "found " + a_joint(j.joint.kind) + " " + quoted_name(j.name) + what);
    return false;
  };
  if (!turns && !slides)
    return error(", expected one with one rotational or translational coordinate");
  if (!turns && e.recipe.in_degrees)
    return error(" with an angle in degrees, expected a travel in m");
  const JointParameters& own = *j.joint.parameters;
  const JointMotor& before = turns ? own.rotation.motor : own.translation.motor;
  const Real unit = e.recipe.length_unit;
  // The target in m or m/s; of torques in N mm, and N/mm or N s/mm along a travel.
  if (!turns) m.target *= unit, m.gain /= unit, m.damping /= unit;
  if (turns) m.gain *= unit, m.damping *= unit, m.cap *= unit;
  if (m.kind == MotorKind::none) m.kind = before.kind, m.target = before.target;
  if (m.kind == MotorKind::none)
    return error(" without a motor, expected the \"velocity\" or \"position\" of a new one");
  const bool same = m.kind == before.kind;
  m.gain = or_before(m.gain, before.gain), m.cap = or_before(m.cap, before.cap);
  if (m.gain == 0 && m.damping > 0)
    return error(" whose motor has no \"gain\", expected one with a new \"damping\"");
  m.damping = or_before(m.damping, same ? before.damping : 0);
  return true;
}

/// Fits the motion of an event to the joint that it drives; returns false after an error.
bool GroupBuilder::set_motion(Element<EventRecipe> e, const BuiltJoint& j, DriveMotion& motion) {
  const auto error = [&](const std::string& what) {
    messages_.error(e.id, "motion",
                    "found a motion for the drive of " + quoted_name(j.name) + ", " + what);
    return false;
  };
  if (!j.drive->exact)
    return error("which is a spring; expected an exact drive, with a \"motion\" of its own");
  const bool travels = j.drive->motion.travels;
  if (e.recipe.says_along && motion.travels != travels)
    return error(travels ? "which drives the travel; expected \"along\": \"travel\""
                         : "which drives the angle; expected \"along\": \"angle\"");
  if (travels && e.recipe.in_degrees)
    return error("which drives a travel; expected numbers in m, not in degrees");
  motion.travels = travels;
  if (travels) scale(motion, e.recipe.length_unit);
  return true;
}

/// The same for a joint drive.
bool GroupBuilder::set_drive(Element<EventRecipe> e, std::uint32_t joint, DriveEvent& event) {
  const BuiltJoint& j = made_.joints[joint];
  if (!j.drive) {
    messages_.error(
        e.id, "joint",
        "found joint " + quoted_name(j.name) + " without a drive, expected one with a \"drive\"");
    return false;
  }
  if (event.motion && !set_motion(e, j, *event.motion)) return false;
  if (j.drive->motion.travels) event.max_torque /= e.recipe.length_unit;  // N, not N m
  return true;
}

/// Computes the point of action on a body; returns false after an error.
bool GroupBuilder::place_event(Element<EventRecipe> e, std::uint32_t body, TimedEvent& event) {
  if (!can_be_pushed(e, body)) return false;
  bool good = true;
  std::visit(
      [&]<class Event>(Event& kind) {
        if constexpr (requires { kind.anchor; }) {
          constexpr bool at_origin = requires { Event::anchors_at_origin; };
          const PointRecipe& point = e.recipe.point;
          if (at_origin || point.in_body || point.in_scene)
            kind.anchor = anchor_of(made_, body, point);
          good = can_hold(e.id, "anchor", body, kind.anchor);
        }
      },
      event.kind);
  if (!good || !made_.bodies[body].mass_properties->is_point) return good;
  each_event_key(event, [&]<class T>(const EventKey& key, const T& member) {
    if constexpr (std::is_same_v<T, Vec3>)
      if (key.form == EventForm::axial && member != Vec3(0))
        messages_.error(e.id, key.key,
                        "found a torque on the point mass " + quoted_name(made_.bodies[body].name) +
                            ", expected a body with a \"shape\" or an \"inertia\"");
  });
  return true;
}

/// Adds one event for each entity that a name denotes.
void GroupBuilder::add_event_on(Element<EventRecipe> e, EventObject object, std::uint32_t which) {
  BuiltEvent built{e.id, e.recipe.event, object, which, {}};
  TimedEvent& event = built.event;
  if (object == EventObject::body && !place_event(e, which, event)) return;
  if (auto* motor = std::get_if<MotorEvent>(&event.kind))
    if (!set_motor(e, which, motor->motor)) return;
  if (auto* drive = std::get_if<DriveEvent>(&event.kind))
    if (!set_drive(e, which, *drive)) return;
  made_.events.push_back(std::move(built));
}

void GroupBuilder::add_event(Element<EventRecipe> e) {
  const EventRecipe& r = e.recipe;
  const EventObject object = object_of(r.member);
  if (object == EventObject::none) {
    BuiltEvent built{e.id, r.event, object, 0, {}};
    bool good = true;
    for (const std::string& name : r.bodies) {
      const auto* found =
          look_up_all(EventObject::body, name,
                      {e.id, "bodies", "the name of a body, a chain, an instance or a grid"});
      good = good && found;
      if (found) built.bodies.insert(built.bodies.end(), found->begin(), found->end());
    }
    if (good && count_targets(e.id, 1 + built.bodies.size()))
      made_.events.push_back(std::move(built));
    return;
  }
  if (object == EventObject::body) {
    if (const auto found = body(r.on, e.id, r.member)) add_event_on(e, object, *found);
    return;
  }
  const std::string what = "the name of a " + r.member;
  const auto* all = look_up_all(object, r.on, {e.id, r.member, what});
  if (!all || !count_targets(e.id, all->size())) return;
  // In a group, only joints with a motor or a drive are addressed.
  const auto is_left_out = [&](std::uint32_t which) {
    return object == EventObject::joint && lacks(made_.joints[which], r.event);
  };
  const bool some = all->size() > 1 && !std::all_of(all->begin(), all->end(), is_left_out);
  for (const std::uint32_t which : *all)
    if (!some || !is_left_out(which)) add_event_on(e, object, which);
}

/// Reports more targets of events than the limit for joints: a few lines can ask for millions.
bool GroupBuilder::count_targets(const ElementId& at, std::size_t more) {
  targets_ += more;
  if (targets_ <= context_.limits.links) return true;
  messages_.error(at, "",
                  "found events on more than " + std::to_string(context_.limits.links) +
                      " objects, expected fewer");
  return false;
}

}  // namespace pantin::detail
