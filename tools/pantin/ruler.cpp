#include "tools/pantin/ruler.hpp"

#include <algorithm>

#include "engine/runtime/simulation.hpp"

namespace pantin::program {
namespace {

/// The joint by which a body is held to a body that joints do not move.
std::string name_of_joint(const World& world, Entity a, Entity b) {
  for (std::size_t i = 0; i < world.links.size(); ++i) {
    const Link& link = world.links.values()[i];
    if ((link.a == a && link.b == b) || (link.a == b && link.b == a))
      return world.name_of(world.links.owners()[i]);
  }
  return world.name_of(a) + " to " + world.name_of(b);
}

Unreached described(const World& world, const Articulation& a, const Hold& hold) {
  if (hold.held_pin != UINT32_MAX)
    return {world.name_of(world.pins.owners()[hold.held_pin]), "pin", hold.residual};
  const Entity other = world.bodies.owners()[hold.held_body];
  return {name_of_joint(world, a.bodies[hold.column], other), "joint", hold.residual};
}

}  // namespace

std::vector<Unreached> unreached(const World& world) {
  std::vector<Unreached> found;
  for (const Articulation& a : world.articulations) {
    const Real bound = a.settings.tolerance * a.size;
    for (const Hold& hold : a.holds)
      if (hold.compliance == 0 && hold.residual > bound) found.push_back(described(world, a, hold));
    for (const Cord& cord : a.cords) {
      const String& s = world.strings.values()[cord.string];
      if (s.joint.compliance > 0) continue;
      const Real over = stretch(s.joint, world.bodies[s.a].pose, world.bodies[s.b].pose);
      if (over > bound)
        found.push_back({world.name_of(world.strings.owners()[cord.string]), "string", over});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Unreached& x, const Unreached& y) {
    return x.residual_m > y.residual_m;
  });
  return found;
}

std::string solvers_of(const World& world) {
  std::string all;
  for (Solver s : {Solver::automatic, Solver::sweep, Solver::shake2, Solver::paper}) {
    const auto uses = [s](const Articulation& a) { return a.settings.solver == s; };
    if (std::any_of(world.articulations.begin(), world.articulations.end(), uses))
      all += (all.empty() ? "" : "+") + std::string(name_of(s));
  }
  return all.empty() ? name_of(world.default_settings.solver) : all;
}

std::vector<std::string> structure_faults(World& world) {
  if (world.built_for != world.structure()) rebuild_articulations(world);
  std::vector<std::string> lines;
  for (const StructureFault& fault : world.faults) {
    const char* kind = world.strings.find(fault.link) ? "string "
                       : world.pins.find(fault.link)  ? "pin "
                                                      : "joint ";
    lines.push_back(kind + world.name_of(fault.link) + " is left out: it " + fault.reason);
  }
  return lines;
}

Counts counts_of(const World& world) {
  Counts n;
  n.bodies = world.bodies.size(), n.joints = world.links.size();
  n.strings = world.strings.size(), n.pins = world.pins.size();
  n.articulations = world.articulations.size();
  for (const Body& body : world.bodies.values()) {
    if (body.motion == Motion::driven) ++n.driven;
    if (body.motion != Motion::dynamic) continue;
    ++n.dynamic, n.mass += body.mass;
  }
  return n;
}

void Ruler::start(const World& world) {
  last = measure(world);
  energy_start = energy_end = energy_max = last.energy();
}

void Ruler::take(const World& world, const StepReport& report) {
  last = measure(world);
  worst_gap_rel = std::max(worst_gap_rel, last.worst_gap_rel);
  if (last.worst_gap > worst_gap) {
    worst_gap = last.worst_gap, worst_time = report.time;
    worst_joint = last.worst_link ? world.name_of(last.worst_link) : "";
  }
  energy_end = last.energy();
  energy_max = std::max(energy_max, energy_end);
  worst_unreached = std::max(worst_unreached, report.worst_residual);
}

}  // namespace pantin::program
