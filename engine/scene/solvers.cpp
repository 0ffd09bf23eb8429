#include <algorithm>
#include <set>
#include <string>

#include "engine/scene/assembly.hpp"
#include "engine/scene/read.hpp"
#include "engine/base/disjoint_sets.hpp"

namespace pantin {
namespace {

/// The dynamic body of a joint.
std::uint32_t mover(const Assembly& assembly, const PlacedJoint& joint) {
  return assembly.is_dynamic(joint.a) ? joint.a : joint.b;
}

/// What a joint has that only the Lagrangian solver knows, by the place it is written at.
struct Extra {
  NodeId at;
  std::string what;
};
std::vector<Extra> extras_of(const PlacedJoint& joint, const JsonDocument& json) {
  if (!is_articulated(joint.joint.kind))
    return {{json.member(joint.at, "kind"), a_joint(joint.joint.kind) + " \"" + joint.name + "\""}};
  std::vector<Extra> found;
  const auto look = [&](NodeId object, const std::string& key) {
    const NodeId at = object == kNoNode ? kNoNode : json.member(object, key);
    if (at != kNoNode) found.push_back({at, "\"" + key + "\" of joint \"" + joint.name + "\""});
  };
  for (const char* key : {"spring", "friction", "motor"}) look(joint.at, key);
  look(json.member(joint.at, "limits"), "restitution");
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
  const auto refuse = [&](NodeId at, const std::string& what, Solver solver) {
    if (told.insert(at).second)
      complaints.refuse(at, "found " + what + " solved by \"" + name_of(solver) +
                                "\", expected the solver \"lagrangian\": no other knows it");
  };
  for (const PlacedJoint& j : assembly.joints) {
    const Solver solver = solvers[mover(assembly, j)];
    if (solver == Solver::lagrangian || (!j.joint.extras.any() && is_articulated(j.joint.kind)))
      continue;
    for (const Extra& extra : extras_of(j, json))
      refuse(extra.at, extra.what, solver);
  }
  for (const PlacedRatio& r : assembly.ratios)
    if (const Solver solver = solvers[mover(assembly, assembly.joints[r.first])];
        solver != Solver::lagrangian)
      refuse(r.at, "ratio \"" + r.name + "\" of joints", solver);
}

}  // namespace pantin
