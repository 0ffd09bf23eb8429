#include "engine/runtime/save.hpp"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>
#include <tuple>
#include <utility>

#include "engine/base/archive.hpp"
#include "engine/base/atomic_file.hpp"
#include "engine/base/invariants.hpp"
#include "engine/base/utf8.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/check.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/solvers/takeover.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/requests.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin {

using namespace detail;

namespace {

constexpr std::uint64_t kMagic = 0x444c524f574e5450;  // "PTNWORLD", low byte first
constexpr std::uint32_t kVersion = 1;

/// Header of the file.
struct Header {
  std::uint64_t magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint64_t layout = 0;    // fields_fingerprint of the World
  std::uint64_t size = 0;      // of the rest of the file, bytes
  std::uint64_t checksum = 0;  // of the rest of the file

  static void fields(auto& self, auto&& field) {
    field("magic", self.magic);
    field("version", self.version);
    field("layout", self.layout);
    field("size", self.size);
    field("checksum", self.checksum);
  }
};

constexpr std::size_t kHeaderSize = 36;

void write_header(FieldWriter& to, const Header& header) {
  Header::fields(header, [&](const char*, const auto& number) { to.write(number); });
}

Header read_header(FieldReader& from) {
  Header header{0, 0, 0, 0, 0};
  Header::fields(header, [&](const char*, auto& number) { from.read(number); });
  return header;
}

std::uint64_t checksum(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return hash.value();
}

Error error(std::string_view stage, const std::string& what) {
  std::string line(stage);
  line += ": ";
  line += printable(what);
  return {line};
}

void write_user(FieldWriter& to, const UserStores& user, Saved* saved) {
  for (const auto& store : user.all()) {
    if (store->size() == 0) continue;
    const std::string name(store->name());
    if (store->fingerprint() == 0) {
      if (saved) saved->left_out.push_back(name);
      continue;
    }
    FieldWriter own;
    store->write(own);
    to.write(name), to.write(store->fingerprint()), to.write(own.bytes());
  }
  to.write(std::string());
}

/// Empty, or a description of the fault.
std::string read_user(FieldReader& from, World& world) {
  for (std::string name, bytes; from.ok();) {
    std::uint64_t fingerprint = 0;
    from.read(name);
    if (name.empty()) break;
    from.read(fingerprint), from.read(bytes);
    if (!from.ok()) break;
    AnyStore* store = world.user.find(name);
    if (!store) return "contains components " + name + ", name their type: load_world<T>(path)";
    if (store->fingerprint() != fingerprint)
      return "contains components " + name + ", whose fields differ from those of the program";
    FieldReader own(bytes);
    if (const char* why = store->read(own, world.entities)) return "component " + name + ' ' + why;
    if (!own.ok() || own.left() > 0) return "component " + name + ": " + own.fault();
  }
  return {};
}

/// Resolves slots and checks references between components; empty, or a description of the fault.
std::string check_components(World& world) {
  std::string wrong;
  World::fields(world, [&](const char* name, auto&& part) {
    unwrap(part, [&](Role, auto& member) {
      if constexpr (requires { member.restored(world.entities); })
        if (const char* why = member.restored(world.entities))
          wrong = std::string(name) + ' ' + why;
    });
  });
  for (const Shapes& shapes : world.shapes.values())
    for (const Shape& shape : shapes.list)
      if (shape.material >= world.materials.size())
        wrong = "shapes name a material that does not exist";
  for (const MaterialPair& pair : world.material_pairs)
    if (pair.a >= world.materials.size() || pair.b >= world.materials.size())
      wrong = "material_pairs name a material that does not exist";
  return wrong;
}

/// Checks what a step assumes of rotations and ranges; empty, or a description of the fault.
std::string check_numbers(const World& world) {
  for (const Body& b : world.bodies.values())
    if (!is_unit(b.pose)) return "bodies have a rotation that is not a unit quaternion";
  for (const Shapes& shapes : world.shapes.values())
    for (const Shape& shape : shapes.list)
      if (!is_unit(shape.local)) return "shapes have a rotation that is not a unit quaternion";
  for (const Link& link : world.links.values()) {
    if (!is_unit(link.joint.frames.a()) || !is_unit(link.joint.frames.b()))
      return "links have axes that are not unit quaternions";
    const JointLimits& limits = link.joint.limits;
    for (const AngleLimit* limit : {&limits.angle, &limits.second})
      if (limit->on && !is_range(limit->low, limit->high))
        return "links have limits whose low end is above the high one";
  }
  return {};
}

std::string check_contacts(const World& world, const std::vector<Contact>& contacts) {
  const Contact* before = nullptr;
  const auto order = [](const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); };
  for (const Contact& c : contacts) {
    if (c.slot_a >= world.bodies.size() || c.slot_b >= world.bodies.size())
      return "contacts name a body that does not exist";
    if (before && !(order(*before) < order(c))) return "contacts are out of order";
    if (!(is_finite(c.point_a) && is_finite(c.point_b) && is_finite(c.normal) &&
          is_unit(c.normal) && std::isfinite(c.gap) && c.friction >= 0 && c.restitution >= 0))
      return "contacts contain a number that is not finite or out of range";
    before = &c;
  }
  return {};
}

}  // namespace

