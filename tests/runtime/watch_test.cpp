// The watches of a run: each names what its solver could not keep, and a near miss is none. Bodies
// are put where a solver would have left them, so that no change of a solver hides what is tested.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/base/rotation.hpp"
#include "engine/runtime/monitor.hpp"
#include "tests/runtime/watches.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

void turn(World& w, Entity e, Vec3 by) {
  Body& b = w.bodies[e];
  b.pose.rotation = from_rotation_vector(by) * b.pose.rotation;
}

/// Two wheels on hinges of the ground, 1 m apart.
struct Wheels {
  World world;
  Entity wheel[2], hinge[2];
};
Wheels two_wheels(Solver solver = Solver::articulated) {
  Wheels t;
  t.world.default_settings.solver = solver;
  const Entity ground = add_box(t.world, {0, -5, 0}, Vec3(1), Motion::fixed);
  for (int i = 0; i < 2; ++i) {
    const Vec3 at{1.0 * i, 0, 0};
    t.wheel[i] = add_box(t.world, at, Vec3(0.1));
    t.hinge[i] =
        t.world.add(HingeJoint{.a = ground, .b = t.wheel[i], .anchor = at, .axis = {0, 0, 1}})
            .value();
  }
  return t;
}

/// What passes through something when a box goes from one place to another in a substep, and has
/// that velocity there.
FindingList after_way(World w, Entity e, const Pose& to, Vec3 velocity = Vec3(0)) {
  ContactWatch watch;
  FindingList found;
  found.open();
  watch.compile(w);
  watch.begin_substep(w);
  w.bodies[e].pose = to, w.bodies[e].velocity = velocity;
  watch.end_substep(w, kStep, found);
  return found;
}

/// What is found after some time, of a report that says the same in each step.
template <class Fill>
FindingList after_reports(Real seconds, const Fill& fill) {
  Monitor monitor;
  World w;
  Body moving;
  moving.velocity = {2, 0, 0};  // 2 J
  const Entity e = w.add_body(moving);
  w = built(std::move(w));
  FindingList found;
  found.open();
  for (int i = 0; i < std::lround(seconds / kStep); ++i) {
    StepReport report;
    fill(report, e, i);
    monitor.end_step(w, kStep, report);
  }
  for (const Finding& f : monitor.findings()) found.note(f.kind, f.where, f.amount);
  return found;
}

}  // namespace

TEST_CASE("a joint beyond its limit is told from 0.05 rad on") {
  World w;
  const Entity ground = add_box(w, {0, -5, 0}, Vec3(1), Motion::fixed);
  const Entity flap = add_box(w, {0.5, 0, 0}, Vec3(0.1));
  const Entity hinge =
      w.add(HingeJoint{.a = ground, .b = flap, .axis = {0, 0, 1}, .limits = Interval{-0.5, 0.5}})
          .value();
  const World start = built(std::move(w));
  for (const Real over : {0.04, 0.06}) {
    const FindingList found = gaps_after(start, [&](World& now) {
      now.bodies[flap].pose.position = from_rotation_vector({0, 0, 0.5 + over}) * Vec3(0.5, 0, 0);
      turn(now, flap, {0, 0, 0.5 + over});
    });
    const Finding* limit = find(found, FindingKind::limit_exceeded);
    INFO(over);
    REQUIRE((limit != nullptr) == (over > 0.05));
    if (limit) CHECK(limit->where == hinge);
    if (limit) CHECK(limit->amount == Approx(over));
    CHECK_FALSE(find(found, FindingKind::joint_open));
  }
}

TEST_CASE("a hinge that is twisted off its axis is told too") {
  Wheels t = two_wheels();
  const World start = built(t.world);
  for (const Real askew : {0.04, 0.06}) {
    const FindingList found = gaps_after(start, [&](World& now) {
      turn(now, t.wheel[1], {askew, 0, 0});
    });
    const Finding* limit = find(found, FindingKind::limit_exceeded);
    REQUIRE((limit != nullptr) == (askew > 0.05));
    if (limit) CHECK(limit->where == t.hinge[1]);
  }
}

