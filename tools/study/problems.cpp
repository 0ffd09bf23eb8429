#include "tools/study/problems.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"

namespace pantin::study {

using namespace detail;

namespace {

using Json = nlohmann::json;

Json read(const std::string& folder, const std::string& file) {
  std::ifstream in(folder + "/" + file + ".json");
  if (!in) throw std::runtime_error("could not read " + folder + "/" + file + ".json");
  return Json::parse(in);
}

Real value(const Json& entries, const char* name) { return entries.at(name).at("value"); }

World exact_world() {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  w.default_settings.integrator = Integrator::rk4;
  return w;
}

Entity add_ground(World& w) {
  Body ground;
  ground.motion = Motion::fixed;
  return w.add_body(ground);
}

Vec3 flat(Real angle, Real length) {
  return {length * std::cos(angle), length * std::sin(angle), 0};
}

/// A uniform thin rod along its x from `start`, at `angle` from the world's x, about z.
Body rod(Real mass, Real length, Vec3 start, Real angle) {
  Body b;
  b.mass = mass;
  const Real across = mass * length * length / 12;
  b.inertia = {0.01 * across, across, across};
  b.pose = {start + 0.5 * flat(angle, length), from_rotation_vector(Vec3(0, 0, angle))};
  b.drag = 0;
  return b;
}

/// A point mass, which a distance joint holds at its centre.
Body point(Real mass, Vec3 at) {
  Body b;
  b.mass = mass;
  b.pose.position = at;
  b.drag = 0;
  return b;
}

Joint pin_joint(Vec3 anchor_a, Vec3 anchor_b) { return hinge_about({0, 0, 1}, anchor_a, anchor_b); }

Joint rod_joint(Real length) {
  Joint j;
  j.kind = JointKind::distance;
  j.parameters.edit().length = length;
  return j;
}

const Body& body(const World& w, std::size_t slot) { return w.bodies.values()[slot]; }

Vec3 tip(const Body& b, Real length) { return to_world(b.pose, {length / 2, 0, 0}); }

Real planar_angle(const Body& b) { return 2 * std::atan2(b.pose.rotation.z, b.pose.rotation.w); }

/// Of two angles, whole turns aside.
Real apart(Real a, Real b) { return std::abs(std::remainder(a - b, 2 * kPi)); }

Problem begin(const Json& file, const Json& one) {
  Problem p;
  p.file = file.at("id"), p.id = one.at("id");
  p.rows = one.at("samples").get<std::vector<std::vector<Real>>>();
  p.world = exact_world();
  p.every = p.rows.size() > 1 ? p.rows[1][0] - p.rows[0][0] : 0;
  for (const auto& row : p.rows)
    p.at_step.push_back(static_cast<int>(std::lround((row[0] - p.rows[0][0]) / p.every)));
  return p;
}

/// A rod of one and a half times the length swings as the point mass does.
Problem pendulum(const Json& file, const Json& one) {
  Problem p = begin(file, one);
  const Real theta = value(one.at("initial"), "theta"), omega = value(one.at("initial"), "omega");
  const Real length = 1.5 * value(one.at("parameters"), "length");
  const Entity ground = add_ground(p.world);
  Body b = rod(1, length, Vec3(0), theta - kPi / 2);
  b.angular_velocity = {0, 0, omega};
  b.velocity = glm::cross(b.angular_velocity, b.pose.position);
  add_link(p.world, {ground, p.world.add_body(b), pin_joint(Vec3(0), {-length / 2, 0, 0})});
  p.error = [](const World& w, const std::vector<Real>& row) {
    return apart(planar_angle(body(w, 1)) + kPi / 2, row[1]);
  };
  p.divisions = 10, p.allowed = 1e-6, p.allowed_adaptive = 1e-7;
  // Near the top an error grows a thousandfold in a swing.
  if (p.id == "amp_179deg") p.allowed = 1e-4, p.allowed_adaptive = 1e-5;
  return p;
}

Problem falling_point(const Json& file, const Json& one) {
  Problem p = begin(file, one);
  const Entity ground = add_ground(p.world);
  const Entity mass =
      p.world.add_body(point(1, {value(one.at("initial"), "x"), value(one.at("initial"), "y"), 0}));
  add_link(p.world, {ground, mass, rod_joint(value(one.at("parameters"), "length"))});
  p.error = [](const World& w, const std::vector<Real>& row) {
    return glm::length(body(w, 1).pose.position - Vec3(row[1], row[2], 0));
  };
  p.divisions = 5, p.allowed = 1e-6, p.allowed_adaptive = 1e-7;
  return p;
}

Problem windows(const Json& file, const Json& one) {
  Problem p = begin(file, one);
  const int n = static_cast<int>(value(one.at("parameters"), "windows_N"));
  World& w = p.world;
  const Entity ground = add_ground(w);
  std::vector<Entity> posts;
  for (int i = 0; i <= n; ++i) {
    Body post = rod(1, 1, {i, 0, 0}, kPi / 2);
    post.angular_velocity = {0, 0, -1}, post.velocity = {0.5, 0, 0};
    posts.push_back(w.add_body(post));
    add_link(w, {ground, posts.back(), hinge_about({0, 0, 1}, {i, 0, 0}, {-0.5, 0, 0})});
  }
  for (int i = 0; i < n; ++i) {
    Body beam = rod(1, 1, {i, 1, 0}, 0);
    beam.velocity = {1, 0, 0};
    const Entity e = w.add_body(beam);
    add_link(w, {posts[static_cast<std::size_t>(i)], e, pin_joint({0.5, 0, 0}, {-0.5, 0, 0})});
    add_link(w, {posts[static_cast<std::size_t>(i) + 1], e, pin_joint({0.5, 0, 0}, {0.5, 0, 0})});
  }
  p.error = [](const World& at, const std::vector<Real>& row) {
    return glm::length(tip(body(at, 1), 1) - Vec3(row[1], row[2], 0));
  };
  p.divisions = 5, p.allowed = 1e-4, p.allowed_adaptive = 1e-5;
  return p;
}

Problem bricard(const Json& file, const Json& one) {
  Problem p = begin(file, one);
  World& w = p.world;
  const Vec3 joints[6] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
  const Vec3 axes[6] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  const Real width = value(one.at("parameters"), "section");
  const Entity ground = add_ground(w);
  Entity before = ground;
  Vec3 centre(0);
  for (int i = 0; i < 5; ++i) {
    const Vec3 along = joints[i + 1] - joints[i];
    Body b;
    b.drag = 0;
    b.pose.position = 0.5 * (joints[i] + joints[i + 1]);
    b.inertia = Vec3((1 + width * width) / 12);
    for (int k = 0; k < 3; ++k)
      if (along[k] != 0) b.inertia[k] = width * width / 6;
    const Entity e = w.add_body(b);
    add_link(w, {before, e, hinge_about(axes[i], joints[i] - centre, joints[i] - b.pose.position)});
    before = e, centre = b.pose.position;
  }
  add_link(w, {before, ground, hinge_about(axes[5], joints[5] - centre, joints[5])});
  p.error = [](const World& at, const std::vector<Real>& row) {
    return glm::length(to_world(body(at, 3).pose, {0, 0, 0.5}) - Vec3(row[9], row[10], row[11]));
  };
  p.divisions = 20, p.allowed = 1e-5, p.allowed_adaptive = 1e-6;
  return p;
}

Problem many_links(const Json& file, const Json& one) {
  Problem p = begin(file, one);
  const Json& given = one.at("parameters");
  const auto theta = one.at("initial").at("theta").at("value").get<std::vector<Real>>();
  const Real length = value(given, "link_length"), mass = value(given, "link_mass");
  const bool points = given.at("mass_model").at("value") == "point";
  const std::size_t n = theta.size();
  Entity before = add_ground(p.world);
  Vec3 top(0);
  for (std::size_t i = 0; i < n; ++i) {
    const Real angle = theta[i] - kPi / 2;
    const Vec3 bottom = top + flat(angle, length);
    const Entity e = p.world.add_body(points ? point(mass, bottom) : rod(mass, length, top, angle));
    add_link(p.world,
             {before, e,
              points ? rod_joint(length)
                     : pin_joint(i == 0 ? Vec3(0) : Vec3(length / 2, 0, 0), {-length / 2, 0, 0})});
    before = e, top = bottom;
  }
  p.error = [n, points, length](const World& w, const std::vector<Real>& row) {
    const Body& last = body(w, n);
    return glm::length((points ? last.pose.position : tip(last, length)) -
                       Vec3(row[1 + 2 * n], row[2 + 2 * n], 0));
  };
  p.divisions = n > 5 ? 80 : 40, p.allowed = 1e-6, p.allowed_adaptive = 1e-7;
  return p;
}

Problem free_body(const Json& file, const Json& one) {
  Problem p = begin(file, one);
  const auto inertia = one.at("parameters").at("inertia").at("value").get<std::vector<Real>>();
  const std::vector<Real>& first = p.rows.front();
  Body b;
  b.drag = 0, b.gravity_scale = 0;
  b.inertia = {inertia[0], inertia[1], inertia[2]};
  b.pose.rotation = Quat(first[4], first[5], first[6], first[7]);
  b.angular_velocity = b.pose.rotation * Vec3(first[1], first[2], first[3]);
  p.world.add_body(b);
  p.error = [](const World& w, const std::vector<Real>& row) {
    const Quat q = body(w, 0).pose.rotation, r(row[4], row[5], row[6], row[7]);
    return std::min(glm::length(q - r), glm::length(q + r));
  };
  p.divisions = 10, p.allowed = 1e-5, p.allowed_adaptive = 1e-7;
  if (p.id == "intermediate_axis_flip") p.allowed = 1e-4, p.allowed_adaptive = 1e-5;
  return p;
}

/// The stretches that the crank can pass in one go. At a change point, which has no row, the
/// branches of the file meet, and its names for them change places.
std::vector<std::pair<std::size_t, std::size_t>> stretches(const Problem& p) {
  std::vector<std::pair<std::size_t, std::size_t>> found;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= p.rows.size(); ++i)
    if (i == p.rows.size() || p.at_step[i] - p.at_step[i - 1] > 1) {
      found.emplace_back(first, i);
      first = i;
    }
  return found;
}

void four_bar(const Json& file, const Json& one, std::vector<Problem>& problems) {
  const Json& given = one.at("parameters");
  const Real crank = value(given, "crank"), coupler = value(given, "coupler");
  const Real rocker = value(given, "rocker"), ground_length = value(given, "ground");
  const auto p_q = given.at("coupler_point").at("value").get<std::vector<Real>>();
  const Problem all = begin(file, one);
  const auto parts = stretches(all);
  for (std::size_t part = 0; part < parts.size(); ++part) {
    Problem p = all;
    if (parts.size() > 1) p.id += "_" + std::to_string(part + 1);
    p.rows.assign(all.rows.begin() + static_cast<std::ptrdiff_t>(parts[part].first),
                  all.rows.begin() + static_cast<std::ptrdiff_t>(parts[part].second));
    p.at_step.clear();
    for (const auto& row : p.rows)
      p.at_step.push_back(static_cast<int>(std::lround((row[0] - p.rows[0][0]) / p.every)));
    World& w = p.world;
    const std::vector<Real>& first = p.rows.front();
    const Entity ground = add_ground(w);
    Body turning;
    turning.motion = Motion::kinematic;
    turning.pose.rotation = from_rotation_vector(Vec3(0, 0, first[0]));
    turning.angular_velocity = {0, 0, 1};
    const Entity handle = w.add_body(turning);
    Keyframes keys;
    // From before the start, so that the crank has its speed then.
    for (int i = -1; i <= p.at_step.back() + 1; ++i)
      keys.keys.push_back(
          {i * p.every, {Vec3(0), from_rotation_vector(Vec3(0, 0, first[0] + i * p.every))}});
    w.paths.add(handle, KinematicPath{keys});
    const Vec3 at_crank = flat(first[0], crank);
    Body bar = rod(1, coupler, at_crank, first[1]);
    bar.angular_velocity = {0, 0, first[5]};
    bar.velocity = glm::cross(Vec3(0, 0, 1), at_crank) +
                   glm::cross(bar.angular_velocity, bar.pose.position - at_crank);
    Body swinging = rod(1, rocker, {ground_length, 0, 0}, first[2]);
    swinging.angular_velocity = {0, 0, first[6]};
    swinging.velocity =
        glm::cross(swinging.angular_velocity, swinging.pose.position - Vec3(ground_length, 0, 0));
    const Entity c = w.add_body(bar), r = w.add_body(swinging);
    add_link(w, {handle, c, pin_joint({crank, 0, 0}, {-coupler / 2, 0, 0})});
    add_link(w, {ground, r, pin_joint({ground_length, 0, 0}, {-rocker / 2, 0, 0})});
    add_link(w, {r, c, pin_joint({rocker / 2, 0, 0}, {coupler / 2, 0, 0})});
    const Vec3 drawn(p_q[0] - coupler / 2, p_q[1], 0);
    p.error = [drawn](const World& at, const std::vector<Real>& row) {
      return glm::length(to_world(body(at, 2).pose, drawn) - Vec3(row[3], row[4], 0));
    };
    p.conserves = false;
    p.divisions = 2, p.allowed = 1e-9, p.allowed_adaptive = 1e-9;
    problems.push_back(std::move(p));
  }
}

/// The parallelogram through its change point: on as a parallelogram, which the file tells by its
/// open branch before and its crossed branch after.
void add_way_through(std::vector<Problem>& problems) {
  const auto find = [&](const char* id) {
    return *std::find_if(problems.begin(), problems.end(),
                         [&](const Problem& p) { return p.id == id; });
  };
  Problem p = find("parallelogram_change_point_open_1");
  const Problem after = find("parallelogram_change_point_crossed_2");
  p.id = "parallelogram_through_change_point";
  for (const auto& row : after.rows) {
    p.rows.push_back(row);
    p.at_step.push_back(static_cast<int>(std::lround((row[0] - p.rows[0][0]) / p.every)));
  }
  Keyframes& keys = std::get<Keyframes>(p.world.paths.values()[0].curve);
  const Real first = p.rows[0][0];
  keys.keys.clear();
  for (int i = -1; i <= p.at_step.back() + 1; ++i)
    keys.keys.push_back(
        {i * p.every, {Vec3(0), from_rotation_vector(Vec3(0, 0, first + i * p.every))}});
  problems.push_back(std::move(p));
}

}  // namespace

