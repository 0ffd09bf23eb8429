#include "engine/world/world.hpp"

#include <unordered_set>

#include "engine/geometry/surface.hpp"

namespace pantin {
namespace {

void set_name(World& world, Entity e, std::string name) {
  if (!name.empty()) world.names.add(e, std::move(name));
}

}  // namespace

Entity World::add_body(const Body& body, std::string name) {
  const Entity e = create();
  bodies.add(e, body);
  set_name(*this, e, std::move(name));
  return e;
}

Entity World::add_link(Entity a, Entity b, const Joint& joint, std::string name) {
  const Entity e = create();
  links.add(e, {a, b, joint});
  set_name(*this, e, std::move(name));
  return e;
}

Entity World::add_string(Entity a, Entity b, const StringJoint& joint, std::string name) {
  const Entity e = create();
  strings.add(e, {a, b, joint});
  set_name(*this, e, std::move(name));
  return e;
}

Entity World::add_ratio(const Ratio& ratio, std::string name) {
  const Entity e = create();
  ratios.add(e, ratio);
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
  add_orphans(strings, [&](const String& s) { return refers(s.a) || refers(s.b); });
  add_orphans(pins, [&](const Pin& p) { return refers(p.body) || refers(p.to); });
  for (const Entity e : std::vector<Entity>(all)) gone.insert(e);  // ratios tie links
  add_orphans(ratios, [&](const Ratio& r) { return refers(r.first) || refers(r.second); });
  // Handles are freed in order of index, so that the next ones do not depend on a hash order.
  std::sort(all.begin(), all.end(), [](Entity a, Entity b) { return a.index > b.index; });

  bodies.remove(all), forces.remove(all), origins.remove(all), shapes.remove(all);
  links.remove(all), strings.remove(all), ratios.remove(all), pins.remove(all), drives.remove(all);
  pose_drives.remove(all), collisions.remove(all);
  names.remove(all), settings.remove(all), user.remove(all);
  for (Entity e : all) entities.destroy(e);
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

void add_articulation(Hash& hash, const Articulation& a) {
  for (Real number : a.constants.numbers()) hash.add(number);
  for (Real number : a.memory.numbers()) hash.add(number);
  for (std::int32_t parent : a.parents) hash.add(parent);
  for (const Tree& t : a.trees) hash.add(t.target), hash.add(t.spin_momentum);
  for (const PackedJoint& j : a.joints) {
    for (Real load : j.loads) hash.add(load);
    hash.add(j.share);
  }
  for (const Hold& h : a.holds) hash.add(h.target), hash.add(h.load), hash.add(h.gap_before);
  for (const Cord& c : a.cords) hash.add(c.load);
  hash.add(a.still_for), hash.add(a.resting), hash.add(a.resting_in);
  hash.add(a.iterating), hash.add(a.calm_steps), hash.add(a.fresh), hash.add(a.last_step);
  hash.add(a.reserve), hash.add(a.driven), hash.add(a.aimed);
}

void add_mechanism(Hash& hash, const Mechanism& m) {
  for (const BlockMemory& b : m.memory)
    hash.add(b.before[0]), hash.add(b.before[1]), hash.add(b.active);
  for (Real load : m.loads) hash.add(load);
  for (const auto* list : {&m.accelerations, &m.lagged, &m.owed})
    for (Vec3 v : *list) hash.add(v);
  for (const Effort& e : m.efforts) hash.add(e.before);
  for (const Hanging& h : m.hangings) hash.add(h.force), hash.add(h.asked), hash.add(h.debt);
  hash.add(m.fresh), hash.add(m.try_step), hash.add(m.rescues);
}

void add_settings(Hash& hash, const SolverSettings& s) {
  hash.add(static_cast<std::uint32_t>(s.solver)), hash.add(s.turn_stiffness);
  hash.add(s.calm_angle), hash.add(s.reservoir_time), hash.add(s.rounds), hash.add(s.tolerance);
  hash.add(s.rest_speed), hash.add(s.passes), hash.add(s.stall_drop), hash.add(s.tension_stiffness), hash.add(s.limiter);
  hash.add(static_cast<std::uint32_t>(s.paper_reluctance));
  hash.add(static_cast<std::uint32_t>(s.integrator));
  hash.add(static_cast<std::uint32_t>(s.stabilisation));
  hash.add(s.baumgarte), hash.add(s.step_tolerance), hash.add(s.damping_ratio);
}

void add_freedom(Hash& hash, const Freedom& f) {
  hash.add(f.spring.stiffness), hash.add(f.spring.damping), hash.add(f.spring.rest);
  hash.add(f.friction.viscous), hash.add(f.friction.dry), hash.add(f.friction.slip);
  hash.add(static_cast<std::uint32_t>(f.motor.kind)), hash.add(f.motor.target);
  hash.add(f.motor.gain), hash.add(f.motor.damping), hash.add(f.motor.cap);
}

void add_joint(Hash& hash, const Joint& j) {
  if (j.extras.any()) {
    hash.add(j.extras->length), hash.add(j.extras->pitch);
    add_freedom(hash, j.extras->turn), add_freedom(hash, j.extras->slide);
    hash.add(j.extras->travel.on), hash.add(j.extras->travel.low), hash.add(j.extras->travel.high);
    hash.add(j.extras->restitution);
  }
  hash.add(j.anchor_a), hash.add(j.anchor_b);
  hash.add(static_cast<std::uint32_t>(j.kind));
  hash.add(j.frames.a()), hash.add(j.frames.b());
  if (!j.limits.any()) return;
  for (const AngleLimit& l : {j.limits->turn, j.limits->second})
    hash.add(l.on), hash.add(l.low), hash.add(l.high);
  hash.add(j.limits->swing.on), hash.add(j.limits->swing.y), hash.add(j.limits->swing.z);
  hash.add(j.limits->soft_zone), hash.add(j.limits->soft_stiffness);
  hash.add(j.limits->soft_damping);
}

void add_drive(Hash& hash, const PoseDrive& d) {
  hash.add(d.target);
  hash.add(d.stiffness), hash.add(d.damping), hash.add(d.max_torque), hash.add(d.loop);
  for (const PoseKey& key : d.keys) hash.add(key.time), hash.add(key.turn);
}

void add_surface(Hash& hash, const Surface& s) {
  hash.add(s.columns), hash.add(s.rows), hash.add(s.spacing_x), hash.add(s.spacing_z);
  for (Vec3 p : s.points) hash.add(p);
  for (std::uint32_t corner : s.corners) hash.add(corner);
}

/// What is solid, and what the contacts bore in the last step.
void add_contacts(Hash& hash, const World& world) {
  for (std::size_t i = 0; i < world.collisions.size(); ++i) {
    const Entity e = world.collisions.owners()[i];
    const Collision& c = world.collisions.values()[i];
    hash.add(e.index), hash.add(c.friction), hash.add(c.restitution);
    hash.add(c.groups), hash.add(c.with), hash.add(c.others), hash.add(c.self);
    const Shapes* shapes = world.shapes.find(e);
    if (!shapes) continue;
    for (const Shape& s : shapes->parts) {
      hash.add(static_cast<std::uint32_t>(s.kind)), hash.add(s.size), hash.add(s.local);
      if (s.surface) add_surface(hash, *s.surface);
    }
  }
  for (const Contact& c : world.contacts) {
    hash.add(c.slot_a), hash.add(c.slot_b), hash.add(c.key);
    hash.add(c.load), hash.add(c.sliding), hash.add(c.impact);
  }
}

void add_path(Hash& hash, const Keyframes& path) {
  hash.add(path.loop);
  for (const Keyframe& key : path.keys) hash.add(key.time), hash.add(key.pose);
}

void add_path(Hash& hash, const Lissajous& path) {
  hash.add(path.centre);
  hash.add(path.amplitude), hash.add(path.frequency), hash.add(path.phase);
  hash.add(path.turn_amplitude), hash.add(path.turn_frequency), hash.add(path.turn_phase);
  hash.add(path.rise), hash.add(path.axes);
}

}  // namespace

std::uint64_t state_hash(const World& world) {
  Hash hash;
  hash.add(world.tick), hash.add(world.time), hash.add(world.gravity);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const Body& b = world.bodies.values()[i];
    hash.add(world.bodies.owners()[i].index);
    hash.add(b.pose), hash.add(b.velocity), hash.add(b.spin);
    hash.add(b.mass), hash.add(b.inertia), hash.add(b.drag), hash.add(b.gravity_scale);
    hash.add(static_cast<std::uint32_t>(b.motion)), hash.add(b.restart);
  }
  for (std::size_t i = 0; i < world.forces.size(); ++i) {
    const Force& f = world.forces.values()[i];
    hash.add(world.forces.owners()[i].index), hash.add(f.force), hash.add(f.torque);
  }
  for (std::size_t i = 0; i < world.drives.size(); ++i) {
    hash.add(world.drives.owners()[i].index);
    std::visit([&](const auto& path) { add_path(hash, path); }, world.drives.values()[i].path);
  }
  add_settings(hash, world.default_settings);
  for (std::size_t i = 0; i < world.settings.size(); ++i) {
    hash.add(world.settings.owners()[i].index);
    add_settings(hash, world.settings.values()[i]);
  }
  for (const Link& l : world.links.values())
    hash.add(l.a.index), hash.add(l.b.index), add_joint(hash, l.joint);
  for (const Ratio& r : world.ratios.values()) {
    hash.add(r.first.index), hash.add(r.second.index);
    hash.add(r.slides_first), hash.add(r.slides_second);
    hash.add(r.ratio), hash.add(r.offset), hash.add(r.has_offset);
  }
  for (std::size_t i = 0; i < world.pose_drives.size(); ++i) {
    hash.add(world.pose_drives.owners()[i].index);
    add_drive(hash, world.pose_drives.values()[i]);
  }
  add_contacts(hash, world);
  for (const String& s : world.strings.values()) {
    hash.add(s.a.index), hash.add(s.b.index), hash.add(s.joint.anchor_a),
        hash.add(s.joint.anchor_b);
    hash.add(s.joint.length), hash.add(s.joint.compliance);
  }
  for (const Pin& p : world.pins.values()) {
    hash.add(p.body.index), hash.add(p.to.index), hash.add(p.anchor), hash.add(p.target), hash.add(p.priority);
    hash.add(static_cast<std::uint32_t>(p.grip)), hash.add(p.stiffness);
  }
  for (const Articulation& a : world.articulations) add_articulation(hash, a);
  for (const Mechanism& m : world.mechanisms) add_mechanism(hash, m);
  world.user.add_to(hash);
  return hash.value();
}

}  // namespace pantin
