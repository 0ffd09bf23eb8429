#include "tools/pantin/groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_set>

#include "engine/base/disjoint_sets.hpp"
#include "engine/geometry/convex.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// The box around the shapes of a body; around its mass centre if it has none.
Aabb bounds_of_body(const World& world, Entity e) {
  const Pose& at = world.bodies[e].pose;
  Aabb box;
  box.add(at.position);
  if (const Shapes* shapes = world.shapes.find(e))
    for (const Shape& shape : shapes->list)
      if (shape.kind != ShapeKind::plane) box.add(bounds_of(shape, compose(at, shape.local)));
  return box;
}

bool has_solver_events(const World& world) {
  const auto* events = events_of(world);
  return events && std::ranges::any_of(events->values(), [](const TimedEvent& e) {
           return std::holds_alternative<SolverEvent>(e.kind);
         });
}

/// Merges the islands whose bodies come near each other, and notes when each body moved last.
class Meetings {
 public:
  explicit Meetings(const World& world) : sets_(world.bodies.size()), awake_(world.bodies.size()) {
    for (const IslandPlan& island : find_islands(world))
      for (const std::uint32_t slot : island.slots) sets_.join(island.slots.front(), slot);
    for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
      const Entity e = world.bodies.owners()[slot];
      const Collision* c = world.collisions.find(e);
      if (world.bodies[e].motion == Motion::dynamic && c && !c->sensor)
        solid_.push_back({slot, bounds_of_body(world, e)});
    }
    list_overlaps(world);
  }

  void look(const World& world) {
    for (const std::uint32_t slot : partition_of(world).awake) awake_[slot] = world.time;
    if (solid_.size() < 2) return;
    for (Solid& s : solid_) {
      const Aabb now = bounds_of_body(world, world.bodies.owners()[s.slot]);
      s.box = s.last, s.box.add(now), s.last = now;
      s.box = s.box.grown(0.1 * glm::length(now.high - now.low));
    }
    list_overlaps(world);
  }

  std::uint32_t root(std::uint32_t slot) { return sets_.root(slot); }
  double awake_until(std::uint32_t slot) const { return awake_[slot]; }

 private:
  struct Solid {
    std::uint32_t slot;
    Aabb last, box = last;  // m; of this step: swept, and enlarged
  };

  void list_overlaps(const World& world) {
    std::ranges::sort(solid_, {}, [](const Solid& s) { return s.box.low.x; });
    for (std::size_t i = 0; i < solid_.size(); ++i)
      for (std::size_t j = i + 1; j < solid_.size(); ++j) {
        const Solid &a = solid_[i], &b = solid_[j];
        if (b.box.low.x > a.box.high.x) break;
        if (a.box.overlaps(b.box) && may_collide(world, a.slot, b.slot)) sets_.join(a.slot, b.slot);
      }
  }

  static bool may_collide(const World& world, std::uint32_t a, std::uint32_t b) {
    const Collision &one = world.collisions[world.bodies.owners()[a]],
                    &two = world.collisions[world.bodies.owners()[b]];
    return do_groups_agree(one, two) && (one.others || two.others);
  }

  DisjointSets sets_;
  std::vector<Solid> solid_;
  std::vector<double> awake_;  // s, by slot
};

std::string name_of_group(const World& world, const Group& group) {
  constexpr std::size_t kNamed = 2;
  std::string name;
  for (std::size_t i = 0; i < std::min(kNamed, group.bodies.size()); ++i)
    name += (i > 0 ? ", " : "") + world.name_of(group.bodies[i]);
  if (group.bodies.size() > kNamed)
    name += fmt::format(" and {} more", group.bodies.size() - kNamed);
  return name;
}

std::vector<Group> list_groups(const World& world, Meetings& meetings) {
  std::vector<Group> groups;
  std::vector<std::size_t> at(world.bodies.size(), SIZE_MAX);
  const Store<Lamina>* laminas = laminas_of(world);
  for (const IslandPlan& island : find_islands(world)) {
    std::size_t& place = at[meetings.root(island.slots.front())];
    if (place == SIZE_MAX) place = groups.size(), groups.emplace_back();
    Group& group = groups[place];
    ++group.islands;
    for (const std::uint32_t slot : island.slots) {
      const Entity e = world.bodies.owners()[slot];
      group.bodies.push_back(e);
      group.has_laminas = group.has_laminas || (laminas && laminas->find(e));
      group.sleeps_from = std::max(group.sleeps_from, meetings.awake_until(slot));
    }
  }
  for (Group& g : groups) {
    std::ranges::sort(g.bodies, {}, [&](Entity e) { return world.bodies.slot(e); });
    g.name = name_of_group(world, g);
  }
  return groups;
}