Joint hinge_about(Vec3 axis, Vec3 anchor_a, Vec3 anchor_b) {
  Joint j;
  j.kind = JointKind::hinge;
  j.anchor_a = anchor_a, j.anchor_b = anchor_b;
  if (axis.x != 1) {
    const Quat rotated = axis.y == 1 ? from_rotation_vector(Vec3(0, 0, kPi / 2))
                                     : from_rotation_vector(Vec3(0, -kPi / 2, 0));
    j.frames.set(rotated, rotated);
  }
  return j;
}

std::vector<Problem> read_problems(const std::string& folder) {
  using Builder = Problem (*)(const Json&, const Json&);
  const std::pair<const char*, Builder> builders[] = {
      {"simple_pendulum_large", pendulum}, {"a01_simple_pendulum", falling_point},
      {"a02_n_four_bar", windows},         {"a04_bricard", bricard},
      {"n_pendulum", many_links},          {"torque_free_body", free_body}};
  std::vector<Problem> problems;
  for (const auto& [name, build] : builders) {
    const Json file = read(folder, name);
    for (const Json& one : file.at("cases")) problems.push_back(build(file, one));
  }
  const Json file = read(folder, "four_bar");
  for (const Json& one : file.at("cases")) four_bar(file, one, problems);
  add_way_through(problems);
  return problems;
}

