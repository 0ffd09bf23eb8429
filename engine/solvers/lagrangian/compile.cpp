#include <algorithm>
#include <array>

#include "engine/base/disjoint_sets.hpp"
#include "engine/joints/cable_path.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;

bool is_dynamic(const World& world, std::uint32_t slot) {
  return world.bodies.values()[slot].motion == Motion::dynamic;
}

/// The slots of a link's bodies; none where it cannot be used.
struct Ends {
  std::uint32_t a = kNobody, b = kNobody;
};
Ends ends_of(const World& world, Entity a, Entity b) {
  const Ends ends{world.bodies.slot(a), world.bodies.slot(b)};
  if (ends.a == kNoSlot || ends.b == kNoSlot || ends.a == ends.b) return {};
  return ends;
}

/// Lookup tables for packing islands.
struct Packer {
  World& world;
  Partition& partition;
  std::vector<Island>& islands;
  std::vector<std::uint32_t> owner;   // island, by slot
  std::vector<std::uint32_t> number;  // in it
};

std::uint32_t add_frame(Island& m, std::uint32_t slot, std::uint32_t pin) {
  for (std::size_t i = 0; i < m.frames.size() && pin == kNobody; ++i)
    if (m.frames[i].slot == slot && m.frames[i].is_body())
      return static_cast<std::uint32_t>(m.count() + i);
  Frame f;
  f.slot = slot, f.pin = pin;
  m.frames.push_back(f);
  return static_cast<std::uint32_t>(m.count() + m.frames.size() - 1);
}

/// The frame whose x is the length of a cable.
std::uint32_t add_winch(Island& m, std::uint32_t cable) {
  Frame f;
  f.cable = cable;
  m.frames.push_back(f);
  return static_cast<std::uint32_t>(m.count() + m.frames.size() - 1);
}

/// Why a blade or wheel with a coefficient of friction has no load.
constexpr const char* kNoCarrier =
    "needs exactly one joint that carries it: between its bodies, or a and a body joined to b";

/// A body's number in the island, as a frame if it is not its own.
std::uint32_t number_of(Packer& p, std::uint32_t island, std::uint32_t slot) {
  if (p.owner[slot] == island) return p.number[slot];
  return add_frame(p.islands[island], slot, kNobody);
}

void add_block(Island& m, Block block) {
  if (block.rows == 0) return;
  block.first_row = static_cast<std::uint32_t>(m.rows);
  block.first_vector = static_cast<std::uint32_t>(m.vectors);
  m.rows += block.rows;
  m.vectors += vectors_of(block);
  m.blocks.push_back(block);
}

/// Elastic elements between two bodies are forces. Integrators that need their slopes have rows for
/// them, too.
void add_compliant_block(Island& m, Block block) {
  if (!row_of(m.settings.integrator).collocates) return;
  block.point = false;
  m.joint_force_rows += block.rows;
  add_block(m, block);
}

/// One side of a limited coordinate, in m or rad: the lower one, the upper one, or a lock.
struct LimitSide {
  Coordinate which = Coordinate::angle;
  Real bound = 0;
  bool upper = false, lock = false;
};

void add_limits(Island& m, const Joint& joint, Block block) {
  block.kind = BlockKind::limit, block.rows = 1, block.point = false;
  const auto add = [&](const LimitSide& side) {
    block.coordinate = side.which, block.bound = side.bound;
    block.upper = side.upper, block.lock = side.lock;
    add_block(m, block);
    m.unilateral = true;
  };
  const auto add_range = [&](Coordinate which, const AngleLimit& range) {
    if (!range.on) return;
    if (range.low == range.high) return add({.which = which, .bound = range.low, .lock = true});
    add({.which = which, .bound = range.low});
    add({.which = which, .bound = range.high, .upper = true});
  };
  add_range(Coordinate::angle, joint.limits->angle);  // of custom kinds too
  for (const FreeCoordinate& c : info_of(joint.kind).coordinates) {
    if (c.limit.empty()) continue;
    if (c.which == Coordinate::second) add_range(c.which, joint.limits->second);
    if (c.which == Coordinate::travel) add_range(c.which, joint.parameters->travel);
    if (c.which == Coordinate::swing && joint.limits->swing.on) add({.which = c.which});
  }
}