/// What copies have in common: bodies with shapes and settings, and what joins them.
std::uint64_t fingerprint(const Scene& scene, const Group& group) {
  const Scene part = part_of(scene, group);
  const World& w = part.world;
  Hash hash;
  for (const Entity e : group.bodies) {
    const Body& b = w.bodies[e];
    hash.add(b.mass), hash.add(b.inertia), hash.add(b.drag), hash.add(b.gravity_scale);
    if (const Shapes* shapes = w.shapes.find(e)) hash_fields(hash, *shapes);
    if (const Collision* c = w.collisions.find(e)) hash_fields(hash, *c);
    if (const SolverSettings* s = w.settings.find(e)) hash_fields(hash, *s);
  }
  for (const Link& l : w.links.values()) hash.add(static_cast<std::uint64_t>(l.joint.kind));
  for (const std::size_t count : {w.links.size(), w.cables.size(), w.gears.size(), w.belts.size(),
                                  w.pins.size(), w.surface_contacts.size()})
    hash.add(static_cast<std::uint64_t>(count));
  return hash.value();
}

/// Whether two motions differ only in where they start.
bool are_alike(const Track& a, const Track& b) {
  constexpr double kSame = 1e-6;  // of the size
  if (a.poses.size() != b.poses.size() || a.poses.empty()) return false;
  const double most = kSame * std::max(size_of(a), 1e-3);
  const Vec3 between = b.poses[0].position - a.poses[0].position;
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    if (!(glm::length(b.poses[i].position - a.poses[i].position - between) <= most)) return false;
    if (!(std::abs(glm::dot(a.poses[i].rotation, b.poses[i].rotation)) >= 1 - kSame)) return false;
  }
  return true;
}

std::vector<GroupKind> list_kinds(const Scene& scene, const std::vector<Group>& groups,
                                  const Track& motion) {
  std::vector<GroupKind> kinds;
  std::vector<std::uint64_t> prints;
  std::vector<Track> tracks;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::uint64_t print = fingerprint(scene, groups[g]);
    Track track = track_of(motion, scene.world, groups[g]);
    std::size_t k = 0;
    while (k < kinds.size() && (prints[k] != print || !are_alike(tracks[k], track))) ++k;
    if (k == kinds.size()) {
      kinds.push_back({}), prints.push_back(print), tracks.push_back(std::move(track));
    }
    kinds[k].groups.push_back(g);
  }
  return kinds;
}

/// Removes what events are left without an object.
void remove_idle_events(World& world) {
  std::vector<Entity> idle;
  for (std::size_t i = 0; i < events_of(world).size(); ++i) {
    TimedEvent& event = events_of(world).values()[i];
    const auto is_idle = [&](auto& kind) {
      if constexpr (requires { kind.bodies; }) {
        if (kind.bodies.empty()) return false;
        std::erase_if(kind.bodies, [&](Entity e) { return !world.is_alive(e); });
        return kind.bodies.empty();
      }
      const Entity* on = target_of(kind);
      return on && *on && !world.is_alive(*on);
    };
    if (std::visit(is_idle, event.kind)) idle.push_back(events_of(world).owners()[i]);
  }
  world.destroy(idle);
}

}  // namespace

