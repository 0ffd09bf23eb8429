#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/scene/build/build.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/holds.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin::detail {
namespace {

/// The dynamic body of a joint.
std::uint32_t mover(const BuiltScene& built, const BuiltJoint& joint) {
  return built.is_dynamic(joint.a) ? joint.a : joint.b;
}

/// A feature of a joint that not every solver supports, with the member it is written in.
struct Extra {
  std::string_view member;
  std::string what;
  Feature feature;
};
std::vector<Extra> extras_of(const BuiltJoint& joint) {
  const std::string name = "\"" + joint.name + "\"", named = "joint " + name;
  if (!is_articulated(joint.joint.kind))
    return {{"kind", a_joint(joint.joint.kind) + " " + name, Feature::kind}};
  const JointParameters& parameters = *joint.joint.parameters;
  const SpringDamper& spring = parameters.rotation.spring;
  const JointFriction& friction = parameters.rotation.friction;
  std::vector<Extra> found;
  if (spring.stiffness != 0 || spring.damping != 0)
    found.push_back({"spring", "\"spring\" of " + named, Feature::spring});
  if (friction.viscous != 0 || friction.dry != 0)
    found.push_back({"friction", "\"friction\" of " + named, Feature::friction});
  if (parameters.rotation.motor.kind != MotorKind::none)
    found.push_back({"motor", "\"motor\" of " + named, Feature::motor});
  if (parameters.restitution != 0)
    found.push_back({"limits/restitution", "\"restitution\" of " + named, Feature::restitution});
  if (joint.drive) found.push_back({"drive", "\"drive\" of " + named, feature_of(*joint.drive)});
  return found;
}

}  // namespace

std::vector<Solver> solvers_of(const BuiltScene& built, Solver otherwise) {
  DisjointSets sets(built.bodies.size());
  const auto tie = [&](std::uint32_t a, std::uint32_t b) {
    if (built.is_dynamic(a) && built.is_dynamic(b)) sets.join(a, b);
  };
  for (const BuiltJoint& j : built.joints) tie(j.a, j.b);
  for (const BuiltGear& r : built.gears)
    tie(mover(built, built.joints[r.first]), mover(built, built.joints[r.second]));
  for (const BuiltBelt& belt : built.belts) {
    std::uint32_t last = belt.bodies[0];
    for (const std::uint32_t body : belt.bodies) {
      tie(last, body);
      if (built.is_dynamic(body)) last = body;
    }
  }
  for (const BuiltSurfaceJoint& s : built.surface_joints) tie(s.a, s.b);
  for (const BuiltCable& c : built.cables) {
    std::uint32_t last = built.is_dynamic(c.a) ? c.a : c.b;
    for (const BuiltGuide& g : c.guides) {
      tie(last, g.body);
      if (built.is_dynamic(g.body)) last = g.body;
    }
    if (!c.guides.empty()) tie(last, c.b);
  }
  std::vector<Solver> solvers(built.bodies.size(), otherwise);
  std::vector<bool> is_named(built.bodies.size(), false);
  for (std::uint32_t i = 0; i < solvers.size(); ++i) {
    if (!built.bodies[i].solver || !built.is_dynamic(i)) continue;
    const std::uint32_t root = sets.root(i);
    if (!is_named[root]) solvers[root] = built.bodies[i].solver->solver;
    is_named[root] = true;
  }
  for (std::uint32_t i = 0; i < solvers.size(); ++i) solvers[i] = solvers[sets.root(i)];
  return solvers;
}

namespace {

std::string knowing(Feature feature) {
  const std::string told = solvers_that_know(feature);
  if (!knows(Solver::planar, feature) || told.find("planar") != std::string::npos)
    return told + ": no other supports it";
  return told + ", or \"planar\" for motion in the xy plane";
}

/// The constraints that hold each body: their number, and the first one.
struct Holders {
  const HoldBound& bound;
  std::vector<std::size_t> count{};
  std::vector<ElementId> first{};