void pack_joint_forces(Island& m, const Joint& joint, Block block) {
  const auto add = [&](Coordinate which, const Dof& dof) {
    if (!dof.any()) return;
    JointForce e;
    e.link = block.source, e.body[0] = block.body[0], e.body[1] = block.body[1];
    e.coordinate = which;
    m.joint_forces.push_back(e);
    m.damped = true;
    ++m.joint_force_rows;
    block.kind = BlockKind::spring, block.rows = 1, block.point = false;
    block.coordinate = which;
    add_block(m, block);
  };
  add(Coordinate::angle, joint.parameters->rotation),
      add(Coordinate::travel, joint.parameters->translation);
}

/// Adds the exact drive of a joint: a row with a frame whose x is the coordinate.
void add_exact_drive(Island& m, const World& world, Block block) {
  const Entity owner = world.links.owners()[block.source];
  Frame f;
  f.drive = world.joint_drives.slot(owner);
  m.frames.push_back(f);
  block.kind = BlockKind::drive, block.rows = 1, block.point = false;
  block.coordinate =
      world.joint_drives[owner].motion.travels ? Coordinate::travel : Coordinate::angle;
  block.body[block.count++] = static_cast<std::uint32_t>(m.count() + m.frames.size() - 1);
  add_block(m, block);
  m.driven = m.damped = true;
}

/// Adds a joint that constrains velocities only.
void add_slip(Island& m, const Joint& joint, Block block) {
  const Real grip = joint.parameters->grip, friction = joint.parameters->friction;
  block.holonomic = false, block.lock = !(grip > 0 || friction > 0);
  block.bound = friction > 0 ? friction : grip;
  m.rolls = true;
  if (may_slip(block)) m.unilateral = m.rubs = m.damped = true, ++m.slips;
  add_block(m, block);
}

void pack_links(Packer& p) {
  World& world = p.world;
  for (std::uint32_t i = 0; i < world.links.size(); ++i) {
    const Link& link = world.links.values()[i];
    const Ends ends = ends_of(world, link.a, link.b);
    if (ends.a == kNobody) continue;  // reported by the articulated solver
    const std::uint32_t at = p.owner[ends.a] != kNobody ? p.owner[ends.a] : p.owner[ends.b];
    if (at == kNobody) continue;
    Island& m = p.islands[at];
    if (const char* reason = info_of(link.joint.kind).fault(link.joint)) {
      p.partition.faults.push_back(
          {world.links.owners()[i], reason, StructureFault::left_out, false});
      continue;
    }
    Block block;
    block.rows = static_cast<std::uint8_t>(row_count(link.joint));
    block.source = i, block.count = 2, block.point = holds_point(link.joint.kind);
    block.body[0] = number_of(p, at, ends.a), block.body[1] = number_of(p, at, ends.b);
    if (info_of(link.joint.kind).binds_poses())
      add_block(m, block);
    else
      add_slip(m, link.joint, block);
    add_limits(m, link.joint, block);
    pack_joint_forces(m, link.joint, block);
    const JointDrive* drive = world.joint_drives.find(world.links.owners()[i]);
    if (drive && drive->exact) add_exact_drive(m, world, block);
    const bool is_soft = link.joint.limits->soft_zone > 0;
    if (!is_soft && !(drive && !drive->exact)) continue;
    m.joint_torques.push_back({i, {block.body[0], block.body[1]}}), m.damped = true;
    block.kind = BlockKind::joint_torque, block.rows = 3;
    add_compliant_block(m, block);
  }
}

void pack_pins(Packer& p) {
  World& world = p.world;
  for (std::uint32_t i = 0; i < world.pins.size(); ++i) {
    const Pin& pin = world.pins.values()[i];
    const std::uint32_t slot = world.bodies.slot(pin.body);
    const std::uint32_t to = pin.to ? world.bodies.slot(pin.to) : kNoSlot;
    if (slot == kNoSlot || (pin.to && (to == kNoSlot || to == slot))) continue;
    const std::uint32_t at = p.owner[slot] != kNobody ? p.owner[slot]
                             : to != kNoSlot          ? p.owner[to]
                                                      : kNobody;
    if (at == kNobody) continue;
    Island& m = p.islands[at];
    Block block;
    block.kind = BlockKind::pin, block.source = i, block.rows = 3, block.count = 2;
    block.point = true;
    block.body[0] = number_of(p, at, slot);
    block.body[1] = to != kNoSlot ? number_of(p, at, to) : add_frame(m, kNobody, i);
    if (pin.kind == PinKind::exact) {
      add_block(m, block);
      continue;
    }
    m.elastic_pins.push_back({i, {block.body[0], block.body[1]}});
    m.damped = m.damped || pin.damping > 0, block.kind = BlockKind::elastic_pin;
    add_compliant_block(m, block);
  }
}

