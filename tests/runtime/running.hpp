#pragma once
/// Worlds with everything that solvers remember: contacts, cables, stops, motors, gears,
/// interfaces.
#include <string>
#include <utility>
#include <vector>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

namespace pantin::test {

using namespace detail;

inline Entity add_box(World& w, Vec3 at, Motion motion, Real restitution = 0) {
  Body b;
  b.pose.position = at, b.motion = motion;
  b.pose.rotation = from_rotation_vector({0.1, 0.2, 0.3});
  b.inertia = Vec3(0.01);
  const Entity e = w.add_body(b);
  w.shapes.add(e, {{{ShapeKind::box, Vec3(0.1), {}, 0, nullptr}}});
  w.collisions.add(e, {0.4, restitution, 1, UINT32_MAX, true, true});
  return e;
}

/// Boxes that fall on one another, a hanging chain among them.
inline World falling_pile() {
  World w = hung_chain(4).world;
  Body ground;
  ground.motion = Motion::fixed, ground.pose.position.y = -1;
  const Entity g = w.add_body(ground);
  w.shapes.add(g, {{{ShapeKind::plane, {5, 0, 0}, {}, 0, nullptr}}});
  w.collisions.add(g, {});
  for (int i = 0; i < 4; ++i)
    add_box(w, {0.03 * i, -0.85 + 0.25 * i, 0.02 * i}, Motion::dynamic, i == 1 ? 0.5 : 0);
  return w;
}

/// Links with stops, a soft zone, a drive that is capped; forces that end.
inline World stopped_arm() {
  Chain chain = hung_chain(4);
  World& w = chain.world;
  for (std::size_t i = 0; i < chain.links.size(); ++i) {
    Joint& j = w.links[chain.links[i]].joint;
    j.kind = i % 2 == 0 ? JointKind::hinge : JointKind::ball;
    j.frames =
        JointFrames(from_rotation_vector({0, kPi / 2, 0}), from_rotation_vector({0, kPi / 2, 0}));
    j.limits = JointLimits{{true, -0.3, 0.4}, {}, {i % 2 == 1, 0.5, 0.3}, 0.1, 2, 0.1};
  }
  w.joint_drives.add(chain.links[1], {from_rotation_vector({0.2, 0, 0}), 30, 1, 0.5, {}, false});
  return w;
}

/// A kinematic bar, two geared wheels with stops, a motor and a spring, moved by the Lagrangian
/// solver.
inline World geared_wheels(Integrator integrator) {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  w.default_settings.integrator = integrator;
  if (info_of(integrator).takes_tolerance) w.default_settings.step_tolerance = 1e-5;
  Body frame;
  frame.motion = Motion::kinematic;
  const Entity base = w.add_body(frame);
  Lissajous sway;
  sway.amplitude = {0.1, 0, 0}, sway.frequency = {1, 0, 0};
  w.paths.add(base, {sway});
  Entity wheels[2], links[2];
  for (int i = 0; i < 2; ++i) {
    Body wheel;
    wheel.pose.position = {0.5 * i, 0.1, 0}, wheel.inertia = {0.1, 0.2, 0.2};
    wheel.angular_velocity = {2, 0, 0};
    wheels[i] = w.add_body(wheel);
    Joint j{{0.5 * i, 0, 0}, {0, -0.1, 0}, JointKind::hinge};
    links[i] = add_link(w, {base, wheels[i], j});
  }
  w.bodies[wheels[1]].angular_velocity = {4, 0, 0};
  JointParameters& e = w.links[links[0]].joint.parameters.edit();
  e.rotation.spring = {3, 0.1, 0.2};
  e.rotation.motor = {MotorKind::velocity, 30, 2, 0, 5};
  add_gear(w, {links[0], links[1], false, false, 2, 0, false});
  Body bob;
  bob.pose.position = {1, 0, 0};
  const Entity hanging = w.add_body(bob);
  Joint ball{{0.5, 0, 0}, {-0.5, 0, 0}, JointKind::ball};
  ball.limits = JointLimits{{}, {}, {true, 0.6, 0.6}, 0, 0, 0};
  add_link(w, {base, hanging, ball});
  add_cable(w, {base, hanging, {Vec3(0), {0.1, 0, 0}, 1.15, 0}});
  return w;
}

/// A chain of the articulated solver that hangs on a beam of the Lagrangian one.
inline World chain_on_beam() {
  World w;
  Body beam;
  beam.mass = 3;
  const Entity b = w.add_body(beam);
  SolverSettings lagrangian;
  lagrangian.solver = Solver::lagrangian;
  w.settings.add(b, lagrangian);
  Body ground;
  ground.motion = Motion::fixed;
  add_link(w, {w.add_body(ground), b, {{0, 0.5, 0}, {0, 0.5, 0}, JointKind::ball}});
  Entity above;
  for (int i = 0; i < 3; ++i) {
    const Entity rod_i = w.add_body(rod({0.3 + kHalfLink * (2 * i + 1), 0, 0}));
    if (i == 0) {
      Pin pin;
      pin.body = rod_i, pin.anchor = {-kHalfLink, 0, 0}, pin.target = {0.3, 0, 0}, pin.to = b;
      w.add_pin(pin);
    } else {
      add_link(w, {above, rod_i, {{kHalfLink, 0, 0}, {-kHalfLink, 0, 0}}});
    }
    above = rod_i;
  }
  return w;
}

inline std::vector<std::pair<std::string, World>> running_worlds() {
  std::vector<std::pair<std::string, World>> all{{"puppet", swaying_puppet().world},
                                                 {"chain", hung_chain(5).world},
                                                 {"pile", falling_pile()},
                                                 {"arm", stopped_arm()},
                                                 {"beam", chain_on_beam()}};
  for (Integrator i : {Integrator::euler, Integrator::rattle, Integrator::rk4, Integrator::implicit,
                       Integrator::radau})
    all.emplace_back(std::string("wheels ") + name_of(i), geared_wheels(i));
  for (Solver s : {Solver::sweep, Solver::shake2, Solver::procedural}) {
    all.emplace_back(std::string("chain ") + name_of(s), hung_chain(5).world);
    all.back().second.default_settings.solver = s;
  }
  return all;
}

}  // namespace pantin::test
