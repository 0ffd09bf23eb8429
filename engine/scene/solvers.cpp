#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/disjoint_sets.hpp"
#include "engine/scene/assembly.hpp"

namespace pantin {
namespace {

/// The dynamic body of a joint.
std::uint32_t mover(const Assembly& assembly, const PlacedJoint& joint) {
  return assembly.is_dynamic(joint.a) ? joint.a : joint.b;
}

/// What a joint has that only the Lagrangian solver knows, by the member it is written in.
struct Extra {
  std::string_view member;
  std::string what;
};
std::vector<Extra> extras_of(const PlacedJoint& joint) {
  const std::string name = "\"" + joint.name + "\"", named = "joint " + name;
  if (!is_articulated(joint.joint.kind)) return {{"kind", a_joint(joint.joint.kind) + " " + name}};
  const JointExtras& extras = *joint.joint.extras;
  const SpringDamper& spring = extras.turn.spring;
  const JointFriction& friction = extras.turn.friction;
  std::vector<Extra> found;
  if (spring.stiffness != 0 || spring.damping != 0)
    found.push_back({"spring", "\"spring\" of " + named});
  if (friction.viscous != 0 || friction.dry != 0)
    found.push_back({"friction", "\"friction\" of " + named});
  if (extras.turn.motor.kind != MotorKind::none)
    found.push_back({"motor", "\"motor\" of " + named});
  if (extras.restitution != 0)
    found.push_back({"limits/restitution", "\"restitution\" of " + named});
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
                     BuildMessages& messages) {
  // The fault of a prefab once, however often it is copied.
  std::set<std::pair<ElementId, std::string_view>> told;
  const auto refuse = [&](const ElementId& at, const Extra& extra, Solver solver) {
    if (told.insert({at, extra.member}).second)
      messages.error(at, extra.member,
                     "found " + extra.what + " solved by \"" + name_of(solver) +
                         "\", expected the solver \"lagrangian\": no other knows it");
  };
  for (const PlacedJoint& j : assembly.joints) {
    const Solver solver = solvers[mover(assembly, j)];
    if (solver == Solver::lagrangian || (!j.joint.extras.any() && is_articulated(j.joint.kind)))
      continue;
    for (const Extra& extra : extras_of(j)) refuse(j.at, extra, solver);
  }
  for (const PlacedRatio& r : assembly.ratios)
    if (const Solver solver = solvers[mover(assembly, assembly.joints[r.first])];
        solver != Solver::lagrangian)
      refuse(r.at, {"", "ratio \"" + r.name + "\" of joints"}, solver);
}

}  // namespace pantin
