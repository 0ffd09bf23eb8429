#include "tools/peers/bodies/plain.hpp"

#include <algorithm>
#include <cctype>
#include <iomanip>
#include <string>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/partition.hpp"

namespace pantin::peers {
namespace {

using detail::JointKind;

std::ostream& operator<<(std::ostream& out, const Vec3& v) {
  return out << ' ' << v.x << ' ' << v.y << ' ' << v.z;
}
std::ostream& operator<<(std::ostream& out, const Quat& q) {
  return out << ' ' << q.x << ' ' << q.y << ' ' << q.z << ' ' << q.w;
}
std::ostream& operator<<(std::ostream& out, const Pose& p) {
  return out << p.position << p.rotation;
}

/// A name without gaps.
std::string word_of(std::string name) {
  for (char& c : name)
    if (std::isspace(static_cast<unsigned char>(c))) c = '_';
  return name.empty() ? "-" : name;
}

/// By the rules of Collision, whatever joints say.
bool may_touch(const World& world, std::uint32_t a, std::uint32_t b) {
  const auto owners = world.bodies.owners();
  const auto bodies = world.bodies.values();
  const Collision* one = world.collisions.find(owners[a]);
  const Collision* two = world.collisions.find(owners[b]);
  if (!one || !two || one->sensor || two->sensor || !do_groups_agree(*one, *two)) return false;
  const bool moves_a = bodies[a].motion == Motion::dynamic;
  const bool moves_b = bodies[b].motion == Motion::dynamic;
  if (!moves_a || !moves_b) return moves_a || moves_b;
  const auto& island = detail::partition_of(world).island;
  return island[a] == island[b] ? one->self && two->self : one->others || two->others;
}

void write_shapes(const World& world, Entity body, std::ostream& out) {
  const Shapes* shapes = world.shapes.find(body);
  if (!shapes || !world.collisions.find(body)) return;
  for (const Shape& shape : shapes->list) {
    const std::string kind(detail::name_of(shape.kind));
    using enum ShapeKind;
    constexpr ShapeKind kOthersLack[] = {mesh, height_field, cone, ellipsoid};
    if (std::find(std::begin(kOthersLack), std::end(kOthersLack), shape.kind) !=
        std::end(kOthersLack)) {
      out << "unknown shape " << kind << '\n';
      continue;
    }
    out << "shape " << kind << shape.size << shape.local;
    if (shape.surface)
      for (const Vec3& p : shape.surface->points) out << p;
    out << '\n';
  }
}

void write_body(const World& world, std::uint32_t slot, int layer, std::ostream& out) {
  static constexpr const char* kMotions[] = {"dynamic", "fixed", "kinematic"};
  const Body& b = world.bodies.values()[slot];
  const Entity entity = world.bodies.owners()[slot];
  const Collision* collision = world.collisions.find(entity);
  out << "body " << word_of(world.name_of(entity)) << ' ' << kMotions[static_cast<int>(b.motion)]
      << ' ' << layer << ' ' << b.mass << b.inertia << b.pose << b.velocity << b.angular_velocity
      << ' ' << b.drag << ' ' << b.gravity_scale << ' ' << (collision ? collision->friction : 0)
      << ' ' << (collision ? collision->restitution : 0) << '\n';
  write_shapes(world, entity, out);
}

void write_angle(const detail::AngleLimit& limit, std::ostream& out) {
  out << ' ' << limit.on << ' ' << limit.low << ' ' << limit.high;
}

int slot_of(const World& world, Entity body) {
  const std::uint32_t slot = world.bodies.slot(body);
  return slot == kNoSlot ? -1 : static_cast<int>(slot);
}

void write_drive(const JointDrive& drive, int joint, int frames, std::ostream& out) {
  const int count = drive.keys.empty() ? 1 : frames;
  out << "drive " << joint << ' ' << drive.stiffness << ' ' << drive.damping << ' '
      << std::min(drive.max_torque, 1e30) << ' ' << count;
  for (int i = 0; i < count; ++i) out << target_at(drive, Real(i + 1) / kFramesPerSecond);
  out << '\n';
}

void write_links(const World& world, int frames, std::ostream& out) {
  int number = 0;
  for (std::size_t i = 0; i < world.links.size(); ++i) {
    const detail::Link& link = world.links.values()[i];
    const detail::Joint& joint = link.joint;
    const std::string kind = name_of(joint.kind);
    const JointKind known[] = {JointKind::ball, JointKind::hinge, JointKind::universal,
                               JointKind::fixed};
    if (std::find(std::begin(known), std::end(known), joint.kind) == std::end(known)) {
      out << "unknown joint " << kind << '\n';
      continue;
    }
    if (joint.parameters->rotation.any() || joint.parameters->translation.any())
      out << "unknown springs, friction and motors of a joint " << kind << '\n';
    out << "joint " << kind << ' ' << slot_of(world, link.a) << ' ' << slot_of(world, link.b)
        << joint.anchor_a << joint.anchor_b << joint.frames.a() << joint.frames.b();
    write_angle(joint.limits->angle, out), write_angle(joint.limits->second, out);
    const detail::SwingLimit& swing = joint.limits->swing;
    out << ' ' << swing.on << ' ' << swing.y << ' ' << swing.z << '\n';
    if (const JointDrive* drive = world.joint_drives.find(world.links.owners()[i]))
      write_drive(*drive, number, frames, out);
    ++number;
  }
}

void write_pins(const World& world, std::ostream& out) {
  for (const Pin& pin : world.pins.values()) {
    if (pin.kind == PinKind::spring) {
      out << "unknown spring pin\n";
      continue;
    }
    out << "joint ball " << slot_of(world, pin.to) << ' ' << slot_of(world, pin.body) << pin.target
        << pin.anchor << kIdentity << kIdentity << " 0 0 0 0 0 0 0 0 0\n";
  }
}

void write_paths(const World& world, int frames, std::ostream& out) {
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
    const Entity entity = world.bodies.owners()[slot];
    const KinematicPath* path = world.paths.find(entity);
    if (!path || world.bodies.values()[slot].motion != Motion::kinematic) continue;
    out << "path " << slot;
    for (int i = 1; i <= frames; ++i)
      out << pose_at(*path, world.time + Real(i) / kFramesPerSecond);
    out << '\n';
  }
}

}  // namespace

