// Joints of any kind, by the properties that the kind declares.
#include <algorithm>
#include <string>

#include "engine/joints/kinds.hpp"
#include "engine/pantin/detail/joint_frames.hpp"

namespace pantin {

using namespace detail;

namespace {

// Predicates on the kinds that have a member.
template <Coordinate which>
bool is_limited(const JointKindInfo& kind) {
  const FreeCoordinate* c = kind.find(which);
  return c && !c->limit.empty();
}
template <Coordinate which>
bool is_actuated(const JointKindInfo& kind) {
  return kind.is_used(which, kActuated);
}
bool has_stops(const JointKindInfo& kind) {
  return is_limited<Coordinate::angle>(kind) || is_limited<Coordinate::travel>(kind);
}
bool can_be_soft(const JointKindInfo& kind) { return kind.holds_point && has_stops(kind); }
bool can_be_driven(const JointKindInfo& kind) {
  if (is_actuated<Coordinate::angle>(kind) || is_actuated<Coordinate::travel>(kind)) return true;
  return kind.holds_point && kind.rotations != Turns::nowhere;
}
bool has_ends_apart(const JointKindInfo& kind) { return !kind.holds_point; }
bool is_described(const JointKindInfo& kind) { return kind.in_files; }

/// Makes a joint from its description, and collects the errors.
class JointMaker {
 public:
  JointMaker(Findings& findings, const AnyJoint& described)
      : findings_(findings), described_(described) {}

  /// The joint, if there are no errors.
  Joint make();

 private:
  bool find_kind();
  WorldFrames place();
  void check_members();
  void set_limits();
  void set_forces();
  void set_parameters();
  void set_parameter(const Parameter& parameter);

