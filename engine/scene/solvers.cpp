#include <algorithm>
#include <set>
#include <string>

#include "engine/scene/assembly.hpp"
#include "engine/scene/read.hpp"
#include "engine/base/disjoint_sets.hpp"
#include "engine/world/faults.hpp"

namespace pantin {
namespace {

/// The dynamic body of a joint.
std::uint32_t mover(const Assembly& assembly, const PlacedJoint& joint) {
  return assembly.is_dynamic(joint.a) ? joint.a : joint.b;
}

/// What a joint has that not every solver knows, by the place it is written at.
struct Extra {
  NodeId at;
  std::string what;
  Feature feature;
};
std::vector<Extra> extras_of(const PlacedJoint& joint, const JsonDocument& json) {
  if (!holds_point(joint.joint.kind))
    return {{json.member(joint.at, "kind"), a_joint(joint.joint.kind) + " \"" + joint.name + "\"",
             Feature::kind}};
  std::vector<Extra> found;
  const auto look = [&](NodeId object, const std::string& key, Feature feature) {
    const NodeId at = object == kNoNode ? kNoNode : json.member(object, key);
    if (at != kNoNode)
      found.push_back({at, "\"" + key + "\" of joint \"" + joint.name + "\"", feature});
  };
  look(joint.at, "spring", Feature::spring), look(joint.at, "friction", Feature::friction);
  look(joint.at, "motor", Feature::motor);
  look(json.member(joint.at, "limits"), "restitution", Feature::restitution);
  if (joint.drive) look(joint.at, "drive", Feature::pose_drive);
  return found;
}

}  // namespace

std::vector<Solver> solvers_of(const Assembly& assembly, Solver otherwise) {
  DisjointSets sets(assembly.bodies.size());
  const auto tie = [&](std::uint32_t a, std::uint32_t b) {
    if (assembly.is_dynamic(a) && assembly.is_dynamic(b)) sets.join(a, b);
  };
  for (const PlacedJoint& j : assembly.joints) tie(j.a, j.b);
  for (const PlacedRatio& r : assembly.ratios)
    tie(mover(assembly, assembly.joints[r.first]), mover(assembly, assembly.joints[r.second]));
  std::vector<Solver> solvers(assembly.bodies.size(), otherwise);
  std::vector<bool> is_named(assembly.bodies.size(), false);
  for (std::uint32_t i = 0; i < solvers.size(); ++i) {
    if (!assembly.bodies[i].solver || !assembly.is_dynamic(i)) continue;
    const std::uint32_t root = sets.root(i);
    if (!is_named[root]) solvers[root] = assembly.bodies[i].solver->solver;
    is_named[root] = true;
  }
  for (std::uint32_t i = 0; i < solvers.size(); ++i) solvers[i] = solvers[sets.root(i)];
  return solvers;
}

void refuse_unsolved(const Assembly& assembly, const std::vector<Solver>& solvers,
                     const JsonDocument& json, Complaints& complaints) {
  std::set<NodeId> told;  // the fault of a prefab once, however often it is copied
  const auto refuse = [&](NodeId at, const std::string& what, Solver solver, Feature feature) {
    if (!knows(solver, feature) && told.insert(at).second)
      complaints.refuse(at, "found " + what + " solved by \"" + name_of(solver) +
                                "\", expected the solver " + solvers_that_know(feature) +
                                ": no other knows it");
  };
  for (const PlacedJoint& j : assembly.joints) {
    if (!j.joint.extras.any() && holds_point(j.joint.kind) && !j.drive) continue;
    for (const Extra& extra : extras_of(j, json))
      refuse(extra.at, extra.what, solvers[mover(assembly, j)], extra.feature);
  }
  for (const PlacedRatio& r : assembly.ratios)
    refuse(r.at, "ratio \"" + r.name + "\" of joints",
           solvers[mover(assembly, assembly.joints[r.first])], Feature::ratio);
  for (const PlacedString& s : assembly.strings)
    for (const std::uint32_t end : {s.a, s.b})
      if (assembly.is_dynamic(end))
        refuse(s.at, "cable \"" + s.name + "\"", solvers[end], Feature::cable);
}

}  // namespace pantin
