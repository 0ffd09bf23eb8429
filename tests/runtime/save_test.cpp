// A World saved in mid-run goes on from the file as if nothing had happened.
#include "engine/runtime/save.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "engine/base/archive.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/running.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

struct Wind {
  static constexpr const char* name = "wind";
  Vec3 force{0};
  int gusts = 0;

  static void fields(auto& self, auto&& field) {
    field("force", self.force);
    field("gusts", self.gusts);
  }
};

struct Breeze {
  static constexpr const char* name = "wind";
  Vec3 force{0};

  static void fields(auto& self, auto&& field) { field("force", self.force); }
};

struct Remark {
  std::string text;
};

class Tie final : public CustomJoint {
 public:
  int rows() const override { return 1; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    c[0] = a.position.y - b.position.y;
  }
};

std::vector<std::uint64_t> hashes(World world, int steps) {
  Simulation sim(std::move(world));
  std::vector<std::uint64_t> all;
  for (int i = 0; i < steps; ++i) sim.step(), all.push_back(state_hash(sim.world));
  return all;
}

World after(World world, int steps) {
  Simulation sim(std::move(world));
  for (int i = 0; i < steps; ++i) sim.step();
  return std::move(sim.world);
}

std::string only_error(const Result<World>& result) {
  REQUIRE_FALSE(result);
  REQUIRE(result.errors().size() == 1);
  return result.errors()[0].message;
}

std::string path_of(const char* name) {
  return (std::filesystem::temp_directory_path() / name).string();
}

}  // namespace

TEST_CASE("a World that was saved and loaded goes on with the same bits") {
  for (const auto& [name, start] : running_worlds())
    for (const int steps : {0, 1, 40}) {
      INFO(name << " after " << steps << " steps");
      const World running = after(start, steps);
      const auto bytes = world_to_bytes(running);
      REQUIRE(bytes);
      const auto loaded = world_from_bytes(*bytes);
      if (!loaded) FAIL(loaded.errors()[0].message);
      if (steps > 0) CHECK(state_hash(*loaded) == state_hash(running));
      CHECK(same_fields(*loaded, running));
      CHECK(hashes(*loaded, 40) == hashes(running, 40));
    }
}

TEST_CASE("settings that wait for mark_dirty are saved as the islands have them") {
  World start;
  start.default_settings.solver = Solver::lagrangian;
  start.default_settings.integrator = Integrator::rk4;
  start.default_settings.step_tolerance = 1e-8;
  Body beam, rod;
  beam.motion = Motion::fixed;
  rod.pose.position = {0.5, 0, 0};
  Joint ball;
  ball.anchor_b = {-0.5, 0, 0};
  const Entity at = start.add_body(beam);
  add_link(start, {at, start.add_body(rod), ball});
  World running = after(start, 5);
  running.default_settings.step_tolerance = 0;  // the islands keep theirs until they are recompiled
  const auto bytes = world_to_bytes(running);
  REQUIRE(bytes);
  const auto loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  CHECK(hashes(*loaded, 5) == hashes(running, 5));
}

TEST_CASE("a World changed in its structure since the last step is saved as it will go on") {
  Puppet p = swaying_puppet();
  p.world = after(p.world, 20);
  p.world.destroy(p.string);
  const auto bytes = world_to_bytes(p.world);
  REQUIRE(bytes);
  const auto loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  CHECK(hashes(*loaded, 20) == hashes(p.world, 20));
}

TEST_CASE("handles are good in the loaded World, those that were given back too") {
  Puppet p = swaying_puppet();
  p.world.destroy(p.left);
  const auto loaded = world_from_bytes(*world_to_bytes(p.world));
  REQUIRE(loaded);
  World copy = *loaded;
  CHECK_FALSE(copy.is_alive(p.left));
  CHECK(copy.name_of(p.right) == p.world.name_of(p.right));
  CHECK(copy.create() == p.world.create());
}

