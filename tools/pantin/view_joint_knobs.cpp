// Knobs of joints: motors, springs, limits.
#include <algorithm>
#include <cmath>
#include <pantin/change.hpp>

#include "engine/joints/kinds.hpp"
#include "tools/pantin/view_knobs.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr std::size_t kMostJoints = 12;  // shown in the panel with motors, and with other laws
constexpr std::string_view kWords[] = {"motor ", "stiffness ", "damping ", "least ", "most "};
constexpr std::string_view kSuffixes[] = {".angle", ".travel"};

/// Whether laws act along both coordinates of a joint.
bool has_both(const JointKindInfo& kind) {
  return kind.is_used(Coordinate::angle, kActuated) && kind.is_used(Coordinate::travel, kActuated);
}

std::optional<JointCoordinate> meant_by(const JointKnob& knob) {
  if (!knob.is_named) return std::nullopt;
  return knob.along == Coordinate::travel ? JointCoordinate::travel : JointCoordinate::angle;
}

/// A coordinate of a joint, with its name as in knobs.
struct KnobCoordinate {
  JointKnob knob;
  std::string name;
};

std::vector<KnobCoordinate> coordinates_of(const World& world, Entity joint) {
  const JointKindInfo& kind = info_of(world.links[joint].joint.kind);
  const std::string name = world.name_of(joint);
  JointKnob knob{JointValue::motor, name, joint, Coordinate::angle, false};
  if (!has_both(kind)) {
    knob.along = kind.find(Coordinate::angle) ? Coordinate::angle : Coordinate::travel;
    return {{knob, name}};
  }
  knob.is_named = true;
  JointKnob travel = knob;
  travel.along = Coordinate::travel;
  return {{knob, name + std::string(kSuffixes[0])}, {travel, name + std::string(kSuffixes[1])}};
}

/// A World, and the scene as read: the reference of ranges.
struct KnobWorlds {
  const World &world, &start;
};

Knob knob_of(const KnobCoordinate& of, JointValue value, const char* unit, Interval range) {
  return {std::string(kWords[static_cast<std::size_t>(value)]) + of.name,
          unit,
          KnobGroup::motors,
          0,
          range.low,
          range.high};
}

void add_motor(const KnobWorlds& in, const KnobCoordinate& of, std::vector<Knob>& to) {
  const auto along = meant_by(of.knob);
  const JointMotor motor = motor_of(in.world, of.knob.entity, along);
  if (motor.kind == MotorKind::none) return;
  const JointMotor was = motor_of(in.start, of.knob.entity, along);
  const double target = was.kind != MotorKind::none ? was.target : motor.target;
  const double reach = std::max(2 * std::abs(target), 2 * kPi);
  const bool speeds = motor.kind == MotorKind::velocity;
  const bool travels = of.knob.along == Coordinate::travel;
  const char* unit = travels ? (speeds ? "m/s" : "m") : (speeds ? "rad/s" : "rad");
  to.push_back(knob_of(of, JointValue::motor, unit, {-reach, reach}));
  to.back().value = motor.target;
}

/// Springs and limits.
void add_laws(const KnobWorlds& in, const KnobCoordinate& of, std::vector<Knob>& to) {
  const Entity e = of.knob.entity;
  const auto along = meant_by(of.knob);
  const bool travels = of.knob.along == Coordinate::travel;
  const auto add = [&](JointValue value, const char* unit, double at, Interval range) {
    to.push_back(knob_of(of, value, unit, range));
    to.back().value = at;
  };
  const SpringDamper spring = spring_of(in.world, e, along), was = spring_of(in.start, e, along);
  if (const double most = std::max(spring.stiffness, was.stiffness); most > 0)
    add(JointValue::stiffness, travels ? "N/m" : "N m/rad", spring.stiffness, {0, 4 * most});
  if (const double most = std::max(spring.damping, was.damping); most > 0)
    add(JointValue::damping, travels ? "N s/m" : "N m s/rad", spring.damping, {0, 4 * most});
  if (const auto range = pantin::limits_of(in.world, e, along)) {
    const double reach =
        travels ? std::max({2 * std::abs(range->low), 2 * std::abs(range->high), 0.01}) : kPi;
    add(JointValue::least, travels ? "m" : "rad", range->low, {-reach, reach});
    add(JointValue::most, travels ? "m" : "rad", range->high, {-reach, reach});
  }
}

}  // namespace

std::optional<JointKnob> joint_knob(const World& world, std::string_view name) {
  const auto word =
      std::ranges::find_if(kWords, [&](std::string_view w) { return name.starts_with(w); });
  if (word == std::end(kWords)) return std::nullopt;
  name.remove_prefix(word->size());
  for (const Entity e : world.links.owners())
    for (KnobCoordinate& of : coordinates_of(world, e))
      if (of.name == name) {
        of.knob.value = static_cast<JointValue>(word - std::begin(kWords));
        return of.knob;
      }
  return std::nullopt;
}

bool turn_joint_knob(World& world, const JointKnob& knob, double value) {
  const Entity e = knob.entity;
  const auto along = meant_by(knob);
  if (knob.value == JointValue::motor) {
    JointMotor motor = motor_of(world, e, along);
    if (motor.kind == MotorKind::none) return false;
    motor.target = value;
    return static_cast<bool>(set_motor(world, e, motor, along));
  }
  if (knob.value == JointValue::stiffness || knob.value == JointValue::damping) {
    SpringDamper spring = spring_of(world, e, along);
    if (!(spring.stiffness > 0 || spring.damping > 0)) return false;
    (knob.value == JointValue::stiffness ? spring.stiffness : spring.damping) =
        std::max(value, 0.0);
    return static_cast<bool>(set_spring(world, e, spring, along));
  }
  auto range = pantin::limits_of(world, e, along);
  if (!range) return false;
  if (knob.value == JointValue::least)
    range->low = std::min(value, range->high);
  else
    range->high = std::max(value, range->low);
  return static_cast<bool>(set_limits(world, e, *range, along));
}

void add_joint_knobs(const World& world, const World& start, std::vector<Knob>& to) {
  for (const auto add : {add_motor, add_laws}) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < world.links.size() && count < kMostJoints; ++i) {
      const std::size_t before = to.size();
      for (const KnobCoordinate& of : coordinates_of(world, world.links.owners()[i]))
        add({world, start}, of, to);
      count += to.size() > before;
    }
  }
}

}  // namespace pantin::program
