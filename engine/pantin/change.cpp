// Changes joints of a running World: checks the new values, and wakes the bodies concerned.
#include <algorithm>
#include <limits>
#include <pantin/change.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/pantin/detail/checks.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin {

using namespace detail;

namespace {

using Along = std::optional<JointCoordinate>;

std::string other_than(const char* wanted, const World& world, Entity e) {
  if (!e) return "no entity";
  return world.is_alive(e) ? "'" + world.name_of(e) + "', which is no " + wanted
                           : "an entity that was destroyed or is of another World (#" +
                                 std::to_string(e.index) + ")";
}

std::string name_in(const World& world, Entity e) {
  return world.is_alive(e) ? world.name_of(e) : "";
}

/// Whether springs, friction and motors act along a coordinate.
bool acts_along(JointKind kind, Coordinate which) {
  return info_of(kind).is_used(which, kActuated);
}

/// The coordinate to act on: the joint's angle if it has one that qualifies, else its travel; none
/// if it has neither.
template <class Has>
std::optional<Coordinate> coordinate_of(const Along& along, const Has& has) {
  for (const Coordinate which : {Coordinate::angle, Coordinate::travel}) {
    const bool travels = which == Coordinate::travel;
    const bool meant = !along || (*along == JointCoordinate::travel) == travels;
    if (meant && has(which)) return which;
  }
  return std::nullopt;
}

std::optional<Coordinate> actuated(const Joint& joint, const Along& along) {
  // A spring between two points acts along their distance.
  if (joint.kind == JointKind::spring) return Coordinate::travel;
  return coordinate_of(along, [&](Coordinate c) { return acts_along(joint.kind, c); });
}

std::optional<Coordinate> limited(const Joint& joint, const Along& along) {
  return coordinate_of(along, [&](Coordinate c) {
    const FreeCoordinate* found = info_of(joint.kind).find(c);
    return found && !found->limit.empty();
  });
}

const Dof& dof_at(const Joint& joint, Coordinate which) {
  return which == Coordinate::angle ? joint.parameters->rotation : joint.parameters->translation;
}

const Dof* find_dof(const World& world, Entity joint, const Along& along) {
  const Link* link = world.links.find(joint);
  if (!link) return nullptr;
  const auto which = actuated(link->joint, along);
  return which ? &dof_at(link->joint, *which) : nullptr;
}

/// Edits a copy of a joint, which finally replaces the original.
class JointChange {
 public:
  JointChange(World& world, const char* what, Entity joint)
      : findings(world, what, name_in(world, joint)), world_(world), entity_(joint) {
    if (const Link* link = world.links.find(joint))
      joint_ = link->joint;
    else
      findings.add("joint", other_than("joint", world, joint), "a joint");
  }

  Joint& joint() { return joint_; }
  void refuse(const char* expected) {
    findings.add("joint", std::string("a joint of kind ") + name_of(joint_.kind), expected);
  }

  /// Adding or removing a law, or changing a range, changes the structure; the parameters of a law
  /// are read in every step.
  Result<Done> finish() {
    if (!findings.ok()) return findings.take();
    Link& link = world_.links[entity_];
    const std::vector<Feature> before = features_of(link.joint);
    std::vector<Feature> fresh = features_of(joint_);
    std::erase_if(fresh, [&](Feature f) {
      return std::find(before.begin(), before.end(), f) != before.end();
    });
    findings.known(fresh, {link.a, link.b});
    if (!findings.ok()) return findings.take();
    const auto acts = [](const Joint& j) {
      return std::pair(j.parameters->rotation.any(), j.parameters->translation.any());
    };
    const bool rebuilt = acts(link.joint) != acts(joint_) || ranges_changed;
    if (rebuilt)
      world_.links.add(entity_, {link.a, link.b, std::move(joint_)});
    else
      link.joint = std::move(joint_);
    const Link& now = world_.links[entity_];
    wake(world_, now.a), wake(world_, now.b);
    return Done{};
  }

