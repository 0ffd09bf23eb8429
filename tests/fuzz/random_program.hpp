#pragma once
/// Programs over the public interface, made of bytes: bodies, joints and the like come, change and
/// go, members get odd numbers, handles are stale, Worlds are copied, saved and put back, systems
/// do all that within steps. None may end but with an error or a status; a step that says `ok`
/// leaves no body where it cannot be, and what save_world writes can be read.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <pantin/assembler.hpp>
#include <pantin/pantin.hpp>
#include <string>
#include <vector>

#include "engine/base/invariants.hpp"
#include "engine/runtime/save.hpp"
#include "tests/fuzz/random_event.hpp"
#include "tests/fuzz/random_parts.hpp"

namespace pantin::test::random_program {

using namespace detail;

constexpr std::size_t kMostThings = 40, kMostBodies = 12;
constexpr int kMostSteps = 24, kMostActs = 120;

/// Ends the program, as libFuzzer and the tests of the house see it.
inline void demand(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "this must hold: %s\n", what.c_str());
  std::abort();
}

/// Reads the program; after its end all numbers are 0.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), left_(size) {}
  bool any() const { return left_ > 0; }
  unsigned next() {
    if (left_ == 0) return 0;
    --left_;
    return *at_++;
  }
  unsigned pick(std::size_t count) { return count > 0 ? next() % static_cast<unsigned>(count) : 0; }
  bool chance(unsigned of) { return next() % of == 0; }
  /// A number that a user may mean.
  Real plain() { return (static_cast<Real>(next()) - 128) / 32; }
  Real positive() { return (static_cast<Real>(next()) + 1) / 128; }
  /// Any, odd ones among them.
  Real number() {
    constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
    constexpr Real kOdd[] = {
        0.0,       -0.0,       1,      -1,     std::numeric_limits<Real>::quiet_NaN(),
        kInfinity, -kInfinity, 1e-320, 1e-300, 1e-12,
        1e-6,      1e-3,       1e3,    1e6,    1e9,
        -1e9,      1e12,       1e18,   1e38,   -1e38,
        1e100,     1e154,      1e300,  -1e300};
    if (!chance(3)) return plain();
    return kOdd[pick(std::size(kOdd))];
  }
  Vec3 place() {
    const Real x = plain(), y = plain();
    return {x, y, chance(2) ? 0 : plain()};
  }
  Vec3 numbers() {
    const Real x = number(), y = number();
    return {x, y, number()};
  }
  Quat turn() {
    const Real w = plain(), x = plain(), y = plain();
    return Quat(w, x, y, plain());
  }

 private:
  const std::uint8_t* at_;
  std::size_t left_;
};

struct Gust {  // a component of the user's own
  Real strength = 0;
  static constexpr std::string_view name = "gust";
  static void fields(auto& self, auto&& field) { field("strength", self.strength); }
};

/// A program under way.
class Program {
 public:
  explicit Program(Bytes bytes) : bytes_(bytes) {}

  void run() {
    while (bytes_.any() && acts_ < kMostActs && steps_ < kMostSteps) act(simulation_.world);
    step();
    round_trip(simulation_.world);
  }

 private:
  Entity thing() {
    if (things_.empty() || bytes_.chance(16)) return {};
    return things_[bytes_.pick(things_.size())];
  }
  template <class Description>
  void add(World& world, const Description& description) {
    if (things_.size() >= kMostThings) return;
    if (const Result<Entity> made = world.add(description))
      things_.push_back(*made);
    else
      demand(!made.errors().empty(), "a refusal says why");
  }

  BodyShape shape() {
    const Real a = bytes_.chance(12) ? bytes_.number() : bytes_.positive(), b = bytes_.positive();
    const Pose at = bytes_.chance(6) ? Pose{bytes_.place(), bytes_.turn()} : Pose{};
    switch (bytes_.pick(9)) {
      case 0:
        return SphereShape{a, at};
      case 1:
        return CapsuleShape{a, b, at};
      case 2:
        return BoxShape{{a, b, bytes_.positive()}, at};
      case 3:
        return PlaneShape{50, at};
      case 4:
        return CylinderShape{a, b, at};
      case 5:
        return ConeShape{a, b, at};
      case 6:
        return EllipsoidShape{{a, b, bytes_.positive()}, at};
      case 7: {
        HullShape hull;
        for (unsigned i = 4 + bytes_.pick(6); i-- > 0;) hull.points.push_back(bytes_.place());
        hull.at = at;
        return hull;
      }
      default:
        return {};
    }
  }