  Findings& findings_;
  const AnyJoint& described_;
  JointKind kind_{};
  WorldFrames at_;
  Joint joint_;
};

bool JointMaker::find_kind() {
  if (joint_kind_from_name(described_.kind, kind_) && info_of(kind_).in_files) return true;
  findings_.add("kind", "'" + described_.kind + "'", kinds_where(is_described));
  return false;
}

/// Reports members that joints of this kind do not have.
void JointMaker::check_members() {
  const AnyJoint& d = described_;
  const auto acts = [](const JointAction& action) {
    return Dof{action.spring, action.friction, action.motor}.any();
  };
  const struct {
    const char* member;
    bool is_given;
    bool (*fits)(const JointKindInfo&);
  } rows[] = {{"anchor_b", d.anchor_b.has_value(), has_ends_apart},
              {"limits", d.limits.has_value(), is_limited<Coordinate::angle>},
              {"second_limits", d.second_limits.has_value(), is_limited<Coordinate::second>},
              {"travel_limits", d.travel_limits.has_value(), is_limited<Coordinate::travel>},
              {"cone", d.cone.has_value(), is_limited<Coordinate::swing>},
              {"soft_stop", d.soft_stop.has_value(), can_be_soft},
              {"restitution", d.restitution != 0, has_stops},
              {"drive", d.drive.has_value(), can_be_driven},
              {"angle", acts(d.angle), is_actuated<Coordinate::angle>},
              {"travel", acts(d.travel), is_actuated<Coordinate::travel>}};
  for (const auto& row : rows)
    if (row.is_given && !row.fits(info_of(kind_)))
      findings_.add(row.member, std::string("it of a joint of kind ") + name_of(kind_),
                    "it of these kinds only: " + kinds_where(row.fits));
}

WorldFrames JointMaker::place() {
  const AnyJoint& d = described_;
  if (d.frames) return from_local(findings_, {d.a, d.b}, *d.frames);
  WorldFrames at = at_place(findings_, d.anchor, axes_along(findings_, "axis", d.axis, d.across));
  if (!d.anchor_b) return at;
  findings_.finite("anchor_b", *d.anchor_b);
  at.b.position = *d.anchor_b;
  return at;
}

void JointMaker::set_limits() {
  const AnyJoint& d = described_;
  JointLimits limits;
  limits.angle = limit_of(findings_, "limits", d.limits);
  limits.second = limit_of(findings_, "second_limits", d.second_limits);
  if (d.cone) limits.swing = swing_of(findings_, *d.cone);
  soften(findings_, d.soft_stop, limits);
  if (limits.any()) joint_.limits = limits;
  const AngleLimit travel = limit_of(findings_, "travel_limits", d.travel_limits);
  if (travel.on) joint_.parameters.edit().travel = travel;
  findings_.within("restitution", d.restitution, 0, 1);
  if (d.restitution != 0) joint_.parameters.edit().restitution = d.restitution;
}

void JointMaker::set_forces() {
  const auto checked = [&](const JointAction& action) {
    check(findings_, action.motor), check(findings_, action.spring);
    check(findings_, action.friction);
    return Dof{action.spring, action.friction, action.motor};
  };
  const Dof rotation = checked(described_.angle), translation = checked(described_.travel);
  if (rotation.any()) joint_.parameters.edit().rotation = rotation;
  if (translation.any()) joint_.parameters.edit().translation = translation;
  check(findings_, described_.drive);
}

void JointMaker::set_parameter(const Parameter& parameter) {
  const auto& given = described_.parameters;
  const char* key = parameter.key.data();
  const auto it = std::ranges::find(given, parameter.key, &JointParameter::key);
  Real& value = parameter.value(joint_.parameters.edit());
  if (it != given.end())
    value = it->value;
  else if (parameter.as_placed)
    value = glm::distance(at_.a.position, at_.b.position);
  else if (!parameter.needed.empty())
    return findings_.add(key, "none", std::string(parameter.needed));
  findings_.finite(key, value);
  if (parameter.range == ParameterRange::not_negative) findings_.not_negative(key, value);
  if (parameter.range == ParameterRange::size) findings_.above_zero(key, value);
  if (!parameter.never_zero.empty() && value == 0)
    findings_.add(key, "0", "another number: " + std::string(parameter.never_zero));
}

void JointMaker::set_parameters() {
  const JointKindInfo& kind = info_of(kind_);
  for (const JointParameter& p : described_.parameters)
    if (std::ranges::find(kind.parameters, std::string_view(p.key), &Parameter::key) ==
        kind.parameters.end())
      findings_.add("parameters", "'" + p.key + "' of a joint of kind " + name_of(kind_),
                    kind.parameters.empty() ? "none" : "parameters of that kind");
  for (const Parameter& p : kind.parameters) set_parameter(p);
  if (!kind.parameters.empty()) kind.complete(joint_.parameters.edit());
}

Joint JointMaker::make() {
  findings_.bodies(described_.a, described_.b);
  if (!find_kind()) return {};
  check_members();
  at_ = place();
  if (!findings_.ok()) return {};
  joint_ = make_joint(findings_.world(), kind_, {described_.a, described_.b}, at_);
  set_limits(), set_forces(), set_parameters();
  if (findings_.ok())
    if (const char* why = info_of(kind_).fault(joint_)) findings_.add("kind", why, "another joint");
  return std::move(joint_);
}

}  // namespace

Result<Entity> add_to(World& world, const AnyJoint& described) {
  Findings findings(world, "AnyJoint", described.name);
  const Joint joint = JointMaker(findings, described).make();
  if (!findings.ok()) return findings.take();
  return link(world, findings, described, joint);
}

std::vector<std::string> joint_kinds() {
  std::vector<std::string> names;
  for (const JointKindInfo& kind : kJointKindInfos)
    if (kind.in_files) names.emplace_back(kind.name);
  return names;
}

std::vector<std::string> parameters_of_kind(const std::string& kind) {
  std::vector<std::string> keys;
  JointKind found{};
  if (joint_kind_from_name(kind, found))
    for (const Parameter& p : info_of(found).parameters) keys.emplace_back(p.key);
  return keys;
}

}  // namespace pantin