namespace {

Result<std::string> bytes_of(World& current, Saved* saved) {
  FieldWriter payload;
  payload.write(current);
  if (!payload.unwritable().empty())
    return error("save_world",
                 "found a user-defined joint (CustomJoint), expected built-in kinds: only those "
                 "can be saved");
  write_user(payload, current.user, saved);
  current.memory.write(payload);
  Header header;
  header.layout = fields_fingerprint<World>();
  header.size = payload.bytes().size(), header.checksum = checksum(payload.bytes());
  FieldWriter whole;
  write_header(whole, header);
  whole.put(payload.bytes().data(), payload.bytes().size());
  return whole.take();
}

}  // namespace

Result<std::string> world_to_bytes(const World& world, Saved* saved) {
  World current = world;  // its islands match the components, as the next step would make them
  drop_strays(current), normalise_rotations(current);
  compile_if_changed(current);
  current.entities.write_out();
  World like;
  like.user = current.user;
  Result<std::string> bytes = bytes_of(current, saved);
  if (!bytes || world_from_bytes(*bytes, like)) return bytes;
  // The memory of solvers does not match components that were changed without mark_dirty().
  current.mark_dirty(), compile_if_changed(current);
  bytes = bytes_of(current, nullptr);
  const Result<World> read = world_from_bytes(*bytes, std::move(like), "save_world");
  if (!read) return read.errors();  // do not write a file that cannot be read
  return bytes;
}

Result<World> world_from_bytes(std::string_view bytes, World like, std::string_view stage) {
  FieldReader head(bytes.substr(0, kHeaderSize));
  const Header header = read_header(head);
  if (!head.ok() || header.magic != kMagic)
    return error(stage, "found no pantin file, expected a saved World");
  if (header.version != kVersion || header.layout != fields_fingerprint<World>())
    return error(stage, "found a World saved by another version of pantin, expected this one's");
  const std::string_view rest = bytes.substr(kHeaderSize);
  if (header.size != rest.size())
    return error(stage, "found " + std::to_string(rest.size()) +
                            " bytes after the header, expected " + std::to_string(header.size));
  if (header.checksum != checksum(rest))
    return error(stage, "found a wrong checksum, expected an unchanged file");

  FieldReader from(rest);
  World world;
  world.user = std::move(like.user);
  laminas_of(world), events_of(world), world.store<Impulse>(),
      world.store<IgnoredPair>();  // an internal type that is stored like user components
  from.read(world);
  if (!from.ok()) return error(stage, from.fault());
  if (std::string why = check_components(world); !why.empty()) return error(stage, why);
  if (std::string why = check_numbers(world); !why.empty()) return error(stage, why);
  if (std::string why = read_user(from, world); !why.empty()) return error(stage, why);
  // The partition is read first: the memory of each solver must match its islands.
  Memories first;
  first.of<Takeovers>();
  FieldReader ahead = from;
  first.read(ahead);
  world.memory.of<Partition>(), world.memory.of<Takeovers>() = first.of<Takeovers>();
  compile_if_changed(world);
  if (const char* why = world.memory.read(from)) return error(stage, why);
  if (!from.ok() || from.left() > 0) return error(stage, "memory " + from.fault());
  for (const std::vector<Contact>* list :
       {&contacts_of(std::as_const(world)), &resting_contacts_of(world)})
    if (std::string why = check_contacts(world, *list); !why.empty()) return error(stage, why);
  for (const SolverRow* solver : kSolvers)
    if (const char* why = solver->fault(world))
      return error(stage, std::string("memory of ") + solver->name + ' ' + why);
  // Settings of the islands were read after their scratch memory was allocated; a copy starts
  // without it.
  return World(std::as_const(world));
}

Result<Saved> save_world(const World& world, const std::string& path) {
  Saved saved;
  const Result<std::string> bytes = world_to_bytes(world, &saved);
  if (!bytes) return bytes.errors();
  if (const auto written = write_file(path, *bytes); !written) return written.errors();
  return saved;
}

Result<World> load_world(const std::string& path, World like) {
  if (path.find('\0') != std::string::npos)
    return error(path, "found a name with a zero byte, expected that of a saved World");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in.is_open() || in.bad() || (bytes.empty() && errno != 0))
    return error(path, "cannot be read: " + std::generic_category().message(errno));
  return world_from_bytes(bytes, std::move(like), path);
}

}  // namespace pantin