  Collision collision() {
    Collision c;
    if (bytes_.chance(8)) c.friction = bytes_.number(), c.restitution = bytes_.number();
    if (bytes_.chance(16)) c.rolling = bytes_.number(), c.surface_velocity = bytes_.numbers();
    c.sensor = bytes_.chance(10);
    return c;
  }

  void add_body(World& world) {
    if (world.bodies.size() >= kMostBodies) return;
    RigidBody body;
    body.motion = static_cast<Motion>(bytes_.chance(2) ? 0 : bytes_.pick(3));
    body.shape = shape();
    body.position = bytes_.chance(20) ? bytes_.numbers() : bytes_.place();
    if (bytes_.chance(4)) body.rotation = bytes_.turn();
    if (bytes_.chance(3)) body.velocity = bytes_.place();
    if (bytes_.chance(12)) body.density = bytes_.number();
    if (bytes_.chance(2)) body.collision = collision();
    add(world, body);
    if (!things_.empty() && bytes_.chance(3)) set_solver(world, things_.back());
  }

  std::optional<Interval> interval() {
    if (!bytes_.chance(4)) return {};
    const Real low = bytes_.plain();
    return Interval{low, bytes_.chance(8) ? bytes_.number() : low + bytes_.positive()};
  }
  JointMotor motor() {
    JointMotor m;
    if (!bytes_.chance(4)) return m;
    m.kind = static_cast<MotorKind>(bytes_.pick(3));
    return m;
  }

  void add_joint(World& world) {
    const Entity a = thing(), b = thing();
    const Vec3 at = bytes_.chance(24) ? bytes_.numbers() : bytes_.place();
    Vec3 axis(0, 0, 1);
    if (bytes_.chance(2)) axis = bytes_.place();
    SpringDamper spring;
    if (bytes_.chance(4)) spring.stiffness = bytes_.number(), spring.damping = bytes_.number();
    switch (bytes_.pick(10)) {
      case 0:
        return add(world, BallJoint{.a = a, .b = b, .anchor = at, .twist = interval()});
      case 1:
        return add(world, HingeJoint{.a = a,
                                     .b = b,
                                     .anchor = at,
                                     .axis = axis,
                                     .limits = interval(),
                                     .motor = motor(),
                                     .spring = spring});
      case 2:
        return add(world, FixedJoint{.a = a, .b = b, .anchor = at});
      case 3:
        return add(world, UniversalJoint{.a = a,
                                         .b = b,
                                         .anchor = at,
                                         .axis_a = axis,
                                         .axis_b = bytes_.place(),
                                         .limits = interval()});
      case 4:
        return add(world, PrismaticJoint{.a = a,
                                         .b = b,
                                         .anchor = at,
                                         .axis = axis,
                                         .travel = interval(),
                                         .spring = spring});
      case 5:
        return add(world, CylindricalJoint{.a = a, .b = b, .anchor = at, .axis = axis});
      case 6:
        return add(
            world,
            ScrewJoint{.a = a, .b = b, .anchor = at, .axis = axis, .pitch = bytes_.number()});
      case 7:
        return add(world, PlanarJoint{.a = a, .b = b, .anchor = at, .normal = axis});
      case 8:
        return add(world,
                   DistanceJoint{.a = a, .b = b, .anchor_a = at, .anchor_b = bytes_.place()});
      default:
        return add(world, SpringJoint{.a = a,
                                      .b = b,
                                      .anchor_a = at,
                                      .anchor_b = bytes_.place(),
                                      .stiffness = bytes_.number(),
                                      .damping = bytes_.number()});
    }
  }