TEST_CASE("components of the user's own are saved by their fields") {
  Puppet p = swaying_puppet();
  p.world.store<Wind>().add(p.left, {{1, 2, 3}, 4});
  p.world.store<Remark>().add(p.left, {"left hand"});
  const std::string path = path_of("pantin_save_test.world");
  const auto saved = save_world(p.world, path);
  REQUIRE(saved);
  REQUIRE(saved->left_out.size() == 1);
  CHECK(saved->left_out[0].find("Remark") != std::string::npos);

  const auto loaded = load_world<Wind>(path);
  REQUIRE(loaded);
  World world = *loaded;
  CHECK(world.store<Wind>()[p.left].gusts == 4);
  CHECK(state_hash(world) == state_hash(world));
  CHECK(only_error(load_world(path)) ==
        path + ": contains components wind, name their type: load_world<T>(path)");
  CHECK(only_error(load_world<Breeze>(path)) ==
        path + ": contains components wind, whose fields differ from those of the program");
  std::remove(path.c_str());
}

TEST_CASE("a joint of the user's own kind cannot be saved, and this is said") {
  World w = geared_wheels(Integrator::rk4);
  Joint joint;
  joint.kind = JointKind::custom;
  joint.parameters.edit().custom = std::make_shared<Tie>();
  add_link(w, {w.bodies.owners()[0], w.bodies.owners()[1], joint});
  const auto bytes = world_to_bytes(w);
  REQUIRE_FALSE(bytes);
  CHECK(bytes.errors()[0].message.find("CustomJoint") != std::string::npos);
}

TEST_CASE("files that cannot be read or written are refused with one line") {
  CHECK(only_error(load_world("/no/such/file")) ==
        "/no/such/file: cannot be read: No such file or directory");
  const auto saved = save_world(World{}, "/no/such/file");
  REQUIRE_FALSE(saved);
  CHECK(saved.errors()[0].message == "/no/such/file: No such file or directory");
  const std::string path = path_of("pantin_save_other.world");
  std::ofstream(path) << "{\"version\": 1, \"bodies\": [], \"padding\": \"1234567890\"}";
  CHECK(only_error(load_world(path)) == path + ": found no pantin file, expected a saved World");
  std::remove(path.c_str());
}

TEST_CASE("an older file stays whole where a new one cannot be written") {
  const std::string path = path_of("pantin_save_old.world");
  REQUIRE(save_world(falling_pile(), path));
  std::filesystem::create_directory(path + ".part");  // in the way
  CHECK_FALSE(save_world(World{}, path));
  const auto loaded = load_world(path);
  REQUIRE(loaded);
  CHECK(loaded->bodies.size() == falling_pile().bodies.size());
  std::filesystem::remove(path + ".part");
  std::remove(path.c_str());
}

TEST_CASE("a saved World that was cut off or changed is refused") {
  const std::string whole = *world_to_bytes(after(falling_pile(), 30));
  for (std::size_t size = 0; size < whole.size(); size += size < 200 ? 1 : 97)
    CHECK_FALSE(world_from_bytes(std::string_view(whole).substr(0, size)));
  for (std::size_t i = 0; i < whole.size(); i += i < 200 ? 1 : 97) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x20);
    CHECK_FALSE(world_from_bytes(changed));
  }
}

/// The same bytes behind a header that fits them, as a forger would write it.
std::string sealed(std::string bytes) {
  constexpr std::size_t kHeader = 36, kChecksum = 28;
  Hash hash;
  hash.add(std::string_view(bytes).substr(kHeader));
  const std::uint64_t sum = hash.value();
  return bytes.replace(kChecksum, sizeof sum, reinterpret_cast<const char*>(&sum), sizeof sum);
}

TEST_CASE("rotations and limits that cannot be are refused in a saved World") {
  const std::string whole = *world_to_bytes(stopped_arm());
  // The first place that holds these numbers holds `to` at its end instead.
  const auto refused = [&](std::vector<double> numbers, double to) {
    const std::size_t size = numbers.size() * sizeof(double);
    const std::size_t at = whole.find({reinterpret_cast<const char*>(numbers.data()), size});
    REQUIRE(at != std::string::npos);
    std::string bytes = whole;
    std::memcpy(&bytes[at + size - sizeof to], &to, sizeof to);
    return only_error(world_from_bytes(sealed(bytes)));
  };
  const Quat turned = stopped_arm().links.values()[0].joint.frames.a();
  CHECK(refused({turned.x, turned.y, turned.z, turned.w}, 3)
            .find("axes that are not unit quaternions") != std::string::npos);
  CHECK(refused({-0.3, 0.4}, -0.4).find("low end is above") != std::string::npos);
  const Quat body = stopped_arm().bodies.values()[1].pose.rotation;
  CHECK(
      refused({body.x, body.y, body.z, body.w}, 3).find("rotation that is not a unit quaternion") !=
      std::string::npos);
}