/// Packs a cable over guides, from a to b; leaves it out if a body is missing or of another solver.
void pack_cable_path(Packer& p, std::uint32_t source) {
  const World& world = p.world;
  const Cable& cable = world.cables.values()[source];
  std::vector<std::uint32_t> slots{world.bodies.slot(cable.a)};
  for (const CableGuide& g : cable.guides) slots.push_back(world.bodies.slot(g.body));
  slots.push_back(world.bodies.slot(cable.b));
  std::uint32_t at = kNobody;
  for (const std::uint32_t slot : slots) {
    if (slot == kNoSlot || (p.owner[slot] == kNobody && is_dynamic(world, slot))) return;
    if (at == kNobody) at = p.owner[slot];
  }
  if (at == kNobody) return;
  Island& m = p.islands[at];
  Block block;
  block.kind = BlockKind::cable, block.source = source, block.rows = 1;
  block.first_place = static_cast<std::uint32_t>(m.places.size());
  for (const std::uint32_t slot : slots) {
    const std::uint32_t number = number_of(p, at, slot);
    const auto* found = std::find(block.body, block.body + block.count, number);
    if (found == block.body + kMostBlockBodies - 1 || slots.size() > kMostPathPoints) {
      m.places.resize(block.first_place);
      return p.partition.faults.push_back(
          {world.cables.owners()[source],
           "runs over more than 14 guides or along more than 7 bodies", StructureFault::left_out,
           false});
    }
    m.places.push_back(static_cast<std::uint8_t>(found - block.body));
    if (found == block.body + block.count) block.body[block.count++] = number;
  }
  if (cable.joint.compliance > 0) {
    m.elastic_paths.push_back(block);
    block.kind = BlockKind::elastic_cable;
    return add_compliant_block(m, block);
  }
  block.body[block.count++] = add_winch(m, source);
  add_block(m, block);
  m.unilateral = true;
}

void pack_cables(Packer& p) {
  World& world = p.world;
  for (std::uint32_t i = 0; i < world.cables.size(); ++i) {
    const Cable& s = world.cables.values()[i];
    if (!s.guides.empty()) {
      pack_cable_path(p, i);
      continue;
    }
    const Ends ends = ends_of(world, s.a, s.b);
    if (ends.a == kNobody) continue;
    const auto fits = [&](std::uint32_t slot) {
      return p.owner[slot] != kNobody || !is_dynamic(world, slot);
    };
    const std::uint32_t at = p.owner[ends.a] != kNobody ? p.owner[ends.a] : p.owner[ends.b];
    if (at == kNobody || !fits(ends.a) || !fits(ends.b)) continue;
    Island& m = p.islands[at];
    Block block;
    block.kind = BlockKind::cable, block.source = i, block.rows = 1, block.count = 2;
    block.body[0] = number_of(p, at, ends.a), block.body[1] = number_of(p, at, ends.b);
    if (s.joint.compliance > 0) {
      m.elastic_cables.push_back({i, {block.body[0], block.body[1]}});
      block.kind = BlockKind::elastic_cable;
      add_compliant_block(m, block);
      continue;
    }
    block.body[block.count++] = add_winch(m, i);
    add_block(m, block);
    m.unilateral = true;
  }
}

bool rubs(const SurfaceContact& c) {
  return c.friction >= 0 && c.motion != SurfaceMotion::rolling_without_spin &&
         !(c.motion == SurfaceMotion::sliding && c.friction == 0);
}

/// Adds one of the contact slots of two surfaces.
void add_spot(Island& m, const SurfaceContact& c, Block block) {
  block.first_place = static_cast<std::uint32_t>(m.touch_sources.size());
  m.touch_sources.push_back(block.source), m.touch_ways.emplace_back();
  m.touch_blocks.push_back(static_cast<std::uint32_t>(m.blocks.size()));
  add_block(m, block);
  if (c.motion == SurfaceMotion::sliding && !rubs(c)) return;
  block.kind = BlockKind::roll, block.rows = c.on_b.curve ? 1 : 2;
  if (c.motion == SurfaceMotion::rolling_without_spin && !c.on_b.curve) ++block.rows;
  block.holonomic = block.lock && !rubs(c) && c.on_a.curve && c.on_b.curve;
  block.lock = !rubs(c), block.bound = rubs(c) ? c.friction : 0;
  if (block.holonomic)
    m.touch_ways.back() = {std::make_shared<const nurbs::CurvePieces>(c.on_a.curve->curve()),
                           std::make_shared<const nurbs::CurvePieces>(c.on_b.curve->curve())};
  m.rolls = m.rolls || !block.holonomic;
  add_block(m, block);
}