  void add_tie(World& world) {
    switch (bytes_.pick(4)) {
      case 0: {
        CableJoint cable{.a = thing(), .b = thing(), .anchor_a = bytes_.place()};
        cable.anchor_b = bytes_.place();
        if (bytes_.chance(3)) cable.length = bytes_.number();
        if (bytes_.chance(4)) cable.compliance = bytes_.number();
        if (bytes_.chance(6))
          cable.over.push_back({thing(), bytes_.place(), {0, 0, 1}, bytes_.number()});
        return add(world, cable);
      }
      case 1: {
        PinConstraint pin{.body = thing(), .point = bytes_.place()};
        if (bytes_.chance(2)) pin.target = bytes_.place();
        if (bytes_.chance(3)) pin.to = thing();
        if (bytes_.chance(4)) pin.stiffness = bytes_.number();
        pin.priority = static_cast<int>(bytes_.pick(3));
        return add(world, pin);
      }
      case 2:
        return add(world, GearJoint{.first = thing(), .second = thing(), .ratio = bytes_.number()});
      default: {
        BeltJoint belt;
        for (unsigned i = 2 + bytes_.pick(2); i-- > 0;)
          belt.pulleys.push_back(
              {.body = thing(),
               .point = bytes_.place(),
               .radius = bytes_.chance(6) ? bytes_.number() : bytes_.positive()});
        return add(world, belt);
      }
    }
  }

  void add_event(World& world) {
    add_random_event(
        bytes_, [&] { return thing(); }, [&](const auto& e) { add(world, e); });
  }

  /// No program is merely slow.
  SolverSettings settings() {
    SolverSettings s;
    s.solver = static_cast<Solver>(bytes_.pick(7));
    s.integrator = static_cast<Integrator>(bytes_.pick(5));
    s.stabilisation = static_cast<Stabilisation>(bytes_.pick(3));
    if (bytes_.chance(8)) s.tolerance = bytes_.number(), s.rotation_stiffness = bytes_.number();
    if (bytes_.chance(8)) s.stall_drop = bytes_.number(), s.sleep_speed = bytes_.number();
    if (bytes_.chance(8)) s.baumgarte = bytes_.number(), s.jacobians = Jacobians(bytes_.pick(3));
    if (bytes_.chance(8)) s.sweeps = static_cast<int>(bytes_.pick(40)) - 4;
    return s;
  }
  void set_solver(World& world, Entity e) { world.settings.add(e, settings()); }

  void set_body(World& world) {
    Body* b = world.bodies.find(thing());
    if (!b) return;
    switch (bytes_.pick(10)) {
      case 0:
        b->mass = bytes_.number();
        break;
      case 1:
        b->inertia = bytes_.numbers();
        break;
      case 2:
        b->pose.position = bytes_.numbers();
        break;
      case 3:
        b->pose.rotation =
            bytes_.chance(2) ? Quat(bytes_.number(), 0, bytes_.number(), 0) : bytes_.turn();
        break;
      case 4:
        b->velocity = bytes_.numbers();
        break;
      case 5:
        b->angular_velocity = bytes_.numbers();
        break;
      case 6:
        b->drag = bytes_.number();
        break;
      case 7:
        b->gravity_scale = bytes_.number();
        break;
      case 8:
        b->motion = static_cast<Motion>(bytes_.pick(3));
        break;
      default:
        b->restart = b->teleport = true;
    }
    if (bytes_.chance(2)) world.mark_dirty();
  }

  void set_other(World& world) {
    const Entity e = thing();
    switch (bytes_.pick(8)) {
      case 0:
        if (Shapes* s = world.shapes.find(e); s && !s->list.empty())
          s->list[0].size = bytes_.numbers();
        break;
      case 1:
        if (Shapes* s = world.shapes.find(e); s && !s->list.empty())
          s->list[0].local = {bytes_.numbers(), bytes_.turn()};
        break;
      case 2:
        if (Link* l = world.links.find(e)) l->joint.anchor_a = bytes_.numbers();
        break;
      case 3:
        if (Cable* c = world.cables.find(e)) c->joint.length = bytes_.number();
        break;
      case 4:
        if (Pin* p = world.pins.find(e))
          p->target = bytes_.numbers(), p->stiffness = bytes_.number();
        break;
      case 5:
        if (Collision* c = world.collisions.find(e)) *c = collision();
        break;
      case 6:
        world.gravity = bytes_.chance(2) ? bytes_.place() : bytes_.numbers();
        break;
      default:
        if (SolverSettings* s = world.settings.find(e)) *s = settings();
    }
    if (bytes_.chance(2)) world.mark_dirty();
  }