  Findings findings;
  bool ranges_changed = false;

 private:
  World& world_;
  Entity entity_;
  Joint joint_;
};

template <class Law>
Result<Done> set_law(JointChange change, const Law& law, Law Dof::*member, const Along& along) {
  if (!change.findings.ok()) return change.findings.take();
  check(change.findings, law);
  const auto which = actuated(change.joint(), along);
  const bool between_points = change.joint().kind == JointKind::spring;
  if (!which || (between_points && !std::is_same_v<Law, SpringDamper>)) {
    change.refuse("one with one rotational or translational coordinate");
    return change.findings.take();
  }
  JointParameters& own = change.joint().parameters.edit();
  Dof& dof = *which == Coordinate::angle ? own.rotation : own.translation;
  dof.*member = law;
  if (between_points) own.length = own.translation.spring.rest;
  return change.finish();
}

}  // namespace

Result<Done> set_motor(World& world, Entity joint, const JointMotor& motor, Along along) {
  auto done = set_law({world, "set_motor", joint}, motor, &Dof::motor, along);
  if (done && motor.kind != MotorKind::none && motor.gain == 0) world.mark_dirty();
  return done;
}

Result<Done> set_spring(World& world, Entity joint, const SpringDamper& spring, Along along) {
  return set_law({world, "set_spring", joint}, spring, &Dof::spring, along);
}

Result<Done> set_friction(World& world, Entity joint, const JointFriction& friction, Along along) {
  return set_law({world, "set_friction", joint}, friction, &Dof::friction, along);
}

JointMotor motor_of(const World& world, Entity joint, Along along) {
  const Dof* dof = find_dof(world, joint, along);
  return dof ? dof->motor : JointMotor{};
}

SpringDamper spring_of(const World& world, Entity joint, Along along) {
  const Dof* dof = find_dof(world, joint, along);
  return dof ? dof->spring : SpringDamper{};
}

JointFriction friction_of(const World& world, Entity joint, Along along) {
  const Dof* dof = find_dof(world, joint, along);
  return dof ? dof->friction : JointFriction{};
}

// ---- Ranges ----

Result<Done> set_limits(World& world, Entity joint, std::optional<Interval> limits, Along along) {
  JointChange change(world, "set_limits", joint);
  if (!change.findings.ok()) return change.findings.take();
  const auto which = limited(change.joint(), along);
  const AngleLimit range = limit_of(change.findings, "limits", limits);
  if (!which)
    change.refuse("one with a range along one coordinate");
  else if (*which == Coordinate::angle)
    change.joint().limits.edit().angle = range;
  else
    change.joint().parameters.edit().travel = range;
  change.ranges_changed = true;
  return change.finish();
}

std::optional<Interval> limits_of(const World& world, Entity joint, Along along) {
  const Link* link = world.links.find(joint);
  const auto which = link ? limited(link->joint, along) : std::nullopt;
  if (!which) return std::nullopt;
  const AngleLimit& range =
      *which == Coordinate::angle ? link->joint.limits->angle : link->joint.parameters->travel;
  if (!range.on) return std::nullopt;
  return Interval{range.low, range.high};
}

Result<Done> set_second_limits(World& world, Entity joint, std::optional<Interval> limits) {
  JointChange change(world, "set_second_limits", joint);
  if (!change.findings.ok()) return change.findings.take();
  const AngleLimit range = limit_of(change.findings, "limits", limits);
  if (!info_of(change.joint().kind).find(Coordinate::second)) change.refuse("a universal joint");
  change.joint().limits.edit().second = range;
  change.ranges_changed = true;
  return change.finish();
}