/// Packs surface joints: the gap, and the rows of rolling.
void pack_surfaces(Packer& p) {
  const World& world = p.world;
  for (std::uint32_t i = 0; i < world.surface_contacts.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    const Ends ends = ends_of(world, c.a, c.b);
    if (ends.a == kNobody) continue;
    const std::uint32_t at = p.owner[ends.a] != kNobody ? p.owner[ends.a] : p.owner[ends.b];
    if (at == kNobody) continue;
    if (const char* why = c.restored()) {
      p.partition.faults.push_back(
          {world.surface_contacts.owners()[i], why, StructureFault::left_out, false});
      continue;
    }
    Island& m = p.islands[at];
    Block block;
    block.kind = BlockKind::surface, block.source = i, block.rows = 1, block.count = 2;
    block.lock = !c.lifts;
    block.body[0] = number_of(p, at, ends.a), block.body[1] = number_of(p, at, ends.b);
    m.unilateral = m.unilateral || c.lifts || rubs(c), m.rubs = m.rubs || rubs(c);
    m.damped = m.damped || rubs(c);
    for (std::uint8_t n = 0; n < c.spots; ++n) add_spot(m, c, block);
  }
}

bool fits_gear(const Joint& joint, Coordinate coupled) {
  return info_of(joint.kind).is_used(coupled, kGeared);
}

void pack_gears(Packer& p) {
  World& world = p.world;
  for (std::uint32_t i = 0; i < world.gears.size(); ++i) {
    const Gear& r = world.gears.values()[i];
    const Entity owner = world.gears.owners()[i];
    const Link *one = world.links.find(r.first), *two = world.links.find(r.second);
    if (!one || !two || r.first == r.second) {
      p.partition.faults.push_back({owner, "couples joints that do not exist or are the same",
                                    StructureFault::left_out, false});
      continue;
    }
    const Coordinate first = r.first_travels ? Coordinate::travel : Coordinate::angle;
    const Coordinate second = r.second_travels ? Coordinate::travel : Coordinate::angle;
    if (!fits_gear(one->joint, first) || !fits_gear(two->joint, second)) {
      p.partition.faults.push_back({owner,
                                    "couples a degree of freedom that the joint does not have",
                                    StructureFault::left_out, false});
      continue;
    }
    const Ends e1 = ends_of(world, one->a, one->b), e2 = ends_of(world, two->a, two->b);
    if (e1.a == kNobody || e2.a == kNobody) continue;
    std::uint32_t at = kNobody;
    for (std::uint32_t slot : {e1.a, e1.b, e2.a, e2.b})
      if (at == kNobody) at = p.owner[slot];
    if (at == kNobody) continue;  // of no island here: see list_faults
    Block block;
    block.kind = BlockKind::gear, block.source = i, block.rows = 1, block.bound = r.offset;
    block.coordinate = first, block.second = second;
    std::uint8_t* end = block.ends;
    for (std::uint32_t slot : {e1.a, e1.b, e2.a, e2.b}) {
      const std::uint32_t number = number_of(p, at, slot);
      const auto found = std::find(block.body, block.body + block.count, number);
      *end++ = static_cast<std::uint8_t>(found - block.body);
      if (found == block.body + block.count) block.body[block.count++] = number;
    }
    add_block(p.islands[at], block);
  }
}

void pack_belts(Packer& p) {
  World& world = p.world;
  for (std::uint32_t i = 0; i < world.belts.size(); ++i) {
    const Belt& belt = world.belts.values()[i];
    const std::size_t count = belt.pulleys.size();
    const std::size_t held = count >= 2 ? held_spans(world, belt) : 0;
    std::uint32_t at = kNobody;
    for (const BeltPulley& pulley : belt.pulleys)
      if (const std::uint32_t slot = world.bodies.slot(pulley.body);
          at == kNobody && slot != kNoSlot)
        at = p.owner[slot];
    for (std::uint32_t k = 0; k < held && at != kNobody; ++k) {
      const std::uint32_t a = world.bodies.slot(belt.pulleys[k].body),
                          b = world.bodies.slot(belt.pulleys[(k + 1) % count].body);
      if (a == kNoSlot || b == kNoSlot || a == b) continue;
      Block block;
      block.kind = BlockKind::belt, block.source = i, block.rows = 1, block.count = 2;
      block.first_place = k;
      block.body[0] = number_of(p, at, a), block.body[1] = number_of(p, at, b);
      add_block(p.islands[at], block);
    }
  }
}