  /// Components through any handle, stale or of another thing.
  void add_component(World& world) {
    const Entity e = thing();
    switch (bytes_.pick(9)) {
      case 0:
        world.collisions.add(e, collision());
        break;
      case 1:
        world.paths.add(e, {Lissajous{{bytes_.place()}, bytes_.numbers(), bytes_.place()}});
        break;
      case 2:
        set_solver(world, e);
        break;
      case 3:
        world.store<Gust>().add(e, {bytes_.number()});
        break;
      case 4:
        world.collisions.remove(e);
        break;
      case 5:
        world.shapes.remove(e);
        break;
      case 6:
        if (world.bodies.size() < kMostBodies) world.bodies.add(e, Body{});
        break;
      case 7:
        world.names.add(e, "thing");
        break;
      default:
        world.push(e, bytes_.numbers(), bytes_.place());
    }
  }

  void ask(const World& world) {
    draw_debug(world, {.bounds = true, .size = bytes_.number()}, [](const DebugLine& line) {
      demand(is_finite(line.from) && is_finite(line.to), "lines are finite");
    });
    for (const Entity e : things_) contact_modes(world, e), contact_mode(world, e);
    const Queries queries(world);
    const Vec3 from = bytes_.numbers();
    (void)queries.cast_ray({from, bytes_.numbers()}), (void)queries.closest_point(from, 1);
    Shape ball;
    ball.size = {bytes_.number(), 0, 0};
    (void)queries.cast_shape(ball, {bytes_.place()}, bytes_.numbers());
    (void)measure(world), (void)check(world), (void)state_hash(world);
    (void)world.name_of(thing()), (void)world.find("thing");
    Assembler hand(world);
    (void)hand.add(PointTarget{.body = thing(), .target = bytes_.numbers()});
    hand.iterate(), hand.iterate();
  }

  void round_trip(const World& world) {
    const Result<std::string> saved = world_to_bytes(world);
    if (!saved) return;
    World like;
    like.store<Gust>();
    const Result<World> read = world_from_bytes(*saved, like);
    demand(static_cast<bool>(read),
           "what was saved can be read: " + (read ? std::string() : read.errors()[0].message));
  }

  void insert_system() {
    const Stage stage = static_cast<Stage>(bytes_.pick(6));
    if (systems_++ > 3) return;
    (void)simulation_.insert(stage, [this](World& world, Real) { act(world); });
  }

  static bool is_sound(const World& world) {
    for (const Body& b : world.bodies.values()) {
      if (b.motion != Motion::dynamic) continue;
      if (!is_mass(b.mass) || !is_mass(b.inertia)) return false;
      if (!is_finite(b.pose) || !is_finite(b.velocity) || !is_finite(b.angular_velocity))
        return false;
    }
    return true;
  }

  void step() {
    if (within_) return void(simulation_.step());
    simulation_.settings.h = bytes_.chance(10) ? bytes_.number() : 1.0 / 60;
    simulation_.settings.substeps = bytes_.chance(6) ? 1 + static_cast<int>(bytes_.pick(3)) : 1;
    simulation_.settings.watch = bytes_.chance(2);
    within_ = true;
    const StepReport report = simulation_.step();
    within_ = false, ++steps_;
    const Real h = simulation_.settings.h;
    const bool taken = h > 0 && std::isfinite(h);
    if (taken && report.status == Status::ok && systems_ == 0)
      demand(is_sound(simulation_.world), "a step that is ok leaves no body where it cannot be");
  }

  void act(World& world) {
    if (++acts_ > kMostActs) return;
    switch (std::max(bytes_.pick(26), 1u)) {
      case 1:
        return add(world, random_joint(bytes_, thing(), thing()));
      case 2:
        return add(world, random_lamina(bytes_));
      case 3:
        return add_body(world);
      case 4:
      case 5:
      case 6:
        return add_joint(world);
      case 7:
        return add_tie(world);
      case 8:
        return add_event(world);
      case 9:
        world.default_settings = settings();
        return world.mark_dirty();
      case 10:
        return set_body(world);
      case 11:
        return set_other(world);
      case 12:
        return add_component(world);
      case 13:
        return world.destroy(thing());
      case 14:
        if (!within_) insert_system();
        return;
      case 15:
        return ask(world);
      case 16:
        kept_ = world;
        return;
      case 17:
        if (bytes_.chance(2)) world = kept_;
        return;
      case 18:
        return round_trip(world);
      case 19:
        return void(world.teleport(thing(), {bytes_.numbers(), bytes_.turn()}));
      default:
        return step();
    }
  }

  Bytes bytes_;
  Simulation simulation_;
  World kept_;
  std::vector<Entity> things_;
  int acts_ = 0, steps_ = 0, systems_ = 0;
  bool within_ = false;
};

}  // namespace pantin::test::random_program