std::vector<Problem> read_hanging_chains(const std::string& folder, HangingStart start) {
  const bool rest = start == HangingStart::at_rest;
  std::vector<Problem> problems;
  const Json file = read(folder, "catenary");
  for (const Json& one : file.at("cases")) {
    if (!one.at("parameters").contains("links")) continue;
    const Json& given = one.at("parameters");
    const Real length = value(given, "link_length");
    const Real mass = length * value(given, "mass_per_length");
    Problem p;
    p.file = file.at("id"), p.id = one.at("id");
    p.id += rest ? "" : "_settles";
    p.world = exact_world();
    const auto shape = one.at("samples").get<std::vector<std::vector<Real>>>();
    const std::size_t n = shape.size() - 1;
    std::vector<Vec3> at;
    for (const auto& row : shape) at.emplace_back(row[1], row[2], 0);
    if (!rest) {
      // Two straight halves that meet below.
      const Vec3 end = at.back();
      const Real half = 0.5 * length * static_cast<Real>(n), chord = glm::length(end);
      const Vec3 down(end.y / chord, -end.x / chord, 0);
      const Vec3 corner = 0.5 * end + std::sqrt(half * half - chord * chord / 4) * down;
      for (std::size_t i = 0; i <= n; ++i) {
        const Real u = 2 * static_cast<Real>(i) / static_cast<Real>(n);
        at[i] = u <= 1 ? u * corner : corner + (u - 1) * (end - corner);
      }
    }
    World& w = p.world;
    const Entity ground = add_ground(w);
    Entity before = ground;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 along = at[i + 1] - at[i];
      Body b = rod(mass, length, at[i], std::atan2(along.y, along.x));
      b.drag = rest ? 0 : 6;
      const Entity e = w.add_body(b);
      add_link(w, {before, e,
                   pin_joint(i == 0 ? Vec3(0) : Vec3(length / 2, 0, 0), {-length / 2, 0, 0})});
      before = e;
    }
    add_link(w, {before, ground, pin_joint({length / 2, 0, 0}, at.back())});
    std::vector<Real> joints;
    for (const auto& row : shape) joints.push_back(row[1]), joints.push_back(row[2]);
    p.every = rest ? 1 : 12;
    p.rows = {joints, joints};
    p.at_step = {0, 1};
    p.error = [length](const World& now, const std::vector<Real>& row) {
      Real worst = 0;
      for (std::size_t i = 1; 2 * i + 1 < row.size(); ++i)
        worst = std::max(
            worst, glm::length(tip(body(now, i), length) - Vec3(row[2 * i], row[2 * i + 1], 0)));
      return worst;
    };
    p.conserves = rest;
    p.divisions = rest ? 250 : 3000;
    p.allowed = p.allowed_adaptive = rest ? 1e-9 : 1e-8;
    problems.push_back(std::move(p));
  }
  return problems;
}