Layers layers_of(const World& world) {
  const auto count = static_cast<std::uint32_t>(world.bodies.size());
  Layers layers;
  layers.of.assign(count, -1);
  std::vector<std::uint32_t> first;                 // body of each layer
  std::vector<std::uint32_t> second;                // another one, or the same
  std::vector<std::vector<bool>> touches_of_first;  // by body
  for (std::uint32_t a = 0; a < count; ++a) {
    if (!world.collisions.find(world.bodies.owners()[a])) continue;
    std::vector<bool> touches(count);
    for (std::uint32_t b = 0; b < count; ++b) touches[b] = b != a && may_touch(world, a, b);
    if (std::find(touches.begin(), touches.end(), true) == touches.end()) continue;
    std::size_t layer = 0;
    const auto equal = [&](std::size_t i) {
      const std::uint32_t other = first[i];
      for (std::uint32_t b = 0; b < count; ++b)
        if (b != a && b != other && touches[b] != touches_of_first[i][b]) return false;
      return true;
    };
    while (layer < first.size() && !equal(layer)) ++layer;
    if (layer == first.size())
      first.push_back(a), second.push_back(a), touches_of_first.push_back(touches);
    else
      second[layer] = a;
    layers.of[a] = static_cast<int>(layer);
  }
  layers.touch.assign(first.size(), std::vector<bool>(first.size()));
  for (std::size_t i = 0; i < first.size(); ++i)
    for (std::size_t k = 0; k < first.size(); ++k)
      layers.touch[i][k] = touches_of_first[i][i == k ? second[i] : first[k]];
  return layers;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> jointed_pairs(const World& world) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const detail::Link& link : world.links.values()) {
    const std::uint32_t a = world.bodies.slot(link.a), b = world.bodies.slot(link.b);
    if (a != kNoSlot && b != kNoSlot) pairs.emplace_back(std::min(a, b), std::max(a, b));
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void write_plain(const World& world, int frames, std::ostream& out) {
  const Layers layers = layers_of(world);
  out << std::setprecision(17) << "gravity" << world.gravity << "\nframes " << frames << "\nlayers "
      << layers.touch.size() << '\n';
  for (const std::vector<bool>& row : layers.touch) {
    for (const bool touches : row) out << touches << ' ';
    out << '\n';
  }
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot)
    write_body(world, slot, layers.of[slot], out);
  write_links(world, frames, out);
  write_pins(world, out);
  for (const detail::Cable& cable : world.cables.values())
    out << "cable " << slot_of(world, cable.a) << ' ' << slot_of(world, cable.b)
        << cable.joint.anchor_a << cable.joint.anchor_b << ' ' << cable.joint.length << ' '
        << cable.joint.compliance << '\n';
  if (!world.gears.empty()) out << "unknown gears\n";
  write_paths(world, frames, out);
}

}  // namespace pantin::peers
