#include "tools/study/stiff.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/world/ties.hpp"

namespace pantin::study {
namespace {

Quat along(Vec3 axis) {
  return from_rotation_vector(axis.x > 0 ? Vec3(0) : 0.5 * kPi * Vec3(0, -axis.z, axis.y));
}

/// A point and an axis (x, y or z) of the world.
struct Place {
  Vec3 point, axis;
};

/// A hinge there, its x along the axis, of bodies as they stand.
Joint joint_at(const World& w, Entity a, Entity b, const Place& at) {
  const Pose &pa = w.bodies[a].pose, &pb = w.bodies[b].pose;
  Joint j;
  j.kind = JointKind::hinge;
  j.anchor_a = glm::conjugate(pa.rotation) * (at.point - pa.position);
  j.anchor_b = glm::conjugate(pb.rotation) * (at.point - pb.position);
  j.frames.set(glm::conjugate(pa.rotation) * along(at.axis),
               glm::conjugate(pb.rotation) * along(at.axis));
  return j;
}

}  // namespace

World governor(Real stiffness, Real damping) {
  const Vec3 up(0, 1, 0), half(0, 0.5, 0), spin = 2 * kPi * up;
  World w;
  w.default_settings.solver = Solver::lagrangian;
  Body still;
  still.motion = Motion::fixed;
  const Entity ground = w.add_body(still);
  const auto add = [&](Real mass, Vec3 inertia, Pose at) {
    Body b;
    b.mass = mass, b.inertia = inertia, b.pose = at, b.drag = 0;
    b.angular_velocity = spin, b.velocity = glm::cross(spin, at.position);
    return w.add_body(b);
  };
  const Entity axis = add(200, {25, 1, 25}, {});
  add_link(w, {ground, axis, joint_at(w, ground, axis, {Vec3(0), up})});
  const Entity slider = add(3, Vec3(0.02), {half, kIdentity});
  Joint slide = joint_at(w, axis, slider, {half, up});
  slide.kind = JointKind::prismatic;
  add_link(w, {axis, slider, slide});
  for (const Real side : {-0.5, 0.5}) {
    const Vec3 down(side, -std::sqrt(0.75), 0);
    const Quat turned = from_rotation_vector({0, 0, std::atan2(down.y, down.x)});
    // A rod of 3 kg and 1 m with 5 kg at its end.
    const Entity rod = add(8, {0.01, 0.73, 0.73}, {up + 0.8125 * down, turned});
    add_link(w, {axis, rod, joint_at(w, axis, rod, {up, {0, 0, 1}})});
    Joint spring;
    spring.kind = JointKind::spring;
    spring.anchor_b = {0.5 - 0.8125, 0, 0};
    spring.parameters.edit().translation.spring = {stiffness, damping, 0.5};
    add_link(w, {slider, rod, spring});
  }
  return w;
}

void measure_stiff(std::FILE* out, Extent extent) {
  const bool small = extent == Extent::few_points;
  constexpr Real kStep = 0.02;
  const int steps = small ? 5 : 100;
  const World start = governor(8e5, 4e4);
  const auto run = [&](Integrator by, Real tolerance, int divisions) {
    World w = start;
    w.default_settings.integrator = by, w.default_settings.step_tolerance = tolerance;
    Simulation sim(std::move(w), {kStep / divisions});
    for (int i = 0; i < steps * divisions; ++i)
      if (sim.step().status != Status::ok) break;
    return sim.world;
  };
  const World exact = run(Integrator::rk4, small ? 1e-10 : 1e-12, 1);
  std::fprintf(out, "integrator,step_s,tolerance,error,cpu_s\n");
  const auto point = [&](Integrator by, Real tolerance, int divisions) {
    std::vector<double> times;
    Real error = 0;
    for (int i = 0; i < (small ? 1 : 3); ++i) {
      const double from = cpu_seconds();
      const World end = run(by, tolerance, divisions);
      times.push_back(cpu_seconds() - from);
      error = difference(end, exact);
    }
    std::fprintf(out, "%s,%g,%g,%.2e,%.4f\n", name_of(by), kStep / divisions, tolerance, error,
                 median(times));
    std::fflush(out);
  };
  for (const Integrator by : {Integrator::rk4, Integrator::radau})
    for (Real tolerance = 1e-3; tolerance > (small ? 1e-5 : 5e-12); tolerance *= 0.1)
      point(by, tolerance, 1);
  for (const Integrator by : {Integrator::implicit, Integrator::radau})
    for (int divisions = 1; divisions <= (small ? 2 : 64); divisions *= 2) point(by, 0, divisions);
}

}  // namespace pantin::study
