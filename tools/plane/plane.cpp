// Cost and error of the planar solver, beside a world of Box2D that is kept, and beside the solvers
// of space on the same planar Worlds. Writes CSV: problem, method, microseconds a step, error.
#include <box2d/box2d.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/belt.hpp"
#include "engine/world/ties.hpp"

namespace {

using namespace pantin;
using namespace pantin::detail;

constexpr int kSteps = 300, kRounds = 5;
constexpr Real kStep = 1.0 / 60;
constexpr Real kSpin = 12;  // rad/s, of the first pulley of each pair

/// Microseconds a step, the least of some rounds; `round` takes kSteps of a World made anew.
Real cost_of(const std::function<std::function<void()>()>& begin) {
  Real least = 1e300;
  for (int i = 0; i < kRounds; ++i) {
    const std::function<void()> step = begin();
    const auto from = std::chrono::steady_clock::now();
    for (int k = 0; k < kSteps; ++k) step();
    const std::chrono::duration<Real> spent = std::chrono::steady_clock::now() - from;
    least = std::min(least, 1e6 * spent.count() / kSteps);
  }
  return least;
}

void tell(const char* problem, const char* method, Real cost, Real error) {
  std::printf("%s,%s,%.3g,%.3g\n", problem, method, cost, error);
  std::fflush(stdout);
}

// ---- Worlds of ours ----

Entity add_ground(World& w) {
  Body b;
  b.motion = Motion::fixed;
  return w.add_body(b);
}

Entity add_part(World& w, Vec3 at, Vec3 inertia) {
  Body b;
  b.mass = 1, b.inertia = inertia, b.pose.position = at;
  return w.add_body(b);
}

void tie(World& w, Entity a, Entity b, Vec3 at) {
  Joint j;
  j.kind = JointKind::hinge;
  j.anchor_a = to_local(w.bodies[a].pose, at), j.anchor_b = to_local(w.bodies[b].pose, at);
  const Real half = std::sqrt(0.5);
  j.frames.set(Quat(half, 0, -half, 0), Quat(half, 0, -half, 0));  // x along z
  add_link(w, {a, b, j});
}

World boxes() {
  World w;
  w.default_settings.sleep_speed = 0;
  const Entity ground = add_ground(w);
  Shape plane;
  plane.kind = ShapeKind::plane, plane.size = {100, 0, 0};
  w.shapes.add(ground, {{plane}}), w.collisions.add(ground, {});
  for (int i = 0; i < 100; ++i) {
    const Entity e = add_part(w, {0.5 * (i / 10), 0.1 + 0.2 * (i % 10), 0}, Vec3(0.04 / 6));
    Shape box;
    box.kind = ShapeKind::box, box.size = Vec3(0.1);
    w.shapes.add(e, {{box}}), w.collisions.add(e, {});
  }
  return w;
}

World hinges() {
  World w;
  w.default_settings.sleep_speed = 0;
  Entity above = add_ground(w);
  for (int i = 0; i < 100; ++i) {
    const Entity e = add_part(w, {0.1 * i + 0.05, 0, 0}, Vec3(1e-4, 1e-3, 1e-3));
    tie(w, above, e, {0.1 * i, 0, 0}), above = e;
  }
  return w;
}

World belts() {
  World w;
  w.default_settings.sleep_speed = 0;
  const Entity ground = add_ground(w);
  for (int i = 0; i < 10; ++i) {
    Belt belt;
    std::vector<Pose> poses;
    for (int k = 0; k < 2; ++k) {
      const Entity e = add_part(w, {3.0 * k, 3.0 * i, 0}, Vec3(1));
      tie(w, ground, e, {3.0 * k, 3.0 * i, 0});
      w.bodies[e].angular_velocity.z = kSpin / (k + 1);
      BeltPulley p;
      p.body = e, p.outline.radius = 0.5 * (k + 1);
      belt.pulleys.push_back(p), poses.push_back(w.bodies[e].pose);
    }
    lay_belt(belt, poses);
    add_belt(w, belt);
  }
  return w;
}

/// m or rad: overlaps, open joints, or what a belt's wheels have turned too far.
Real error_of(const World& w, const StepReport& report, Real turned) {
  if (!w.belts.empty()) return turned;
  if (w.links.empty()) return report.worst_depth;
  return measure(w).worst_gap;
}

/// How far the turns of the first belt's wheels are from their ratio, counted from step to step.
struct Ratio {
  Real before[2] = {0, 0}, turned[2] = {0, 0};
  Real add(Real first, Real second) {
    const Real now[2] = {first, second};
    for (int i = 0; i < 2; ++i)
      turned[i] += std::remainder(now[i] - before[i], 2 * kPi), before[i] = now[i];
    return std::abs(turned[1] - 0.5 * turned[0]);
  }
};

Real angle_of(const World& w, std::size_t slot) {
  const Quat q = w.bodies.values()[slot].pose.rotation;
  return 2 * std::atan2(q.z, q.w);
}

void measure_ours(const char* problem, const World& start, Solver solver) {
  World w = start;
  w.default_settings.solver = solver;
  StepSettings settings;
  settings.h = kStep;
  const Real cost = cost_of([&] {
    auto copy = std::make_shared<World>(w);
    return [copy, settings] { step_world(*copy, settings, {}, {}); };
  });
  Real error = 0;
  Ratio ratio;
  for (int i = 0; i < kSteps; ++i) {
    const StepReport report = step_world(w, settings, {}, {});
    const Real turned = w.belts.empty() ? 0 : ratio.add(angle_of(w, 1), angle_of(w, 2));
    error = std::max(error, error_of(w, report, turned));
  }
  tell(problem, name_of(solver), cost, error);
}

// ---- Worlds of Box2D, kept ----

struct Kept {
  b2World world{b2Vec2(0, -9.81f)};
  std::vector<b2Body*> parts;
  std::vector<b2Joint*> joints;
  int substeps = 1;
  void step() {
    for (int i = 0; i < substeps; ++i)
      world.Step(static_cast<float>(kStep) / static_cast<float>(substeps), 8, 3);
  }
  b2Body* add(b2Vec2 at, float inertia) {
    b2BodyDef how;
    how.type = b2_dynamicBody, how.position = at, how.allowSleep = false;
    b2Body* body = world.CreateBody(&how);
    const b2MassData mass{1, b2Vec2(0, 0), inertia};
    body->SetMassData(&mass);
    parts.push_back(body);
    return body;
  }
  b2Joint* tie(b2Body* a, b2Body* b, b2Vec2 at) {
    b2RevoluteJointDef d;
    d.Initialize(a, b, at);
    joints.push_back(world.CreateJoint(&d));
    return joints.back();
  }
};

using Make = std::shared_ptr<Kept> (*)();

std::shared_ptr<Kept> kept_boxes() {
  auto k = std::make_shared<Kept>();
  b2BodyDef how;
  b2PolygonShape shape;
  shape.SetAsBox(100, 1, b2Vec2(0, -1), 0);
  k->world.CreateBody(&how)->CreateFixture(&shape, 0);
  for (int i = 0; i < 100; ++i) {
    const auto column = static_cast<float>(i / 10), row = static_cast<float>(i % 10);
    b2Body* body = k->add({0.5f * column, 0.1f + 0.2f * row}, 0.04f / 6);
    shape.SetAsBox(0.1f, 0.1f);
    b2FixtureDef fixture;
    fixture.shape = &shape, fixture.friction = 0.5f, fixture.density = 0;
    body->CreateFixture(&fixture);
    const b2MassData mass{1, b2Vec2(0, 0), 0.04f / 6};
    body->SetMassData(&mass);
  }
  return k;
}

std::shared_ptr<Kept> kept_hinges() {
  auto k = std::make_shared<Kept>();
  b2BodyDef how;
  b2Body* above = k->world.CreateBody(&how);
  for (int i = 0; i < 100; ++i) {
    const float x = 0.1f * static_cast<float>(i);
    b2Body* body = k->add({x + 0.05f, 0}, 1e-3f);
    k->tie(above, body, {x, 0}), above = body;
  }
  return k;
}

std::shared_ptr<Kept> kept_belts() {
  auto k = std::make_shared<Kept>();
  b2BodyDef how;
  b2Body* ground = k->world.CreateBody(&how);
  for (int i = 0; i < 10; ++i) {
    b2GearJointDef gear;
    for (int n = 0; n < 2; ++n) {
      const b2Vec2 at(3.0f * static_cast<float>(n), 3.0f * static_cast<float>(i));
      b2Body* body = k->add(at, 1);
      body->SetAngularVelocity(static_cast<float>(kSpin) / static_cast<float>(n + 1));
      (n ? gear.joint2 : gear.joint1) = k->tie(ground, body, at);
      (n ? gear.bodyB : gear.bodyA) = body;
    }
    gear.ratio = -2;
    k->world.CreateJoint(&gear);
  }
  return k;
}

Real error_of(Kept& k) {
  Real worst = 0;
  for (const b2Joint* j : k.joints)
    worst = std::max(worst, Real((j->GetAnchorA() - j->GetAnchorB()).Length()));
  for (const b2Contact* c = k.world.GetContactList(); c; c = c->GetNext()) {
    b2WorldManifold at;
    c->GetWorldManifold(&at);
    for (int i = 0; i < c->GetManifold()->pointCount; ++i)
      worst = std::max(worst, -Real(at.separations[i]));
  }
  return worst;
}

void measure_kept(const char* problem, Make make, int substeps) {
  const auto begin = [&] {
    auto k = make();
    k->substeps = substeps;
    return k;
  };
  const Real cost = cost_of([&] {
    auto k = begin();
    return [k] { k->step(); };
  });
  const auto k = begin();
  const bool is_belts = std::string_view(problem) == "belts";
  Real error = 0;
  for (int i = 0; i < kSteps; ++i) {
    k->step();
    const Real turned =
        std::abs(Real(k->parts[1]->GetAngle()) - 0.5 * Real(k->parts[0]->GetAngle()));
    error = std::max(error, is_belts ? turned : error_of(*k));
  }
  tell(problem, substeps == 1 ? "box2d" : "box2d_4", cost, error);
}

}  // namespace

int main() {
  struct Problem {
    const char* name;
    World (*ours)();
    Make kept;
  };
  std::puts("problem,method,us,error");
  for (const Problem& p :
       {Problem{"boxes", boxes, kept_boxes}, Problem{"hinges", hinges, kept_hinges},
        Problem{"belts", belts, kept_belts}}) {
    measure_kept(p.name, p.kept, 1), measure_kept(p.name, p.kept, 4);
    const World w = p.ours();
    for (const Solver s : {Solver::planar, Solver::lagrangian, Solver::articulated})
      if (s != Solver::articulated || w.belts.empty()) measure_ours(p.name, w, s);
  }
}
