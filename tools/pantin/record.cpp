#include "tools/pantin/record.hpp"

#include <fmt/core.h>

#include <unordered_map>

#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// A name as a CSV field, quoted if necessary.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

void add_vec(std::string& row, Vec3 v) { row += fmt::format(",{},{},{}", v.x, v.y, v.z); }

}  // namespace

Result<Done> Record::open(const std::string& path, const World& world) {
  if (auto opened = file_.open(path); !opened) return opened;
  const auto kept = [](const auto& owners) {
    return std::vector<Entity>(owners.begin(), owners.end());
  };
  bodies_ = kept(world.bodies.owners()), links_ = kept(world.links.owners());
  exact_links_.clear();
  std::string row = "time_s";
  for (Entity e : bodies_)
    for (const char* what :
         {"x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz"})
      row += ',' + field(world.name_of(e) + '.' + what);
  for (Entity e : links_) row += ',' + field(world.name_of(e) + ".gap_m");
  row += ",kinetic_j,potential_j,energy_j,px,py,pz,lx,ly,lz";
  World built = world;
  compile_if_changed(built);
  exact_ = !lagrangian::islands_of(built).empty();
  for (const lagrangian::Island& m : lagrangian::islands_of(built))
    for (const lagrangian::Block& b : m.blocks)
      if (b.kind == lagrangian::BlockKind::joint)
        exact_links_.push_back(lagrangian::joint_of(built, b));
  for (Entity e : exact_links_)
    for (const char* what : {"fx", "fy", "fz", "tx", "ty", "tz"})
      row += ',' + field(built.name_of(e) + '.' + what);
  row += exact_ ? ",elastic_j,rows,rank,rescued\n" : "\n";
  return file_.write(row);
}

void Record::add_bodies(std::string& row, const World& world) const {
  for (const Entity e : bodies_) {
    const Body* b = world.bodies.find(e);
    if (!b) {
      row.append(13, ',');
      continue;
    }
    const Pose at = world.origin_pose(e);
    add_vec(row, at.position);
    add_vec(row, Vec3(at.rotation.x, at.rotation.y, at.rotation.z));
    row += fmt::format(",{}", at.rotation.w);
    add_vec(row, b->velocity);
    add_vec(row, b->angular_velocity);
  }
}

void Record::add_gaps(std::string& row, const World& world) const {
  std::vector<Real> gaps;
  for (const Link& l : world.links.values())
    gaps.push_back(glm::length(residual(l.joint, world.bodies[l.a].pose, world.bodies[l.b].pose)));
  for (const lagrangian::Island& mechanism : lagrangian::islands_of(world))
    for (std::size_t i = 0; i < mechanism.blocks.size(); ++i)
      if (const lagrangian::Block& b = mechanism.blocks[i];
          b.kind == lagrangian::BlockKind::joint && b.source < gaps.size())
        gaps[b.source] = lagrangian::joint_gap(world, mechanism, i);
  for (const Entity e : links_) {
    const std::uint32_t slot = world.links.slot(e);
    row += slot == kNoSlot ? "," : fmt::format(",{}", gaps[slot]);
  }
}

void Record::add_islands(std::string& row, const World& world, const Measures& m) const {
  std::size_t rows = 0, rank = 0, rescued = 0;
  std::unordered_map<Entity, lagrangian::ConstraintWrench> wrenches;
  for (const lagrangian::Island& mechanism : lagrangian::islands_of(world)) {
    rows += mechanism.equations(), rank += mechanism.rank, rescued += mechanism.rescues > 0;
    for (std::size_t i = 0; i < mechanism.blocks.size(); ++i)
      if (mechanism.blocks[i].kind == lagrangian::BlockKind::joint)
        wrenches[lagrangian::joint_of(world, mechanism.blocks[i])] =
            lagrangian::joint_wrench(mechanism, i);
  }
  for (const Entity e : exact_links_) {
    const auto f = wrenches.find(e);
    if (f == wrenches.end())
      row.append(6, ',');
    else
      add_vec(row, f->second.force), add_vec(row, f->second.torque);
  }
  row += fmt::format(",{},{},{},{}", m.elastic, rows, rank, rescued);
}

Result<Done> Record::add(const World& world, const Measures& m) {
  std::string row = fmt::format("{}", world.time);
  add_bodies(row, world);
  add_gaps(row, world);
  row += fmt::format(",{},{},{}", m.kinetic, m.potential, m.energy());
  add_vec(row, m.momentum);
  add_vec(row, m.angular_momentum);
  if (exact_) add_islands(row, world, m);
  row += '\n';
  return file_.write(row);
}

Result<Done> Record::close() { return file_.commit(); }

}  // namespace pantin::program