  void add(std::uint32_t body, ElementId at) {
    if (count[body]++ == 0) first[body] = at;
  }
};

/// Reports bodies with more pins, or joints to fixed bodies, than their solver handles, at the
/// first of them.
void check_holders(const BuiltScene& built, const std::vector<Solver>& solvers,
                   BuildMessages& messages) {
  const std::size_t bodies = built.bodies.size();
  const auto none = [&](const HoldBound& bound) {
    return Holders{bound, std::vector<std::size_t>(bodies), std::vector<ElementId>(bodies)};
  };
  Holders pins = none(kExactPins), joints = none(kJointsToFixed);
  for (const BuiltPin& p : built.pins)
    for (const std::uint32_t body : {p.body, p.to})
      if (p.pin.kind == PinKind::exact && built.is_dynamic(body)) pins.add(body, p.at);
  for (const BuiltJoint& j : built.joints)
    if (built.is_dynamic(j.a) != built.is_dynamic(j.b))
      joints.add(built.is_dynamic(j.a) ? j.a : j.b, j.at);
  std::vector<PairedJoint> paired;
  for (std::uint32_t i = 0; i < built.joints.size(); ++i)
    if (const BuiltJoint& j = built.joints[i];
        built.is_dynamic(j.a) && built.is_dynamic(j.b) && solvers[j.a] == Solver::lagrangian)
      paired.push_back({i, j.a, j.b});
  for (const JointsOfPair& p : list_crowded_pairs(std::move(paired)))
    messages.error(built.joints[p.first.joint].at, "",
                   "found " + std::to_string(p.count) + " joints between the bodies \"" +
                       built.bodies[p.first.a].name + "\" and \"" + built.bodies[p.first.b].name +
                       "\" solved by \"lagrangian\", expected at most " +
                       std::to_string(kJointsOfPair.most) + "; three already fix a body");
  for (const Holders* of : {&pins, &joints})
    for (std::size_t body = 0; body < bodies; ++body)
      if (of->count[body] > of->bound.most && solvers[body] == Solver::lagrangian)
        messages.error(of->first[body], "",
                       "found " + std::to_string(of->count[body]) + " " +
                           std::string(of->bound.what) + " of body \"" + built.bodies[body].name +
                           "\" solved by \"lagrangian\", expected at most " +
                           std::to_string(of->bound.most) + "; three already fix a body");
}

}  // namespace

void check_solvers(const BuiltScene& built, const std::vector<Solver>& solvers,
                   BuildMessages& messages) {
  // A fault in a prefab is reported once, however often it is copied.
  std::set<std::pair<ElementId, std::string_view>> told;
  const auto error = [&](const ElementId& at, const Extra& extra, Solver solver) {
    if (!knows(solver_for(solver, extra.feature), extra.feature) &&
        told.insert({at, extra.member}).second)
      messages.error(at, extra.member,
                     "found " + extra.what + " solved by \"" + name_of(solver) +
                         "\", expected the solver " + knowing(extra.feature));
  };
  for (const BuiltJoint& j : built.joints) {
    if (!j.joint.parameters.any() && is_articulated(j.joint.kind) && !j.drive) continue;
    for (const Extra& extra : extras_of(j)) error(j.at, extra, solvers[mover(built, j)]);
  }
  for (const BuiltGear& r : built.gears)
    error(r.at, {"", "gear \"" + r.name + "\" of joints", Feature::ratio},
          solvers[mover(built, built.joints[r.first])]);
  for (const BuiltBelt& belt : built.belts)
    for (const std::uint32_t body : belt.bodies)
      if (built.is_dynamic(body))
        error(belt.at,
              {belt.belt.friction > 0 ? "friction" : "", "belt \"" + belt.name + "\"",
               feature_of(belt.belt)},
              solvers[body]);
  for (const BuiltSurfaceJoint& s : built.surface_joints) {
    const std::string what = "surface joint \"" + s.name + "\"";
    const Feature feature = feature_of(s.contact);
    const Extra extra = feature == Feature::curve_friction
                            ? Extra{"friction", "the friction of " + what, feature}
                            : Extra{"", what, feature};
    error(s.at, extra, solvers[built.is_dynamic(s.a) ? s.a : s.b]);
  }
  for (const BuiltCable& s : built.cables) {
    for (const std::uint32_t end : {s.a, s.b})
      if (built.is_dynamic(end))
        error(s.at, {"", "cable \"" + s.name + "\"", Feature::cable}, solvers[end]);
    for (const BuiltGuide& g : s.guides)
      for (const std::uint32_t body : {s.a, g.body, s.b})
        if (built.is_dynamic(body))
          error(s.at, {"over", "guides of cable \"" + s.name + "\"", Feature::cable_guide},
                solvers[body]);
  }
  check_holders(built, solvers, messages);
}

