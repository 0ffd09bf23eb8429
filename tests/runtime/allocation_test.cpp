// No step allocates once the structure is known. Every allocation of this runner is counted.
#include <malloc.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <pantin/assembler.hpp>
#include <pantin/must.hpp>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/ties.hpp"
#include "engine/world/timed_event.hpp"
#include "tests/paths.hpp"
#include "tests/runtime/puppets.hpp"
#include "tests/runtime/running.hpp"
#include "tests/solvers/surfaces.hpp"

namespace {

std::atomic<long> allocations{0}, live_bytes{0};

void* counted(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) noexcept {
  ++allocations;
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  void* p = std::aligned_alloc(alignment, whole ? whole : alignment);
  live_bytes += static_cast<long>(malloc_usable_size(p));
  return p;
}

void give_back(void* p) noexcept {
  live_bytes -= static_cast<long>(malloc_usable_size(p));
  std::free(p);
}

void* or_throw(void* p) {
  if (!p) throw std::bad_alloc();
  return p;
}

}  // namespace

void* operator new(std::size_t size) { return or_throw(counted(size)); }
void* operator new[](std::size_t size) { return or_throw(counted(size)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new(std::size_t size, std::align_val_t a) {
  return or_throw(counted(size, static_cast<std::size_t>(a)));
}
void* operator new[](std::size_t size, std::align_val_t a) {
  return or_throw(counted(size, static_cast<std::size_t>(a)));
}
void operator delete(void* p) noexcept { give_back(p); }
void operator delete[](void* p) noexcept { give_back(p); }
void operator delete(void* p, std::size_t) noexcept { give_back(p); }
void operator delete[](void* p, std::size_t) noexcept { give_back(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { give_back(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { give_back(p); }
void operator delete(void* p, std::align_val_t) noexcept { give_back(p); }
void operator delete[](void* p, std::align_val_t) noexcept { give_back(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { give_back(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { give_back(p); }

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

long allocations_in(Simulation& simulation, int steps) {
  const long before = allocations;
  for (int i = 0; i < steps; ++i) simulation.step();
  return allocations - before;
}

}  // namespace

TEST_CASE("allocations are counted") {
  const long before = allocations;
  const auto kept = std::make_unique<std::vector<int>>(100);
  CHECK(allocations - before >= 2);
  CHECK(kept->size() == 100);
}

TEST_CASE("a step allocates nothing after the first few") {
  const auto solver =
      GENERATE(Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural);
  const bool puppet = GENERATE(false, true);
  INFO(name_of(solver) << (puppet ? ", puppet" : ", chain"));
  World world = puppet ? swaying_puppet().world : hung_chain(30).world;
  world.default_settings.solver = solver;
  Simulation simulation(std::move(world));
  simulation.settings.measure = true;
  simulation.timing = true;
  simulation.insert(Stage::before_update, [](World& w, Real) {
    w.push(w.bodies.owners()[2], {0, 0.5, 0}, w.bodies.values()[2].pose.position);
  });
  allocations_in(simulation, 20);
  CHECK(allocations_in(simulation, 300) == 0);
}

TEST_CASE(
    "a step of the Lagrangian solver allocates nothing after the first few, limits met or not") {
  const auto integrator = GENERATE(Integrator::euler, Integrator::rattle, Integrator::rk4,
                                   Integrator::implicit, Integrator::radau);
  const Real tolerance = GENERATE(0.0, 1e-8);
  World world = hung_chain(10).world;
  world.default_settings.solver = Solver::lagrangian;
  world.default_settings.integrator = integrator;
  world.default_settings.step_tolerance = tolerance;
  for (Link& l : world.links.values()) {
    l.joint.limits.edit().angle = {true, -0.1, 0.1};
    l.joint.limits.edit().swing = {true, 0.3, 0.2};
    l.joint.parameters.edit().rotation.spring.stiffness = 0.1;
  }
  Body& last = world.bodies.values()[10];
  last.angular_velocity = {3, 2, 1};
  Simulation simulation(std::move(world));
  simulation.settings.measure = true;
  allocations_in(simulation, 3);
  CHECK(allocations_in(simulation, 60) == 0);
}

TEST_CASE("a step of surfaces that roll, come apart and land allocates nothing") {
  const auto integrator = GENERATE(Integrator::euler, Integrator::rattle, Integrator::rk4,
                                   Integrator::implicit, Integrator::radau);
  World world = exact_world(integrator);
  const Entity ground = add_ground(world);
  for (const bool lifts : {false, true}) {
    const Entity body = world.add_body(
        solid_ellipsoid(1, {0.12, 0.1, 0.11}, {{lifts ? 1.0 : 0.0, 0.4, 0}, kIdentity}));
    world.bodies[body].angular_velocity = {0.5, 0.2, 1};
    const Entity joint = touch(world, {body, ball_skin({0.12, 0.1, 0.11}), ground, flat_skin(6)},
                               SurfaceMotion::rolling);
    world.surface_contacts[joint].lifts = lifts;
  }
  Simulation simulation(std::move(world), {1.0 / 120});
  allocations_in(simulation, 3);
  CHECK(allocations_in(simulation, 120) == 0);
}

TEST_CASE("a step of planar linkages, belts and curves that nothing can touch allocates nothing") {
  const std::string name = GENERATE("planar_four_bar", "planar_belts", "planar_serpentine",
                                    "cam_follower", "geneva", "spline_cam", "elliptical_gears");
  const auto scene = load_scene(asset("scenes/" + name + ".json"));
  REQUIRE(scene);
  Simulation simulation = Simulation::copy_of(scene->world, {scene->step});
  allocations_in(simulation, 300);
  INFO(name);
  CHECK(allocations_in(simulation, 300) == 0);
}

TEST_CASE("steps ask a filter and one-way surfaces without allocating") {
  const auto solver = GENERATE(Solver::articulated, Solver::lagrangian);
  CAPTURE(name_of(solver));
  World world;
  world.default_settings.solver = solver;
  const auto add_box = [&](Vec3 at, const Collision& collision) {
    Body body;
    body.motion = collision.one_way == Vec3(0) ? Motion::dynamic : Motion::fixed;
    body.pose.position = at;
    const Entity e = world.add_body(body);
    Shape box;
    box.kind = ShapeKind::box;
    box.size = body.motion == Motion::fixed ? Vec3(2, 0.1, 1) : Vec3(0.1, 0.1, 0.1);
    world.shapes.add(e, {{box}});
    world.collisions.add(e, collision);
    return e;
  };
  add_box({0, 0, 0}, {.one_way = {0, 1, 0}});
  const Entity ghost = add_box({-1, 1, 0}, {});
  for (int i = 0; i < 4; ++i) {
    const Entity box = add_box({0.5 * i - 0.5, i % 2 ? 0.5 : -0.4, 0}, {});
    if (i % 2 == 0) world.bodies[box].velocity.y = 5;  // jumps through the platform
  }
  int asked = 0;
  Simulation simulation(std::move(world), {1.0 / 120});
  simulation.settings.filter = [&](const ContactPair& pair) {
    ++asked;
    return pair.a != ghost && pair.b != ghost;
  };
  // They come near, and part, again and again: what is kept of a pair finds its place.
  const auto again = [&] {
    for (Body& b : simulation.world.bodies.values())
      if (b.motion == Motion::dynamic && b.pose.position.y < 0.3) b.velocity.y = 5;
  };
  for (int round = 0; round < 3; ++round) again(), allocations_in(simulation, 120);
  const int before = asked;
  long count = 0;
  for (int round = 0; round < 3; ++round) again(), count += allocations_in(simulation, 120);
  CHECK(count == 0);
  CHECK(asked > before);
  CHECK(simulation.world.bodies[ghost].pose.position.y < -1);
}

TEST_CASE("timed events that act and change numbers allocate nothing") {
  World world = hung_chain(10).world;
  const Entity first = world.bodies.owners()[1], last = world.bodies.owners()[10];
  add_event(world, {PushEvent{.body = last, .force = {0.5, 0, 0}, .from = 0.2, .to = 3}});
  add_event(world, {ImpulseEvent{.body = first, .impulse = {0, 0, 0.01}, .every = 0.1}});
  add_event(world, {WindEvent{.velocity = {1, 0, 0}, .gusts = Vec3(1)}});
  add_event(world, {GravityEvent{.gravity = {0, 0, -5}, .at = 1, .over = 2}});
  Simulation simulation(std::move(world));
  allocations_in(simulation, 3);
  CHECK(allocations_in(simulation, 240) == 0);
}

TEST_CASE("a step of exact bodies that lie on one another allocates nothing") {
  const auto integrator = GENERATE(Integrator::euler, Integrator::rattle, Integrator::rk4,
                                   Integrator::implicit, Integrator::radau);
  World world = falling_pile();
  world.default_settings.solver = Solver::lagrangian;
  world.default_settings.integrator = integrator;
  Simulation simulation(std::move(world));
  allocations_in(simulation, 300);
  CHECK(simulation.step().contacts > 0);
  CHECK(allocations_in(simulation, 60) == 0);
}

TEST_CASE("advancing and drawing allocate nothing after the first few") {
  Puppet p = swaying_puppet();
  Simulation simulation = Simulation::copy_of(p.world);
  const auto frame = [&] {
    const Advance a = simulation.advance(1.0 / 47);
    return simulation.interpolated(p.left, a.fraction);
  };
  for (int i = 0; i < 20; ++i) frame();
  const long before = allocations;
  for (int i = 0; i < 100; ++i) frame();
  CHECK(allocations == before);
}

namespace {

/// Bytes that a hanging chain takes while it is stepped.
long bytes_of_chain(std::size_t links) {
  const long before = live_bytes;
  World world;
  world.bodies.reserve(links + 1), world.links.reserve(links);
  Body wall;
  wall.motion = Motion::fixed;
  Entity above = world.add_body(wall);
  for (std::size_t i = 0; i < links; ++i) {
    Body link;
    link.pose.position = {0, -0.1 * static_cast<Real>(i) - 0.05, 0};
    const Entity e = world.add_body(link);
    add_link(world, {above, e, {{0, i == 0 ? 0 : -0.05, 0}, {0, 0.05, 0}}});
    above = e;
  }
  Simulation simulation(std::move(world));
  for (int i = 0; i < 10; ++i) simulation.step();
  return live_bytes - before;
}

}  // namespace

TEST_CASE(
    "a link takes no more than a kibibyte, its body, its joint and the solver's room "
    "included") {
  constexpr std::size_t kLinks = 1000;
  // Blocks of their own are rounded up to pages, which would be counted as used.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  bytes_of_chain(2);  // what a process takes once
  const double per_link = static_cast<double>(bytes_of_chain(kLinks)) / kLinks;
  INFO(per_link << " bytes");
  CHECK(per_link < 1028);  // and 4 bytes in the list of what is awake
  CHECK(per_link > 400);   // the count counts
}

TEST_CASE("a step of a lamina allocates nothing after the first few, switches of modes included") {
  const char* name = GENERATE("rod", "regrasp", "push");
  CAPTURE(name);
  const auto scene = load_scene(asset("laminas/" + std::string(name) + ".json"));
  REQUIRE(scene);
  Simulation simulation = Simulation::copy_of(scene->world);
  simulation.settings.measure = true;
  allocations_in(simulation, 20);
  int switches = 0;
  const long before = allocations;
  for (int i = 0; i < 180 || (i < 800 && std::string(name) == "rod"); ++i)
    switches += simulation.step().mode_switches;
  CHECK(allocations == before);
  if (std::string(name) != "push") CHECK(switches > 0);
}

TEST_CASE("an assembler allocates nothing while targets move, limits met or not") {
  World world = hung_chain(10).world;
  world.default_settings.solver = Solver::lagrangian;
  for (Link& l : world.links.values()) {
    l.joint.limits.edit().angle = {true, -0.1, 0.1};
    l.joint.limits.edit().swing = {true, 0.3, 0.2};
  }
  const Entity last = world.bodies.owners()[10];
  const Vec3 start = world.bodies[last].pose.position;
  Assembler hand(world);
  const Target target = must(hand.add(PointTarget{.body = last, .target = start}));
  hand.settle(20);
  const long before = allocations;
  for (int i = 0; i < 300; ++i) {
    hand.move(target, start + 0.5 * Vec3(std::sin(0.1 * i), std::sin(0.07 * i), 0.3));
    hand.iterate();
  }
  CHECK(allocations - before == 0);
}