TEST_CASE("an exact pin that stays off its place is told, one on its way there is not") {
  for (const bool reachable : {true, false}) {
    World w;
    const Entity box = add_box(w, Vec3(0), Vec3(0.1));
    const Entity pin = w.add(PinConstraint{.body = box}).value();
    w = built(std::move(w));
    GapWatch watch;
    FindingList found;
    found.open();
    watch.compile(w);
    Pin& p = w.pins[pin];
    p.missed = true, p.residual = 0.02, p.reachable = reachable;
    for (int i = 0; i < 24; ++i) watch.end_step(w, kStep, found);
    CHECK(found.all().empty());
    for (int i = 0; i < 2; ++i) watch.end_step(w, kStep, found);
    const Finding* missed = find(found, FindingKind::pin_missed);
    REQUIRE((missed != nullptr) == reachable);
    if (missed) CHECK(missed->where == pin);
    if (missed) CHECK(missed->amount == 0.02);
  }
}

TEST_CASE("gears that lose their ratio are told from 0.01 rad on, turns counted") {
  Wheels t = two_wheels(Solver::lagrangian);
  const Entity gear =
      t.world.add(GearJoint{.first = t.hinge[0], .second = t.hinge[1], .ratio = -2}).value();
  const World start = built(t.world, Solver::lagrangian);
  for (const Real off : {0.015, 0.025}) {
    GapWatch watch;
    FindingList found;
    found.open();
    World now = start;
    watch.compile(now);
    for (int i = 0; i < 40; ++i) {  // 8 rad and 16 rad back
      turn(now, t.wheel[0], {0, 0, 0.2}), turn(now, t.wheel[1], {0, 0, -0.4});
      watch.end_step(now, kStep, found);
    }
    CHECK(found.all().empty());
    turn(now, t.wheel[1], {0, 0, off});
    watch.end_step(now, kStep, found);
    const Finding* slipped = find(found, FindingKind::gear_slipped);
    INFO(off);
    REQUIRE((slipped != nullptr) == (off > 0.02));  // of a ratio of 2
    if (slipped) CHECK(slipped->where == gear);
    if (slipped) CHECK(slipped->amount == Approx(off));
  }
}

TEST_CASE("a belt that runs along its pulley is told") {
  Wheels t = two_wheels(Solver::lagrangian);
  BeltJoint described;
  for (int i = 0; i < 2; ++i)
    described.pulleys.push_back({.body = t.wheel[i], .point = {1.0 * i, 0, 0}, .radius = 0.1});
  const Entity belt = t.world.add(described).value();
  const World start = built(t.world, Solver::lagrangian);
  const Real length = start.belts[belt].length;
  for (const Real part : {0.9e-3, 1.1e-3}) {
    const FindingList found = gaps_after(start, [&](World& now) {
      turn(now, t.wheel[1], {0, 0, part * length / 0.1});
    });
    const Finding* slipped = find(found, FindingKind::belt_slipped);
    INFO(part);
    REQUIRE((slipped != nullptr) == (part > 1e-3));
    if (slipped) CHECK(slipped->where == belt);
    if (slipped) CHECK(slipped->amount == Approx(part * length));
  }
}

TEST_CASE("surfaces that come apart are told, those that may lift only within one another") {
  for (const bool lifts : {false, true}) {
    World w;
    w.default_settings.solver = Solver::lagrangian;
    const Entity ball =
        w.add(RigidBody{.shape = SphereShape{.radius = 0.1}, .mass = 1.0, .position = {0, 0.1, 0}})
            .value();
    const Entity ground = w.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}}).value();
    const Entity joint = w.add(SurfaceJoint{.a = ball, .b = ground, .may_lift = lifts}).value();
    const World start = built(std::move(w), Solver::lagrangian);
    for (const Real gap : {0.9e-4, 1.1e-4, -0.9e-4, -1.1e-4}) {
      const FindingList found =
          gaps_after(start, [&](World& now) { now.surface_contacts[joint].gap = gap; });
      const Finding* apart = find(found, FindingKind::surfaces_apart);
      INFO(gap);
      REQUIRE((apart != nullptr) == (std::abs(gap) > 1e-4 && !(lifts && gap > 0)));
      if (apart) CHECK(apart->where == joint);
      if (apart) CHECK(apart->amount == std::abs(gap));
    }
  }
}

