#include "engine/world/world.hpp"

#include <unordered_set>

#include "engine/geometry/surface.hpp"

namespace pantin {

using namespace detail;

namespace {

void set_name(World& world, Entity e, std::string name) {
  if (!name.empty()) world.names.add(e, std::move(name));
}

}  // namespace

// Defined here; otherwise the compiler emits them in every unit that copies a World.
World::World() = default;
World::World(const World&) = default;
World::World(World&&) noexcept = default;
World& World::operator=(const World&) = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

Entity World::add_body(const Body& body, std::string name) {
  const Entity e = create();
  bodies.add(e, body);
  set_name(*this, e, std::move(name));
  return e;
}

Entity World::add_pin(const Pin& pin, std::string name) {
  const Entity e = create();
  pins.add(e, pin);
  set_name(*this, e, std::move(name));
  return e;
}

void World::destroy(std::span<const Entity> doomed) {
  std::unordered_set<Entity> gone;
  for (Entity e : doomed)
    if (is_alive(e)) gone.insert(e);
  std::vector<Entity> all(gone.begin(), gone.end());
  const auto refers = [&](Entity e) { return gone.contains(e); };
  const auto add_orphans = [&](const auto& store, const auto& is_orphan) {
    for (std::size_t i = 0; i < store.size(); ++i)
      if (is_orphan(store.values()[i]) && !refers(store.owners()[i]))
        all.push_back(store.owners()[i]);
  };
  add_orphans(links, [&](const Link& l) { return refers(l.a) || refers(l.b); });
  add_orphans(cables, [&](const Cable& s) {
    return refers(s.a) || refers(s.b) ||
           std::any_of(s.guides.begin(), s.guides.end(),
                       [&](const CableGuide& g) { return refers(g.body); });
  });
  add_orphans(surface_contacts,
              [&](const SurfaceContact& c) { return refers(c.a) || refers(c.b); });
  add_orphans(belts, [&](const Belt& belt) {
    return std::any_of(belt.pulleys.begin(), belt.pulleys.end(),
                       [&](const BeltPulley& p) { return refers(p.body); });
  });
  add_orphans(pins, [&](const Pin& p) { return refers(p.body) || refers(p.to); });
  for (const Entity e : std::vector<Entity>(all)) gone.insert(e);  // gears depend on links
  add_orphans(gears, [&](const Gear& r) { return refers(r.first) || refers(r.second); });
  // Handles are freed in order of index, so that the next ones do not depend on the order of a hash
  // set.
  std::sort(all.begin(), all.end(), [](Entity a, Entity b) { return a.index > b.index; });

  for_each_store(*this, [&](auto& store) { store.remove(all); });
  user.remove(all);
  for (Entity e : all) entities.destroy(e);
}

std::uint64_t World::structure() const {
  std::uint64_t sum = edit_count;
  for_each_structural_store(*this, [&](const auto& store) { sum += store.version(); });
  return sum;
}

bool World::teleport(Entity body, const Pose& pose) {
  Body* b = bodies.find(body);
  if (!b) return false;
  b->pose = pose;
  b->restart = b->teleport = true;
  return true;
}

bool World::push(Entity body, Vec3 force, Vec3 point) {
  const Body* b = bodies.find(body);
  if (!b) return false;
  Force* f = forces.find(body);
  if (!f) f = &forces.add(body, {});
  f->force += force;
  f->torque += glm::cross(point - b->pose.position, force);
  return true;
}

std::string World::name_of(Entity e) const {
  if (const std::string* name = names.find(e)) return *name;
  std::string number = std::to_string(e.index);
  number.insert(number.begin(), '#');
  return number;
}

Entity World::find(std::string_view name) const {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names.values()[i] == name) return names.owners()[i];
  return {};
}

Pose World::origin_pose(Entity body) const {
  const Pose* origin = origins.find(body);
  return origin ? compose(bodies[body].pose, *origin) : bodies[body].pose;
}

namespace {

/// Hashes the shapes of colliders, and their materials if pairs of materials have properties.
void add_solids(Hash& hash, const World& world) {
  for (const Entity e : world.collisions.owners())
    if (const Shapes* shapes = world.shapes.find(e)) {
      hash_fields(hash, *shapes);
      if (!world.material_pairs.empty())
        for (const Shape& shape : shapes->list) hash.add(shape.material);
    }
}

}  // namespace

std::uint64_t state_hash(const World& world) {
  Hash hash;
  const EntityRule rule{world.entities};
  hash_fields(hash, world, rule);
  add_solids(hash, world);
  world.memory.add_to(hash, rule);
  world.user.add_to(hash, rule);
  return hash.value();
}

}  // namespace pantin
