// What programs do wrong while they run ends in an error or a status: handles of what is gone,
// Worlds put back within a step, numbers that are not finite, steps within steps, memory that runs
// out.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <new>
#include <pantin/pantin.hpp>

#include "engine/runtime/save.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();

RigidBody box(Real height) {
  RigidBody body;
  body.shape = BoxShape{{0.1, 0.1, 0.1}}, body.position = {0, height, 0};
  body.collision = Collision{};
  return body;
}

/// Three boxes that fall onto one another.
World stack(Solver solver) {
  World w;
  w.default_settings.solver = solver;
  (void)w.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}});
  for (int i = 0; i < 3; ++i) (void)w.add(box(0.1 + 0.19 * i));
  return w;
}

constexpr Solver kAll[] = {Solver::articulated, Solver::sweep,      Solver::shake2,
                           Solver::procedural,  Solver::lagrangian, Solver::planar};

}  // namespace

TEST_CASE("a component added through a stale handle hides nothing, and is told") {
  for (const Solver solver : kAll) {
    CAPTURE(name_of(solver));
    World w;
    w.default_settings.solver = solver;
    const Entity a = w.add(box(0)).value();
    (void)w.add(box(3)).value();
    w.destroy(a);
    const Entity c = w.add(box(6)).value();  // takes the same index
    REQUIRE(c.index == a.index);
    w.collisions.add(a, Collision{});
    w.settings.add(a, SolverSettings{});
    w.names.add(a, "gone");
    REQUIRE(check(w).size() >= 2);
    CHECK(check(w).front().link == a);
    Simulation sim = Simulation::copy_of(w);
    const StepReport report = sim.step();
    CHECK(report.faults >= 2);
    CHECK(report.fault == a);
    CHECK(sim.world.collisions.find(c));
    CHECK(!sim.world.collisions.find(a));
    const auto bytes = world_to_bytes(w);
    REQUIRE(bytes);
    CHECK(world_from_bytes(*bytes));
  }
}

TEST_CASE("a World put back within a step takes that step as it would have taken it") {
  constexpr Stage kBefore[] = {Stage::before_drive, Stage::before_update, Stage::before_contacts,
                               Stage::before_adjust};
  for (const Solver solver : kAll)
    for (const Stage stage : kBefore)
      for (const int substeps : {1, 3}) {
        CAPTURE(name_of(solver), static_cast<int>(stage), substeps);
        Simulation sim(stack(solver), {.substeps = substeps, .watch = true});
        World kept;
        int runs = 0;
        bool back = false;
        REQUIRE(sim.insert(stage, [&](World& world, Real) {
          if (back && runs++ == 0) world = kept;
        }));
        for (int i = 0; i < 20; ++i) {
          if (i == 5) kept = sim.world;
          back = i == 10;
          const StepReport report = sim.step();
          CHECK(report.status == Status::ok);
          if (i != 10) continue;
          Simulation again = Simulation::copy_of(kept, {.substeps = substeps});
          again.step();
          CHECK(state_hash(sim.world) == state_hash(again.world));
        }
        // Those that pose keep no account of energy, and throw what they hold.
        if (knows(solver, Feature::contact)) CHECK(sim.findings().empty());
      }
}

TEST_CASE("a mass that becomes none without mark_dirty is told") {
  for (const Solver solver : kAll)
    for (const Real bad : {kNan, 0.0, -1.0}) {
      CAPTURE(name_of(solver), bad);
      Simulation sim(stack(solver));
      sim.step();
      Body& body = sim.world.bodies.values()[2];
      body.mass = bad;
      const StepReport report = sim.step();
      CHECK(report.status == Status::diverged);
      CHECK(report.body == sim.world.bodies.owners()[2]);
    }
}

TEST_CASE("sizes, places and rotations out of range are reported, and not solid") {
  const auto spoil = [](World& w, int how) {
    Shape& shape = w.shapes.values()[1].list[0];
    if (how == 0) shape.size.x = kNan;
    if (how == 1) shape.size.y = -0.1;
    if (how == 2) shape.local.rotation = Quat(0, 0, 0, 0);
    if (how == 3) shape.local.position.z = kNan;
    w.mark_dirty();
  };
  for (const Solver solver : kAll)
    for (int how = 0; how < 4; ++how) {
      CAPTURE(name_of(solver), how);
      World w = stack(solver);
      spoil(w, how);
      Simulation sim = Simulation::copy_of(w);
      CHECK(sim.step().faults > 0);
      for (int i = 0; i < 5; ++i) sim.step();
      const Queries queries(sim.world);
      CHECK(queries.left_out() > 0);
    }
  for (const Solver solver : kAll) {  // of a body that stands
    World w = stack(solver);
    w.bodies.values()[0].pose.rotation = Quat(0, 0, 0, 0);
    Simulation sim = Simulation::copy_of(w);
    const StepReport report = sim.step();
    CHECK(report.status == Status::diverged);
    CHECK(report.body == w.bodies.owners()[0]);
  }
}