TEST_CASE("what lies too deep is told once it rests, what falls or lies higher is not") {
  struct Case {
    Real depth, speed, seconds;
  };
  // A hundredth of 0.2 m sqrt(3); 0.02 sqrt(9.81 * 0.2) m/s; half a second.
  for (const Case& c : {Case{3.6e-3, 0, 0.52}, Case{3.3e-3, 0, 0.52}, Case{3.6e-3, 0.03, 0.52},
                        Case{3.6e-3, 0, 0.48}}) {
    World w;
    const Entity floor = add_box(w, {0, -1, 0}, {5, 1, 5}, Motion::fixed);
    const Entity box = add_box(w, {0, 0.1, 0}, Vec3(0.1));
    w = built(std::move(w));
    w.gravity = {0, -9.81, 0};
    w.bodies[box].velocity = {0, -c.speed, 0};
    Contact touch;
    touch.slot_a = w.bodies.slot(box), touch.slot_b = w.bodies.slot(floor);
    touch.point_a = {0, -0.1, 0}, touch.depth = c.depth, touch.active = true;
    contacts_of(w).assign(1, touch);
    ContactWatch watch;
    FindingList found;
    found.open();
    watch.compile(w);
    for (int i = 0; i < std::lround(c.seconds / kStep); ++i) watch.end_step(w, kStep, found);
    const Finding* sunk = find(found, FindingKind::sunk);
    INFO(c.depth << " " << c.speed << " " << c.seconds);
    REQUIRE((sunk != nullptr) ==
            (c.depth > 2e-3 * std::sqrt(3.0) && c.speed < 0.028 && c.seconds > 0.5));
    if (sunk) CHECK(sunk->where == box);
    if (sunk) CHECK(sunk->amount == c.depth);
  }
}

TEST_CASE("what comes out on the other side of a plate is told, what stays on its side is not") {
  World w;
  const Entity box = add_box(w, {0, 0.5, 0}, Vec3(0.1));
  add_box(w, Vec3(0), {1, 0.01, 1}, Motion::fixed);
  const World start = built(std::move(w));
  const auto passes = [&](Vec3 to) {
    const FindingList found = after_way(start, box, {to, kIdentity});
    const Finding* passed = find(found, FindingKind::passed_through);
    if (passed) CHECK(passed->where == box);
    return passed != nullptr;
  };
  CHECK(passes({0, -0.5, 0}));
  CHECK(passes({0.3, -0.2, 0.2}));
  CHECK_FALSE(passes({0, 0.11, 0}));
  CHECK_FALSE(passes({0, 0.06, 0}));  // its edge is in the plate: not through it
  CHECK_FALSE(passes({3, -0.5, 0}));  // past the rim
  CHECK_FALSE(passes({0, 2, 0}));
}

TEST_CASE("what swings around a post does not pass through it, what swings through a wall does") {
  for (const bool wide : {false, true}) {
    World w;
    const Entity box = add_box(w, {1, 0, 0}, Vec3(0.1));
    const Real half_width = wide ? 0.4 : 0.1;
    const Quat askew = glm::angleAxis(kPi / 4, Vec3(0, 0, 1));
    add_box(w, {0.5, 0.5, 0}, {half_width, 0.05, 0.3}, Motion::fixed);
    for (Body& b : w.bodies.values())
      if (b.motion == Motion::fixed) b.pose.rotation = askew;
    w.bodies[box].velocity = {0, kPi / 2 / kStep, 0};
    const FindingList found =
        after_way(built(std::move(w)), box, {{0, 1, 0}, kIdentity}, {-kPi / 2 / kStep, 0, 0});
    CHECK((find(found, FindingKind::passed_through) != nullptr) == wide);
  }
}

