// Towers with springs, friction and motors at joints, closed loops, springs between points and
// rolling friction: they stand still and bear their weight, as those without.
#include <catch2/catch.hpp>

#include "engine/pantin/measure.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

struct Frame : Standing {
  explicit Frame(int count, Real from = 0) : Standing(0.6) {
    for (int i = 0; i < count; ++i) add({0, from + 0.15 + 0.3 * i, 0}, Vec3(0.15), 300);
  }
  Entity join(Entity a, Entity b, JointKind kind, Vec3 at, const Dof& dof = {}) {
    Joint joint = joint_at(world, a, b, kind, at, frame_along({0, 0, 1}));
    if (dof.any()) joint.parameters.edit().rotation = dof;
    return add_link(world, {a, b, joint});
  }
  Entity top() const { return blocks.back(); }
};

Dof spring(Real stiffness, Real damping) {
  Dof dof;
  dof.spring.stiffness = stiffness, dof.spring.damping = damping;
  return dof;
}
Dof friction(Real dry) {
  Dof dof;
  dof.friction.dry = dry;
  return dof;
}
Dof motor(MotorKind kind, Real target, Real gain, Real cap) {
  Dof dof;
  dof.motor.kind = kind, dof.motor.target = target, dof.motor.gain = gain, dof.motor.cap = cap;
  return dof;
}

/// Ten boxes; on the top one a rod of 50 g, upright on a hinge with `dof`.
Frame rod_on_ten(const Dof& dof) {
  Frame s(10);
  const Entity box = s.top(), rod = s.add({0, 3.15, 0}, {0.01, 0.15, 0.01}, 200);
  s.join(box, rod, JointKind::hinge, {0, 3, 0}, dof);
  return s;
}
/// Ten boxes on a table whose legs are joined to its top and to one another: a redundant loop.
Frame braced_table(JointKind kind) {
  Frame s(10, 0.4);
  const Entity top = s.add({0, 0.35, 0}, {0.5, 0.05, 0.5}, 300);
  const Entity left = s.add({-0.4, 0.15, 0}, {0.1, 0.15, 0.5}, 300);
  const Entity right = s.add({0.4, 0.15, 0}, {0.1, 0.15, 0.5}, 300);
  s.join(left, top, JointKind::fixed, {-0.4, 0.3, 0});
  s.join(right, top, JointKind::fixed, {0.4, 0.3, 0});
  s.join(left, right, kind, {0, 0.15, 0});
  return s;
}
/// Two towers of five whose neighbours are held together by springs between their centres.
Frame sprung_pair() {
  Frame s(0);
  for (int i = 0; i < 5; ++i) {
    const Entity a = s.add({-0.2, 0.15 + 0.3 * i, 0}, Vec3(0.15), 300);
    const Entity b = s.add({0.2, 0.15 + 0.3 * i, 0}, Vec3(0.15), 300);
    Pin pin;
    pin.body = a, pin.to = b, pin.anchor = {0.15, 0, 0}, pin.target = {-0.25, 0, 0};
    pin.kind = PinKind::spring, pin.stiffness = 1000, pin.damping = 20;
    s.world.add_pin(pin);
  }
  return s;
}

}  // namespace

TEST_CASE("towers with actuated joints stand still and bear their weight") {
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240})
    for (const auto& [name, standing] : {
             std::pair("rod on a spring", rod_on_ten(spring(5, 0.05))),
             std::pair("rod held by a motor", rod_on_ten(motor(MotorKind::velocity, 0, 10, 1))),
             std::pair("rod held by a weak motor",
                       rod_on_ten(motor(MotorKind::position, 0, 10, 0.02))),
         }) {
      INFO(name << " at " << h);
      standing.stays(h, 3, 1e-4, Standing::Ends::awake);
    }
}

TEST_CASE("towers with friction, loops and springs stand still, bear their weight and sleep") {
  Frame rolling(0);
  rolling.of.rolling = 0.01, rolling.of.spinning = 0.01;
  for (int i = 0; i < 10; ++i) rolling.add({0, 0.15 + 0.3 * i, 0}, Vec3(0.15), 300);
  for (const Real h : {1.0 / 30, 1.0 / 60, 1.0 / 240})
    for (const auto& [name, standing] : {
             std::pair("rod held by friction", rod_on_ten(friction(1))),
             std::pair("braced table", braced_table(JointKind::fixed)),
             std::pair("table braced at a point", braced_table(JointKind::ball)),
             std::pair("towers held together by springs", sprung_pair()),
             std::pair("tower with rolling friction", rolling),
         }) {
      INFO(name << " at " << h);
      standing.stays(h, 3, 1e-4);
    }
}