Grouping groups_of(const Scene& scene, const Sampling& sampling, double seconds) {
  constexpr std::size_t kMostGroups = 1000;
  Grouping all;
  for (const Body& b : scene.world.bodies.values()) all.kinematic += b.motion == Motion::kinematic;
  Meetings meetings(scene.world);
  Trial trial{&scene, std::min(scene.step, sampling.interval), 0, sampling};
  trial.step = sampling.interval / std::max(1.0, std::round(sampling.interval / trial.step));
  trial.look = [&](const World& world, const StepReport&) { meetings.look(world); };
  const double until = wall_seconds() + seconds;
  trial.stop = [&](double) { return wall_seconds() > until; };
  const Outcome own = run_motion(trial);
  all.groups = list_groups(scene.world, meetings);
  if (own.is_ok() && !has_solver_events(scene.world) && all.groups.size() <= kMostGroups) {
    all.kinds = list_kinds(scene, all.groups, own.track);
    return all;
  }
  Group whole;
  for (const Group& g : all.groups) {
    whole.bodies.insert(whole.bodies.end(), g.bodies.begin(), g.bodies.end());
    whole.islands += g.islands, whole.has_laminas = whole.has_laminas || g.has_laminas;
  }
  all.groups = {std::move(whole)}, all.kinds = {GroupKind{{0}}};
  return all;
}

Scene part_of(const Scene& scene, const Group& group) {
  Scene part = scene;
  const std::unordered_set<Entity> own(group.bodies.begin(), group.bodies.end());
  std::vector<Entity> others;
  for (const Entity e : scene.world.bodies.owners())
    if (scene.world.bodies[e].motion == Motion::dynamic && !own.contains(e)) others.push_back(e);
  part.world.destroy(others);
  remove_idle_events(part.world);
  return part;
}

Loaded load_part(const Scene& part, const Method& method) {
  Loaded loaded{method, part, {}};
  World& world = loaded.scene->world;
  method.choices.apply(world.default_settings);
  for (SolverSettings& s : world.settings.values()) method.choices.apply(s);
  world.mark_dirty();
  const auto refuse = [&](std::string why) {
    loaded.refusal = std::move(why), loaded.scene.reset();
    return loaded;
  };
  if (method.choices.solver == Solver::planar) {
    if (!has_planar_solver()) return refuse("this build of pantin was made without Box2D");
    for (const IslandPlan& island : find_islands(world)) {
      const Entity first = world.bodies.owners()[island.slots.front()];
      if (const std::string why = plane_fault(world, first); !why.empty())
        return refuse(fmt::format("{} {}", world.name_of(first), why));
    }
  }
  if (const auto open = settle("", *loaded.scene); !open.empty())
    return refuse(open.front().message);
  for (const StructureFault& f : partition_of(world).faults)
    if (!f.is_minor && method.choices.solver)
      return refuse(fmt::format("{} {}", world.name_of(f.link), f.reason));
  return loaded;
}

void apply_method(World& world, const Group& group, const Method& method, double tolerance) {
  SolverChoices choices = method.choices;
  if (tolerance > 0) choices.step_tolerance = tolerance;
  const std::unordered_set<Entity> own(group.bodies.begin(), group.bodies.end());
  for (const IslandPlan& island : find_islands(world)) {
    const Entity first = world.bodies.owners()[island.slots.front()];
    if (!own.contains(first)) continue;
    bool any = false;
    for (const std::uint32_t slot : island.slots)
      if (SolverSettings* s = world.settings.find(world.bodies.owners()[slot]))
        choices.apply(*s), any = true;
    if (any || !choices.solver) continue;
    choices.apply(world.settings.add(first, world.default_settings));
  }
  world.mark_dirty();
}

Track track_of(const Track& whole, const World& world, const Group& group) {
  const std::unordered_set<Entity> own(group.bodies.begin(), group.bodies.end());
  std::vector<std::size_t> columns;
  Track track;
  std::size_t column = 0;
  for (const Entity e : world.bodies.owners()) {
    if (world.bodies[e].motion != Motion::dynamic) continue;
    if (own.contains(e)) {
      columns.push_back(column), track.names.push_back(whole.names[column]);
      track.centres.push_back(whole.centres[column]), track.radii.push_back(whole.radii[column]);
    }
    ++column;
  }
  for (std::size_t s = 0; s < whole.samples(); ++s)
    for (const std::size_t c : columns) track.poses.push_back(whole.poses[s * column + c]);
  track.energies = whole.energies, track.steps = whole.steps, track.between = whole.between;
  return track;
}

double extent_of(const World& world, const Group& group) {
  Aabb box;
  for (const Entity e : group.bodies) box.add(bounds_of_body(world, e));
  const double extent = glm::length(box.high - box.low);
  return std::isfinite(extent) && extent > 0 ? extent : 0;
}

}  // namespace pantin::program