TEST_CASE("what goes around the edge of a block does not pass through it") {
  World w;
  const Entity box = add_box(w, {0.3, 0.62, 0}, Vec3(0.1));
  add_box(w, {0, 0, 0}, Vec3(0.5), Motion::fixed);
  const World start = built(std::move(w));
  const auto passes = [&](Vec3 to) {
    return find(after_way(start, box, {to, kIdentity}), FindingKind::passed_through) != nullptr;
  };
  CHECK_FALSE(passes({0.62, 0.3, 0}));
  CHECK(passes({0.3, -0.62, 0}));
  CHECK(passes({-0.62, -0.1, 0}));
}

TEST_CASE("what falls below the ground, and what a fast plate goes through, is told") {
  for (const bool collides : {true, false}) {
    World w;
    const Entity ground =
        w.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}})
            .value();
    const Entity box = add_box(w, {0, 0.5, 0}, Vec3(0.1));
    const Entity plate = add_box(w, {-1, 0.5, 0}, {0.01, 0.3, 0.3}, Motion::kinematic);
    if (!collides)
      for (const Entity e : {ground, plate}) w.collisions[e].groups = 2, w.collisions[e].with = 2;
    const World start = built(std::move(w));
    CHECK((find(after_way(start, box, {{0, -0.05, 0}, kIdentity}), FindingKind::passed_through) !=
           nullptr) == collides);
    CHECK_FALSE(
        find(after_way(start, box, {{0, 0.06, 0}, kIdentity}), FindingKind::passed_through));
    const FindingList found = after_way(start, plate, {{1, 0.5, 0}, kIdentity});
    const Finding* passed = find(found, FindingKind::passed_through);
    REQUIRE((passed != nullptr) == collides);
    if (passed) CHECK(passed->where == box);
  }
}

TEST_CASE("a body that is placed anew, or joined to what it meets, does not pass through it") {
  World w;
  const Entity box = add_box(w, {0, 0.5, 0}, Vec3(0.1));
  const Entity plate = add_box(w, Vec3(0), {1, 0.01, 1}, Motion::fixed);
  World placed = built(w);
  placed.bodies[box].teleport = true;
  CHECK(after_way(placed, box, {{0, -0.5, 0}, kIdentity}).all().empty());
  w.add(BallJoint{.a = plate, .b = box}).value();
  CHECK(after_way(built(std::move(w)), box, {{0, -0.5, 0}, kIdentity}).all().empty());
}

TEST_CASE("a joined body that turns too far in a step is told, by its solver's range") {
  struct Case {
    Solver solver;
    Integrator integrator;
    Real range;  // rad; 0: none
  };
  for (const Case& c : {Case{Solver::articulated, Integrator::rk4, 1},
                        Case{Solver::lagrangian, Integrator::implicit, 0.5},
                        Case{Solver::lagrangian, Integrator::radau, 0}})
    for (const Real turn_by : {0.45, 0.55, 0.95, 1.05}) {
      World w;
      w.default_settings.integrator = c.integrator;
      const Entity rod = add_box(w, {0.5, 0, 0}, {0.5, 0.02, 0.02});
      const Entity ground = add_box(w, {0, -5, 0}, Vec3(1), Motion::fixed);
      w.add(BallJoint{.a = ground, .b = rod}).value();
      w = built(std::move(w), c.solver);
      TurnWatch watch;
      watch.compile(w);
      const auto turned = [&](Vec3 axis) {
        FindingList found;
        found.open();
        w.bodies[rod].angular_velocity = turn_by / kStep * axis;
        for (Real way = 0; way < 2 * kPi; way += turn_by) {
          CHECK(found.all().empty());  // it may be a blow
          watch.end_substep(w, kStep, {}, found);
        }
        watch.end_substep(w, kStep, {}, found);
        return find(found, FindingKind::turned_too_far) != nullptr;
      };
      INFO(name_of(c.solver) << " " << turn_by);
      CHECK(turned({0, 0, 1}) == (c.range > 0 && turn_by > c.range));
      CHECK_FALSE(turned({1, 0, 0}));  // about its own axis, on which the joint lies
    }
}