namespace {

/// A body of this mass, hung from one of the other solver.
World hung(Real mass) {
  World world;
  Body above, below;
  above.mass = 4;
  below.pose.position = {0, -1, 0}, below.mass = mass;
  Pin p;
  p.to = world.add_body(above), p.body = world.add_body(below), p.anchor = {0, 1, 0};
  world.settings.add(p.to, world.default_settings).solver = Solver::lagrangian;
  world.add_pin(p);
  return world;
}

/// A number as a saved World holds it, and what a forger writes in its place.
struct Forgery {
  double number = 0;
  std::vector<double> instead;
};

/// Wherever the number stands in the file but first, in the component itself, none of those passes.
void check_forged(const World& world, const Forgery& forgery, const char* complaint) {
  const std::string bytes = *world_to_bytes(world);
  char text[sizeof forgery.number];
  std::memcpy(text, &forgery.number, sizeof text);
  std::size_t at = bytes.find({text, sizeof text});
  int found = 0;
  while ((at = bytes.find({text, sizeof text}, at + 1)) != std::string::npos) {
    ++found;
    for (const double none : forgery.instead) {
      std::string forged = bytes;
      std::memcpy(&forged[at], &none, sizeof none);
      CHECK(only_error(world_from_bytes(sealed(forged))).find(complaint) != std::string::npos);
    }
  }
  CHECK(found > 0);
}

}  // namespace

TEST_CASE("masses that are not positive and finite are refused in the islands of a saved World") {
  const double mass = 2.71875;
  std::vector<World> worlds = {hung(mass)};
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    World& world = worlds.emplace_back(stopped_arm());
    world.default_settings.solver = solver;
    world.bodies.values()[1].mass = mass;
    world.mark_dirty();
  }
  for (const World& world : worlds) {
    check_forged(world, {mass, {-1, 0, 1e-310, std::numeric_limits<double>::infinity()}},
                 "mass that is not positive and finite");
  }
}

TEST_CASE("settings out of range are refused in the islands of a saved World") {
  const double ratio = 0.71875;
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    World world = stopped_arm();
    world.default_settings.solver = solver;
    world.default_settings.damping_ratio = ratio;
    world.mark_dirty();
    check_forged(world, {ratio, {-1, 2, std::numeric_limits<double>::quiet_NaN()}},
                 "solver settings");
  }
}

TEST_CASE("names in a forged file reach no terminal as they are") {
  World world;
  world.store<Wind>().add(world.add_body(Body{}), {});
  std::string bytes = *world_to_bytes(world);
  bytes[bytes.rfind("wind") + 1] = '\x1b';
  CHECK(only_error(world_from_bytes(sealed(bytes))).find("w\\u001bnd") != std::string::npos);
}

TEST_CASE("a World whose versions add up to none is compiled all the same") {
  World world;
  const Entity e = world.add_body(Body{});
  world.edit_count -= world.structure();
  auto loaded = world_from_bytes(*world_to_bytes(world));
  REQUIRE(loaded);
  Simulation simulation(std::move(*loaded));
  simulation.step();
  CHECK(simulation.world.bodies[e].velocity.y < 0);
}

TEST_CASE("a changed file with the right checksum is refused or steps; nothing worse happens") {
  const std::string whole = *world_to_bytes(after(stopped_arm(), 10));
  int read = 0, refused = 0;
  for (std::size_t i = 36; i < whole.size(); i += 13) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ (i % 2 == 0 ? 0xff : 0x01));
    auto loaded = world_from_bytes(sealed(changed));
    if (loaded && loaded->default_settings.sweeps < 100)
      Simulation(std::move(*loaded)).step(), ++read;  // the sanitizers look on
    else
      ++refused;
  }
  CHECK(read > 0);
  CHECK(refused > 0);
}