Score score(const Problem& p, int divisions) {
  Score s;
  Simulation run = Simulation::copy_of(p.world, {p.every / divisions});
  const Real start = measure(run.world).energy();
  s.least_rank = 1 << 30;
  std::size_t row = p.at_step.front() == 0 && p.file != "catenary" ? 0 : 1;
  for (long step = 0; row < p.rows.size(); ++step) {
    if (step == long{p.at_step[row]} * divisions) {
      s.error = std::max(s.error, p.error(run.world, p.rows[row]));
      s.energy = std::max(s.energy, std::abs(measure(run.world).energy() - start));
      if (++row == p.rows.size()) break;
    }
    const StepReport r = run.step();
    if (s.status == Status::ok) s.status = r.status;
    if (r.status == Status::diverged) break;
    s.constraint = std::max(s.constraint, r.worst_constraint);
    s.rows = r.rows, s.least_rank = std::min(s.least_rank, r.rank);
    s.parts += r.substeps;
  }
  return s;
}

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

double time_of(const Problem& p, int divisions, int repeats) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    Simulation run = Simulation::copy_of(p.world, {p.every / divisions});
    const long steps = long{p.at_step.back()} * divisions;
    const double from = cpu_seconds();
    for (long step = 0; step < steps; ++step) run.step();
    times.push_back(cpu_seconds() - from);
  }
  return median(times);
}

World chain(const RodChain& rods) {
  World w = exact_world();
  Entity before = add_ground(w);
  Vec3 top(0);
  for (int i = 0; i < rods.links; ++i) {
    const Entity e = w.add_body(rod(1, rods.length, top, rods.angle - kPi / 2));
    Joint j = pin_joint(i == 0 ? Vec3(0) : Vec3(rods.length / 2, 0, 0), {-rods.length / 2, 0, 0});
    if (rods.kind == JointKind::ball) j.frames = {};
    j.kind = rods.kind;
    if (i > 0 || rods.held) add_link(w, {before, e, j});
    before = e;
    top += flat(rods.angle - kPi / 2, rods.length);
  }
  return w;
}

Real distance(const World& a, const World& b) {
  Real worst = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i)
    worst = std::max(worst, glm::length(body(a, i).pose.position - body(b, i).pose.position));
  return worst;
}

Real difference(const World& a, const World& b) {
  Real worst = distance(a, b);
  for (std::size_t i = 0; i < a.bodies.size(); ++i)
    worst = std::max(worst, glm::length(rotation_vector(body(a, i).pose.rotation *
                                                        glm::conjugate(body(b, i).pose.rotation))));
  return worst;
}

}  // namespace pantin::study