TEST_CASE("what rolls by more than a quarter turn in a step of lagrangian is told, balls are not") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const bool is_ball : {false, true})
      for (const Real turn_by : {0.9, 2.0}) {
        World w;
        w.default_settings.solver = solver;
        const Real r = 0.1, spin = turn_by * 60;
        RigidBody roller{.shape = CapsuleShape{.radius = r, .half_length = r}, .mass = 1};
        if (is_ball) roller.shape = SphereShape{.radius = r};
        roller.position = {0, r, 0}, roller.rotation = glm::angleAxis(kPi / 2, Vec3(1, 0, 0));
        roller.velocity = {spin * r, 0, 0}, roller.angular_velocity = {0, 0, -spin};
        roller.collision = Collision{};
        const Entity on = w.add(roller).value();
        w.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}})
            .value();
        Simulation sim(std::move(w), {1.0 / 60});
        sim.settings.watch = true;
        for (int i = 0; i < 12; ++i) sim.step();
        const auto all = sim.findings();
        const bool told = std::any_of(all.begin(), all.end(), [&](const Finding& f) {
          return f.kind == FindingKind::turned_too_far && f.where == on;
        });
        INFO(name_of(solver) << (is_ball ? " ball " : " capsule ") << turn_by);
        CHECK(told == (solver == Solver::lagrangian && !is_ball && turn_by > 1.5));
      }
}

TEST_CASE("a spring that swings faster than its solver's range is told while it swings") {
  constexpr Real kInertia = 1.0 / 6 * 0.04 + 0.25;  // of a box of 0.2 m, 0.5 m from its hinge
  for (const Real swing : {1.4, 1.6})
    for (const Real damping_ratio : {0.0, 0.6})
      for (const Real moved : {0.01, 0.03}) {
        World w;
        const Entity ground = add_box(w, {0, -5, 0}, Vec3(1), Motion::fixed);
        const Entity flap = add_box(w, {0.5, 0, 0}, Vec3(0.1));
        const Real stiffness = kInertia * (swing / kStep) * (swing / kStep);
        const Real damping = 2 * damping_ratio * std::sqrt(stiffness * kInertia);
        const Entity hinge =
            w.add(HingeJoint{.a = ground,
                             .b = flap,
                             .axis = {0, 0, 1},
                             .spring = {.stiffness = stiffness, .damping = damping}})
                .value();
        w = built(std::move(w));
        std::vector<EnergyStore> stores;
        list_stores(w, stores);
        REQUIRE(stores.size() == 1);
        stores[0].moved = moved;
        TurnWatch watch;
        FindingList found;
        found.open();
        watch.compile(w);
        watch.end_substep(w, kStep, stores, found);
        const Finding* spring = find(found, FindingKind::spring_unresolved);
        INFO(swing << " " << damping_ratio << " " << moved);
        REQUIRE((spring != nullptr) == (swing > 1.5 && damping_ratio < 0.5 && moved > 0.02));
        if (spring) CHECK(spring->where == hinge);
        if (spring) CHECK(spring->amount == Approx(swing));
      }
}

TEST_CASE("what the limiter takes counts from a quarter of the energy of motion on") {
  for (const Real removed : {4e-3, 6e-3}) {  // in a second 0.4 and 0.6 J of 2 J
    const FindingList found = after_reports(
        2, [&](StepReport& r, Entity e, int) { r.energy_removed = removed, r.limited_at = e; });
    CHECK((find(found, FindingKind::energy_limited) != nullptr) == (removed > 5.8e-3));
  }
}

TEST_CASE("what the limiter, a rescue and contacts do now and then is none, as a habit it is") {
  for (const int every : {1, 10, 30}) {
    const FindingList found = after_reports(2, [&](StepReport& r, Entity e, int i) {
      if (i % every != 0) return;
      r.energy_removed = 0.5, r.limited_at = e;
      r.rescued = 1, r.rescued_at = e;
      r.unsolved = 2, r.unsolved_at = e;
    });
    INFO(every);
    for (const FindingKind kind :
         {FindingKind::energy_limited, FindingKind::step_rescued, FindingKind::contacts_unsolved}) {
      const Finding* habit = find(found, kind);
      REQUIRE((habit != nullptr) == (every < 20));
      if (!habit) continue;
      const Real times = 200.0 / every;
      CHECK(habit->amount == Approx(times * (kind == FindingKind::energy_limited ? 0.5 : kStep)));
      CHECK(habit->where);
    }
  }
}