namespace {

/// The first feature that a solver set for all bodies does not support.
std::string unknown_to(const BuiltScene& built, Solver solver) {
  const auto steps = [&](Feature what) { return knows(solver_for(solver, what), what); };
  for (const BuiltJoint& j : built.joints)
    if (j.joint.parameters.any() || !is_articulated(j.joint.kind) || j.drive)
      for (const Extra& extra : extras_of(j))
        if (!steps(extra.feature)) return extra.what;
  for (const BuiltBody& b : built.bodies)
    if (solver == Solver::quasistatic && b.body.motion == Motion::dynamic && !b.is_lamina)
      return "body \"" + b.name + "\", which is not a lamina";
  if (!built.gears.empty() && !steps(Feature::ratio))
    return "gear \"" + built.gears.front().name + "\"";
  for (const BuiltBelt& b : built.belts)
    if (!steps(feature_of(b.belt))) return "belt \"" + b.name + "\"";
  for (const BuiltSurfaceJoint& s : built.surface_joints)
    if (!steps(feature_of(s.contact))) return "surface joint \"" + s.name + "\"";
  if (!built.cables.empty() && !steps(Feature::cable))
    return "cable \"" + built.cables.front().name + "\"";
  for (const BuiltCable& c : built.cables)
    if (!c.guides.empty() && !steps(Feature::cable_guide))
      return "guides of cable \"" + c.name + "\"";
  return "";
}

bool feels_wind(const BuiltScene& built, const BuiltEvent& e) {
  if (std::get<WindEvent>(e.event.kind).drag > 0) return true;
  const auto drags = [&](std::uint32_t body) {
    return built.is_dynamic(body) && built.bodies[body].body.drag > 0;
  };
  if (!e.bodies.empty()) return std::any_of(e.bodies.begin(), e.bodies.end(), drags);
  for (std::uint32_t i = 0; i < built.bodies.size(); ++i)
    if (drags(i)) return true;
  return false;
}

}  // namespace

void check_events(const BuiltScene& built, const std::vector<Solver>& solvers,
                  BuildMessages& messages) {
  for (const BuiltEvent& e : built.events) {
    const Solver here = e.object == EventObject::joint  ? solvers[mover(built, built.joints[e.on])]
                        : e.object == EventObject::body ? solvers[e.on]
                                                        : Solver::articulated;
    const auto error = [&](std::string_view member, const std::string& what, Feature feature) {
      if (!knows(solver_for(here, feature), feature))
        messages.error(e.at, member,
                       "found " + what + " solved by \"" + name_of(here) +
                           "\", expected the solver " + knowing(feature));
    };
    if (std::holds_alternative<MotorEvent>(e.event.kind))
      error("joint", "a motor of joint \"" + built.joints[e.on].name + "\"", Feature::motor);
    if (const auto* pull = std::get_if<PullEvent>(&e.event.kind); pull && pull->stiffness > 0)
      error("stiffness", "a compliant pull", Feature::spring_pin);
    const auto* other = std::get_if<SolverEvent>(&e.event.kind);
    if (!other) continue;
    if (const std::string what = unknown_to(built, other->solver); !what.empty())
      messages.error(e.at, "solver",
                     "found \"" + std::string(name_of(other->solver)) +
                         "\", expected a solver that supports " + what);
  }
}

void warn_of_events(const BuiltScene& built, Real duration, BuildMessages& messages) {
  for (const BuiltEvent& e : built.events) {
    if (const Real start = start_of(e.event); start >= duration)
      messages.warn(e.at, "late",
                    "event at " + written(start) + " s comes after the end of the scene at " +
                        written(duration) + " s");
    if (std::holds_alternative<WindEvent>(e.event.kind) && !feels_wind(built, e))
      messages.warn(
          e.at, "calm",
          "no body has drag, so this wind has no effect; give the bodies or the wind a \"drag\"");
  }
}

}  // namespace pantin::detail