Result<Done> set_cone(World& world, Entity joint, std::optional<ConeLimit> cone) {
  JointChange change(world, "set_cone", joint);
  if (!change.findings.ok()) return change.findings.take();
  if (!info_of(change.joint().kind).find(Coordinate::swing)) change.refuse("a ball joint");
  change.joint().limits.edit().swing = cone ? swing_of(change.findings, *cone) : SwingLimit{};
  change.ranges_changed = true;
  return change.finish();
}

Result<Done> set_soft_stop(World& world, Entity joint, std::optional<SoftStop> soft_stop) {
  JointChange change(world, "set_soft_stop", joint);
  if (!change.findings.ok()) return change.findings.take();
  JointLimits& limits = change.joint().limits.edit();
  limits.soft_zone = limits.soft_stiffness = limits.soft_damping = 0;
  soften(change.findings, soft_stop, limits);
  change.ranges_changed = true;
  return change.finish();
}

Result<Done> set_drive(World& world, Entity joint, std::optional<JointDrive> drive) {
  Findings findings(world, "set_drive", name_in(world, joint));
  const Link* link = world.links.find(joint);
  if (!link)
    findings.add("joint", other_than("joint", world, joint), "a joint");
  else if (drive)
    check_drive(findings, *drive, link->joint.kind);
  check(findings, drive);
  JointDrive* old = world.joint_drives.find(joint);
  const bool same = old && drive && old->exact == drive->exact;
  if (findings.ok() && drive && !same) findings.known({{feature_of(*drive)}}, {link->a, link->b});
  if (!findings.ok()) return findings.take();
  if (!drive) {
    world.joint_drives.remove(joint);
  } else if (old) {
    drive->torque = old->torque, drive->capped = old->capped;
    if (!same || drive->exact) world.mark_dirty();
    *old = std::move(*drive);
    fit_spline(old->motion);
  } else {
    fit_spline(world.joint_drives.add(joint, std::move(*drive)).motion);
  }
  wake(world, link->a), wake(world, link->b);
  return Done{};
}

Result<Done> follow(World& world, std::span<const Entity> joints, std::span<const BodyTurn> pose,
                    const JointDrive& muscles) {
  Findings findings(world, "follow", "");
  for (const BodyTurn& turn : pose)
    findings.body("pose.body", turn.body), findings.rotation("pose.rotation", turn.rotation);
  for (const Entity e : joints)
    if (!world.links.find(e)) findings.add("joints", other_than("joint", world, e), "joints");
  if (!findings.ok()) return findings.take();
  // In mass-centre frames.
  const auto rotation_of = [&](Entity body) -> std::optional<Quat> {
    for (const BodyTurn& turn : pose)
      if (turn.body == body) {
        const Pose* origin = world.origins.find(body);
        const Quat frame = glm::normalize(turn.rotation);
        return origin ? frame * glm::conjugate(origin->rotation) : frame;
      }
    return std::nullopt;
  };
  for (const Entity e : joints) {
    const Link& link = world.links[e];
    const auto a = rotation_of(link.a), b = rotation_of(link.b);
    if (!a || !b) continue;
    JointDrive drive = muscles;
    drive.target = glm::normalize(relative_rotation(link.joint, *a, *b));
    if (auto done = set_drive(world, e, std::move(drive)); !done) return done;
  }
  return Done{};
}

Result<Done> set_cable_length(World& world, Entity cable, Real length) {
  Findings findings(world, "set_cable_length", name_in(world, cable));
  Cable* found = world.cables.find(cable);
  if (!found) findings.add("cable", other_than("cable", world, cable), "a cable");
  findings.above_zero("length", length);
  if (!findings.ok()) return findings.take();
  found->joint.length = length;
  wake(world, found->a), wake(world, found->b);
  for (const CableGuide& g : found->guides) wake(world, g.body);
  return Done{};
}

Real cable_length(const World& world, Entity cable) {
  const Cable* found = world.cables.find(cable);
  return found ? found->joint.length : std::numeric_limits<Real>::quiet_NaN();
}

}  // namespace pantin
