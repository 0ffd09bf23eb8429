// The runs that `pantin modes --against dynamics` compares, and the quasi-static assumptions they
// violate.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/contact/memory.hpp"
#include "engine/runtime/simulation.hpp"
#include "tools/pantin/modes_against.hpp"

namespace pantin::program {
namespace {

constexpr double kSlips = 0.2;    // of the fastest finger's speed: above it the contact slides
constexpr double kSettled = 0.1;  // fraction of the duration in which dynamics settles from rest

/// A simulation, its lamina and the fingers in the order of the plan.
struct DynamicCourse {
  Simulation sim;
  Entity lamina;
  std::vector<Entity> fingers;
  double slides = 0;  // m/s: above this slip speed a contact slides
};

struct Slip {
  double normal = 0, tangent = 0, speed = 0;
  bool bears = false;
};

/// The present contact of a finger with the lamina.
Slip slip_at(const World& world, Entity lamina, Entity finger) {
  Slip s;
  const std::uint32_t a = world.bodies.slot(lamina), b = world.bodies.slot(finger);
  const Body &body = world.bodies[lamina], &of_finger = world.bodies[finger];
  for (const pantin::Contact& c : contacts_of(world)) {
    if (c.slot_a != a || c.slot_b != b || !c.active) continue;
    const Vec3 along(-c.normal.y, c.normal.x, 0);
    const Vec3 arm = body.pose.rotation * c.point_a;
    const Vec3 v = body.velocity + glm::cross(body.angular_velocity, arm) - of_finger.velocity;
    const double tangent = glm::dot(v, along);
    s.normal += glm::dot(c.force, c.normal), s.tangent += glm::dot(c.force, along);
    if (std::abs(tangent) > std::abs(s.speed)) s.speed = tangent;
    s.bears = true;
  }
  return s;
}

/// One row: steps until `target` (s); before each the friction is set by slip.
bool run_row(DynamicCourse& s, const LaminaPlan& plan, double target, Row& row) {
  World& world = s.sim.world;
  const double step = s.sim.settings.h, start = world.time;
  const Vec3 before = world.bodies[s.lamina].velocity;
  double steps = 0;
  row.fingers.assign(s.fingers.size(), {});
  while (world.time < target - 1e-9) {
    for (std::size_t i = 0; i < s.fingers.size(); ++i) {
      const Slip slip = slip_at(world, s.lamina, s.fingers[i]);
      const FingerPlan& f = plan.fingers[i];
      world.material_pairs[i].friction = std::abs(slip.speed) > s.slides ? f.slide : f.roll;
    }
    s.sim.settings.h = std::min(step, target - world.time);
    if (s.sim.step().status == Status::diverged || interrupted()) return false;
    ++steps;
    for (std::size_t i = 0; i < s.fingers.size(); ++i) {
      const Slip slip = slip_at(world, s.lamina, s.fingers[i]);
      AtFinger& f = row.fingers[i];
      f.normal += slip.normal, f.tangent += slip.tangent, f.bears += slip.bears;
      f.slip = std::max(f.slip, std::abs(slip.speed));
    }
  }
  s.sim.settings.h = step;
  for (AtFinger& f : row.fingers)
    if (steps > 0) f.normal /= steps, f.tangent /= steps, f.bears /= steps;
  const Pose& pose = world.bodies[s.lamina].pose;
  const Quat q = world.origin_pose(s.lamina).rotation;
  row.at = {pose.position.x, pose.position.y}, row.angle = 2 * std::atan2(q.z, q.w);
  if (world.time > start)
    row.inertia =
        plan.mass * glm::length(world.bodies[s.lamina].velocity - before) / (world.time - start);
  return true;
}

Row row_of(const Course& course) {
  Row row;
  row.at = course.centre(), row.angle = course.stepper.placed.angle;
  row.fingers.resize(course.plan.fingers.size());
  const Motion& m = course.stepper.motion;
  for (std::size_t k = 0; k < m.touches.count; ++k) {
    AtFinger& f = row.fingers[m.touches.list[k].finger];
    f.normal += m.normal_force[k], f.tangent += m.tangent_force[k];
    f.sticks |= m.signs.roll >> k & 1, f.slides |= (m.signs.plus | m.signs.minus) >> k & 1;
    f.bears = f.sticks || f.slides;
  }
  return row;
}

/// Calls `see` with each segment of a finger's path and its fraction within the duration.
template <class See>
void each_stretch(const LaminaPlan& plan, double duration, See see) {
  for (const FingerPlan& f : plan.fingers)
    for (std::size_t k = 0; k + 1 < f.path.size() && f.path[k].time < duration; ++k) {
      const Waypoint &a = f.path[k], &b = f.path[k + 1];
      see(&f, length(b.at - a.at), std::min(1.0, (duration - a.time) / (b.time - a.time)),
          b.time - a.time);
    }
}

/// The compared rows: from where dynamics has settled to where the runs diverge.
struct Window {
  std::size_t first, last;
};
Window window_of(const Run& a, const Run& b, const Parting& p) {
  const std::size_t last =
      std::min({static_cast<std::size_t>(p.row), a.rows.size() - 1, b.rows.size() - 1});
  return {std::max<std::size_t>(1, std::min(static_cast<std::size_t>(kSettled * kRows), last)),
          last};
}

Breach inertia_in(const Run& run, Window w, double load) {
  Breach b{0, 0.05, {}};
  for (std::size_t i = w.first; i <= w.last; ++i) {
    double friction = 1e-3 * load;
    for (const AtFinger& f : run.rows[i].fingers) friction += std::abs(f.tangent);
    b.size = std::max(b.size, run.rows[i].inertia / friction);
  }
  b.words = fmt::format("inertia reaches {:.3g} % of the forces of friction", 100 * b.size);
  return b;
}

/// A finger whose contact state differs from the prediction, in rows with a constant prediction
/// around them.
Breach fingers_in(const LaminaPlan& plan, const Run& q, const Run& run, Window w) {
  const double speed = speed_of(plan, 1e300);
  Breach slip{0, 0.05, "no contact slips that should stick"}, lost{0, 0.1, "none is lost"};
  for (std::size_t i = w.first; i <= w.last; ++i)
    for (std::size_t k = 0; k < plan.fingers.size(); ++k) {
      const AtFinger &now = q.rows[i].fingers[k], &before = q.rows[i - 1].fingers[k];
      const AtFinger& is = run.rows[i].fingers[k];
      const char* name = plan.fingers[k].name.c_str();
      if (now.sticks && before.sticks && is.slip / speed > slip.size) {
        slip.size = is.slip / speed;
        slip.words =
            fmt::format("{} should stick and slips by {:.3g} % of the fastest finger's speed", name,
                        100 * slip.size);
      }
      if (now.bears > 0 && before.bears > 0 && 1 - is.bears > lost.size) {
        lost.size = 1 - is.bears;
        lost.words = fmt::format("{} should carry force and is lost for {:.3g} % of the time", name,
                                 100 * lost.size);
      }
    }
  return slip.part() >= lost.part() ? slip : lost;
}

Breach roundness_in(const LaminaPlan& plan, const Run& run, Window w, double way) {
  Breach b{0, kApart, {}};
  for (std::size_t i = w.first; i <= w.last; ++i)
    b.size = std::max(b.size, radius_of_finger(plan) * std::abs(run.rows[i].angle) / way);
  b.words = fmt::format("contacts move round fingers of finite size by {:.3g} % of the way",
                        100 * b.size);
  return b;
}

}  // namespace

Prediction predict(const LaminaPlan& plan, double duration) {
  Prediction q;
  Course course{plan};
  for (int i = 0; i < kRows; ++i) {
    course.choices = 0;
    q.end = course.to(duration * i / (kRows - 1));
    if (q.end.ending != Ending::done) break;
    q.run.rows.push_back(row_of(course));
    q.choices.push_back(course.choices), q.index.push_back(course.stepper.motion.index);
  }
  q.time = course.time, q.zeno = course.zeno;
  return q;
}

std::optional<Run> simulate(const Scene& like, const LaminaPlan& plan, double duration,
                            double slower) {
  const auto scene =
      parse_scene(scene_of_dynamics(like, plan, duration, slower), "dynamics of " + plan.name);
  if (!scene) {
    for (const Error& e : scene.errors()) print_error(e.message);
    return std::nullopt;
  }
  DynamicCourse s{Simulation::copy_of(scene->world, {scene->step}), {}, {}};
  s.lamina = s.sim.world.find(plan.name);
  for (const FingerPlan& f : plan.fingers)
    s.fingers.push_back(s.sim.world.find(fmt::format("finger {}", f.name)));
  s.slides = kSlips * speed_of(plan, duration) / slower;
  Run run;
  for (int i = 0; i < kRows; ++i) {
    Row& row = run.rows.emplace_back();
    if (!run_row(s, plan, duration * slower * i / (kRows - 1), row)) return std::nullopt;
    for (AtFinger& f : row.fingers) f.slip *= slower;  // scaled to full speed
  }
  return run;
}

double way_of(const LaminaPlan& plan, double duration) {
  double most = 0, way = 0;
  const FingerPlan* last = nullptr;
  each_stretch(plan, duration, [&](const FingerPlan* f, double size, double part, double) {
    if (f != last) last = f, way = 0;
    most = std::max(most, way += size * part);
  });
  return most;
}

double speed_of(const LaminaPlan& plan, double duration) {
  double most = 1e-300;
  each_stretch(plan, duration, [&](const FingerPlan*, double size, double, double time) {
    most = std::max(most, size / time);
  });
  return most;
}

std::vector<Breach> breaches(const LaminaPlan& plan, const Prediction& q, const Run& run,
                             const Parting& p) {
  const Window w = window_of(q.run, run, p);
  const Vec3 load = plan.load();
  std::vector<Breach> all{inertia_in(run, w, std::hypot(load.x, load.y)),
                          fingers_in(plan, q.run, run, w),
                          roundness_in(plan, run, w, way_of(plan, 1e300))};
  // If several modes are feasible, dynamics may follow another one.
  for (std::size_t i = 0; i <= w.last; ++i) {
    if (q.choices[i] > 1)
      all.push_back({1, 1, fmt::format("{} modes held and one had to be chosen", q.choices[i])});
    else if (q.index[i] < 0)
      all.push_back({1, 1, "the mode has index -1: it is unstable when contacts yield"});
    else
      continue;
    break;
  }
  if (q.zeno) all.push_back({1, 1, "modes switch without end: the prediction is their mean"});
  std::stable_sort(all.begin(), all.end(),
                   [](const Breach& a, const Breach& b) { return a.part() > b.part(); });
  return all;
}

}  // namespace pantin::program
