#include "engine/runtime/coupling.hpp"

#include <algorithm>

#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

constexpr int kMaxIterations = 24;
constexpr Real kImpulseTolerance = 1e-6;  // of what is exchanged

struct CoupledIsland {
  const SolverRow* solver;
  std::size_t island;
};

/// The islands at interfaces, in the order of the solvers.
struct Coupled {
  static constexpr std::string_view name = "coupled";  // in saved Worlds
  std::vector<CoupledIsland> leaders, followers;
  std::vector<contact::Reaction> reactions;
  std::vector<Contact> contacts;  // as they were found for the step

  // Found anew in each step.
  static void fields(auto& self, auto&& field) {
    field("leaders", derived(self.leaders));
    field("followers", derived(self.followers));
    field("reactions", derived(self.reactions));
    field("contacts", derived(self.contacts));
  }
};

std::span<contact::Interface> interfaces_of(World& world, const CoupledIsland& leader) {
  return leader.solver->interfaces(world, leader.island);
}

template <class Work>
void each_interface(World& world, const Coupled& coupled, const Work& work) {
  for (const CoupledIsland& leader : coupled.leaders)
    for (contact::Interface& i : interfaces_of(world, leader)) work(i);
}

contact::Interface* find_interface(World& world, const Coupled& coupled,
                                   const contact::Reaction& reaction) {
  for (const CoupledIsland& leader : coupled.leaders)
    for (contact::Interface& i : interfaces_of(world, leader))
      if (i.kind == reaction.kind && i.source == reaction.source) return &i;
  return nullptr;
}

void export_reactions(World& world, Coupled& coupled, const CoupledIsland& follower, Real h) {
  coupled.reactions.clear();
  follower.solver->react(world, follower.island, h, coupled.reactions);
  for (const contact::Reaction& reaction : coupled.reactions)
    if (contact::Interface* i = find_interface(world, coupled, reaction))
      i->force = reaction.force, i->mass = reaction.mass;
}

/// Restores the multipliers and restitution of an island's contacts to those of the detection.
void restore_contacts(World& world, const Coupled& coupled, const CoupledIsland& of) {
  const Partition& partition = partition_of(world);
  std::vector<Contact>& contacts = contacts_of(world);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Owner owner = owner_of(partition, contacts[i].slot_a);
    if (owner.island == of.island && kSolvers[owner.solver] == of.solver)
      contacts[i] = coupled.contacts[i];
  }
}

/// Residuals of all interfaces; true if converged. Sets the relaxation factors of the next
/// iteration from the second iteration on.
bool update_residuals(World& world, const Coupled& coupled, Real h, int iteration) {
  bool converged = true;
  each_interface(world, coupled, [&](contact::Interface& g) {
    const Vec3 residual = h * g.force + g.carried - g.transmitted;
    const Real bound = kImpulseTolerance * h * (glm::length(g.force) + 1e-3 * g.mass);
    converged = converged && glm::length(residual) <= bound;
    const Vec3 change = residual - g.residual;  // [Aitken 1926], a vector at a time
    const Real size = glm::dot(change, change);
    if (iteration > 0 && size > 0)
      g.relax = std::clamp(-g.relax * glm::dot(g.residual, change) / size, 0.1, 3.0);
    g.residual = residual;
  });
  return converged;
}

Coupled& list_coupled(World& world) {
  Coupled& coupled = world.memory.of<Coupled>();
  coupled.leaders.clear(), coupled.followers.clear();
  for (const SolverRow* solver : kSolvers) {
    const std::size_t count = solver->count(world);
    for (std::size_t i = 0; i < count; ++i) {
      if (!solver->interfaces(world, i).empty()) coupled.leaders.push_back({solver, i});
      if (solver->follows(world, i)) coupled.followers.push_back({solver, i});
    }
  }
  return coupled;
}

}  // namespace

void recouple(World& world) {
  std::erase_if(list_coupled(world).leaders, [&](const CoupledIsland& leader) {
    return !leader.solver->has_begun(world, leader.island);
  });
}

void save_coupled(World& world) {
  Coupled& coupled = list_coupled(world);
  for (const CoupledIsland& c : coupled.leaders) c.solver->save(world, c.island);
  for (const CoupledIsland& c : coupled.followers) c.solver->save(world, c.island);
  each_interface(world, coupled, [](contact::Interface& i) {
    i.relax = 1, i.residual = Vec3(0), i.taut = i.force != Vec3(0);
  });
}

void step_coupled(World& world, Real h) {
  Coupled& coupled = world.memory.of<Coupled>();
  if (coupled.leaders.empty() && coupled.followers.empty()) return;
  coupled.contacts = contacts_of(world);
  for (int iteration = 0;; ++iteration) {
    bool failed = false;
    for (const CoupledIsland& c : coupled.leaders)
      failed = !c.solver->repeat(world, c.island, h) || failed;
    for (const CoupledIsland& c : coupled.followers) {
      if (c.solver->touches(world, c.island)) continue;
      if (iteration > 0) restore_contacts(world, coupled, c);
      c.solver->repeat(world, c.island, h);
      export_reactions(world, coupled, c, h);
    }
    const bool last =
        update_residuals(world, coupled, h, iteration) || failed || iteration + 1 == kMaxIterations;
    each_interface(world, coupled, [&](contact::Interface& i) {
      i.taut = i.taut || i.force != Vec3(0);
      i.iterations = iteration + 1;
      if (last)
        i.carried = i.residual;
      else
        i.impulse += i.relax * i.residual;
    });
    if (last) return;
  }
}

void couple_touching(World& world, Real h) {
  Coupled& coupled = world.memory.of<Coupled>();
  for (const CoupledIsland& c : coupled.followers) {
    if (!c.solver->touches(world, c.island)) continue;
    export_reactions(world, coupled, c, h);
    for (const contact::Reaction& reaction : coupled.reactions)  // its own interfaces alone
      if (contact::Interface* g = find_interface(world, coupled, reaction)) {
        const Vec3 residual = h * g->force - g->transmitted;
        g->impulse += residual - g->carried, g->carried = residual;
      }
  }
}

}  // namespace pantin::detail