/// Gives joints that may slip a place for their slip, after those of surfaces, and a carrier.
void number_slips(Packer& p, Island& m) {
  auto place = static_cast<std::uint32_t>(m.touch_sources.size());
  std::vector<Real> shares(m.blocks.size(), 0);
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    Block& b = m.blocks[i];
    if (b.kind != BlockKind::joint || !may_slip(b)) continue;
    b.first_place = place++;
    if (!(p.world.links.values()[b.source].joint.parameters->friction > 0)) continue;
    if (find_carrier(m, i))
      ++shares[b.carrier];
    else
      b.bound = 0, p.partition.faults.push_back({p.world.links.owners()[b.source], kNoCarrier,
                                                 StructureFault::left_out, false});
  }
  for (Block& b : m.blocks)
    if (b.carrier != UINT32_MAX) b.bound /= shares[b.carrier];
}

/// Whether blocks close a loop, through the ground too: rows may be dependent.
bool has_loops(const Island& m) {
  const auto ground = static_cast<std::uint32_t>(m.count());
  DisjointSets sets(m.count() + 1);
  for (const Block& b : m.blocks) {
    if (is_compliant(b.kind)) continue;
    if (b.kind == BlockKind::gear || b.kind == BlockKind::belt || b.kind == BlockKind::limit ||
        b.kind == BlockKind::roll || b.kind == BlockKind::drive)
      continue;  // rolling adds no second path between bodies
    const std::size_t bodies = b.kind == BlockKind::cable ? b.count - 1u : b.count;
    for (std::size_t k = 1; k < bodies; ++k) {
      const std::uint32_t one = std::min(b.body[0], ground), two = std::min(b.body[k], ground);
      if (sets.root(one) == sets.root(two)) return true;
      sets.join(one, two);
    }
  }
  return false;
}

}  // namespace

Entity joint_of(const World& world, const Block& block) {
  switch (block.kind) {
    case BlockKind::pin:
    case BlockKind::elastic_pin:
      return world.pins.owners()[block.source];
    case BlockKind::gear:
      return world.gears.owners()[block.source];
    case BlockKind::belt:
      return world.belts.owners()[block.source];
    case BlockKind::cable:
    case BlockKind::elastic_cable:
      return world.cables.owners()[block.source];
    case BlockKind::surface:
    case BlockKind::roll:
      return world.surface_contacts.owners()[block.source];
    case BlockKind::joint:
    case BlockKind::limit:
    case BlockKind::drive:
    case BlockKind::spring:
    case BlockKind::joint_torque:
      break;
  }
  return world.links.owners()[block.source];
}

void compile(World& world, std::span<const IslandPlan> plans) {
  std::vector<Island> before = std::move(islands_of(world));
  std::vector<Island>& islands = islands_of(world);
  islands.clear();
  Packer p{world, world.memory.of<Partition>(), islands, {}, {}};
  p.owner.assign(world.bodies.size(), kNobody), p.number = p.owner;
  for (const IslandPlan& plan : plans) {
    Island m;
    m.settings = plan.settings, m.unfit = plan.unfit;
    for (std::uint32_t slot : plan.slots) {
      p.owner[slot] = static_cast<std::uint32_t>(islands.size());
      p.number[slot] = static_cast<std::uint32_t>(m.count());
      p.partition.set_column(slot, p.number[slot]);
      const Body& b = world.bodies.values()[slot];
      m.bodies.push_back(world.bodies.owners()[slot]), m.slots.push_back(slot);
      m.mass.push_back(b.mass), m.inertia.push_back(b.inertia);
      m.drag.push_back(b.drag), m.gravity_scale.push_back(b.gravity_scale);
      m.damped = m.damped || b.drag != 0;
    }
    islands.push_back(std::move(m));
  }
  pack_links(p), pack_pins(p), pack_cables(p), pack_gears(p), pack_belts(p), pack_surfaces(p);
  const Meshes meshes(world, before);
  for (Island& m : islands) {
    count_pins(m), number_slips(p, m);
    m.loops = has_loops(m);
    carry_memory(world, meshes, before, m);
  }
  world.memory.of<Islands>().scratch.prepared = 0;
}

}  // namespace pantin::detail::lagrangian