TEST_CASE("a step within a step does nothing and says so") {
  Simulation sim(stack(Solver::articulated));
  Status within = Status::ok;
  REQUIRE(sim.insert(Stage::before_adjust, [&](World&, Real) { within = sim.step().status; }));
  const StepReport report = sim.step();
  CHECK(within == Status::system_failed);
  CHECK(report.status == Status::ok);
  CHECK(sim.world.tick == 1);
}

namespace {

/// A joint whose equations need memory that is not always there.
struct Greedy final : CustomJoint {
  mutable int left = 0;  // residuals until it runs out
  int rows() const override { return 1; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    if (left-- == 0) throw std::bad_alloc();
    c[0] = b.position.y - a.position.y - 1;
  }
};

}  // namespace

TEST_CASE("memory that runs out within a step ends it, and the next one goes on") {
  const auto greedy = std::make_shared<Greedy>();
  greedy->left = 1 << 30;
  World w;
  w.default_settings.solver = Solver::lagrangian;
  const Entity a = w.add(box(0)).value(), b = w.add(box(1)).value();
  w.collisions.remove(a), w.collisions.remove(b);
  REQUIRE(w.add(CustomConstraint{.a = a, .b = b, .equations = greedy}));
  Simulation sim = Simulation::copy_of(w), well = Simulation::copy_of(w);
  for (int i = 0; i < 20; ++i) {
    greedy->left = i == 10 ? 5 : 1 << 30;
    const StepReport report = sim.step();
    CHECK((report.status != Status::ok) == (i == 10));
    CHECK(sim.world.tick == static_cast<std::uint64_t>(i < 10 ? i + 1 : i));
    if (i == 10) continue;
    well.step();
    const Body &one = sim.world.bodies[b], &other = well.world.bodies[b];
    CHECK(std::abs(one.pose.position.y - other.pose.position.y) < 1e-12);
  }
}

namespace {

/// Asks that the only fault of a World is that of a body that cannot be solved for, whose reason
/// has these words, and that a step tells; or, without words, that there is no fault.
void check_told(World w, Entity body, const std::string& words) {
  const std::vector<StructureFault> faults = check(w);
  REQUIRE(faults.size() == (words.empty() ? 0u : 1u));
  if (words.empty()) return;
  CHECK(faults[0].link == body);
  CHECK(faults[0].kind == StructureFault::impossible);
  CHECK(faults[0].reason.find(words) != std::string::npos);
  Simulation sim(std::move(w), {1.0 / 60});
  CHECK(sim.step().status != Status::ok);
}

}  // namespace

TEST_CASE("more joints of a body to fixed ones than can be solved for are told likewise") {
  for (const int count : {128, 129}) {
    World w;
    w.default_settings.solver = Solver::lagrangian;
    const Entity body = w.add_body({}, "body");
    Body fixed;
    fixed.motion = Motion::fixed;
    const Entity wall = w.add_body(fixed, "wall");
    for (int i = 0; i < count; ++i) add_link(w, {wall, body, {{0.01 * i, 0, 0}, {0.01 * i, 0, 0}}});
    check_told(std::move(w), body, count == 129 ? "129 joints to fixed bodies" : "");
  }
}

TEST_CASE("more joints between two bodies than can be solved for are told likewise") {
  for (const int count : {128, 129}) {
    World w;
    w.default_settings.solver = Solver::lagrangian;
    const Entity one = w.add_body({}, "one"), other = w.add_body({}, "other");
    Entity first;
    for (int i = 0; i < count; ++i) {
      const Entity link = add_link(w, {other, one, {{0.01 * i, 0, 0}, {0.01 * i, 0, 0}}});
      if (i == 0) first = link;
    }
    check_told(std::move(w), first, count == 129 ? "129 joints between the same two bodies" : "");
  }
}

TEST_CASE("more exact pins of a body than can be solved for are told before a step is tried") {
  for (const int count : {64, 65}) {
    World w;
    w.default_settings.solver = Solver::lagrangian;
    const Entity body = w.add_body({}, "body");
    for (int i = 0; i < count; ++i) {
      Pin pin;
      pin.body = body, pin.anchor = pin.target = {0.01 * i, 0, 0};
      w.pins.add(w.create(), pin);
    }
    check_told(std::move(w), body, count == 65 ? "65 exact pins" : "");
  }
}
