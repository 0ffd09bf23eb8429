// One instant of the Lagrangian solver: its accelerations and forces against numbers computed
// elsewhere, dense elimination and quaternion coordinates.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/base/random.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;
using nlohmann::json;

namespace {

const json& vectors() {
  static const json kAll = json::parse(std::ifstream(test_data("lagrangian.json")));
  return kAll;
}

Vec3 vec(const json& j) { return {j.at(0), j.at(1), j.at(2)}; }
Quat quat(const json& j) { return Quat(j.at(0), j.at(1), j.at(2), j.at(3)); }

/// The two systems of `kkt`: joints at the points and axes that their Jacobians were made of.
World system_of(const json& k) {
  World w = exact_world(Integrator::rk4, vec(k.at("g")));
  const bool chain = k.at("name") == "chain5_spherical";
  const Entity ground = add_ground(w);
  std::vector<Entity> bodies;
  std::vector<Real> half;
  for (std::size_t i = 0; i < k.at("m").size(); ++i) {
    Body b = solid(k.at("m")[i], vec(k.at("Ib")[i]), {vec(k.at("x")[i]), quat(k.at("q")[i])});
    b.velocity = vec(k.at("v")[i]), b.angular_velocity = vec(k.at("w")[i]);
    bodies.push_back(w.add_body(b));
    const Real ends[] = {0.25, 0.6, 0.4};
    half.push_back(chain ? 0.5 : ends[i]);
  }
  const Quat y = frame_along({0, 1, 0});
  const auto tie = [&](Entity a, Entity b, Vec3 at_a, Vec3 at_b) {
    Joint j;
    j.anchor_a = at_a, j.anchor_b = at_b;
    if (!chain) {
      j.kind = JointKind::hinge;
      j.frames.set(glm::conjugate(w.bodies[a].pose.rotation) * y,
                   glm::conjugate(w.bodies[b].pose.rotation) * y);
    }
    add_link(w, {a, b, j});
  };
  for (std::size_t i = 0; i < bodies.size(); ++i)
    tie(i == 0 ? ground : bodies[i - 1], bodies[i], {i == 0 ? 0 : half[i - 1], 0, 0},
        {-half[i], 0, 0});
  if (!chain) tie(bodies.back(), ground, {half.back(), 0, 0}, {1, 0, 0});
  return w;
}

/// J^T lambda on each body, force and torque.
std::vector<Vec3> constraint_forces(const lagrangian::Island& m) {
  std::vector<Vec3> f(2 * m.count(), Vec3(0));
  for (const lagrangian::Block& b : m.blocks)
    for (std::size_t r = 0; r < b.rows; ++r)
      for (std::size_t k = 0; k < b.count; ++k) {
        if (b.body[k] >= m.count()) continue;
        const lagrangian::RowVectors j =
            lagrangian::row_of(b, &m.scratch.jacobian[b.first_vector], r, k);
        f[2 * b.body[k]] += m.scratch.lambda[b.first_row + r] * j.v;
        f[2 * b.body[k] + 1] += m.scratch.lambda[b.first_row + r] * j.w;
      }
  return f;
}

/// What a = room.motion leaves of J a = right, part of the largest term.
Real lack_of(const lagrangian::Island& m) {
  Real worst = 0, size = 1e-300;
  for (const lagrangian::Block& b : m.blocks)
    for (std::size_t r = 0; r < b.rows; ++r) {
      Real sum = m.scratch.right[b.first_row + r];
      size = std::max(size, std::abs(sum));
      for (std::size_t k = 0; k < b.count; ++k) {
        if (b.body[k] >= m.count()) continue;
        const lagrangian::RowVectors j =
            lagrangian::row_of(b, &m.scratch.jacobian[b.first_vector], r, k);
        const Real part = glm::dot(j.v, m.scratch.motion[2 * b.body[k]]) +
                          glm::dot(j.w, m.scratch.motion[2 * b.body[k] + 1]);
        sum -= part, size = std::max(size, std::abs(part));
      }
      worst = std::max(worst, std::abs(sum));
    }
  return worst / size;
}

struct WorldSpec {
  int bodies = 10, hubs = 0, loops = 0;
  bool heavy = false;   // masses from 1e-3 to 1e3
  bool driven = false;  // the ground sways
};

const Lissajous kSway{{{0.1, 0.2, -0.3}, kIdentity},
                      {0.3, 0.2, 0.1},
                      {0.5, 0.7, 0.9},
                      {0.1, 0.2, 0.3},
                      {0.2, 0.1, 0.3},
                      {0.6, 0.4, 0.8},
                      {1, 2, 3}};

/// A tree of random bodies and joints, tied to the ground, with hubs of 8 joints and some loops.
/// `order` permutes bodies and links as they are added.
World random_world(const WorldSpec& spec, unsigned seed, std::vector<Entity>* made = nullptr,
                   bool shuffled = false) {
  Random dice(seed);
  World w = exact_world(Integrator::rk4);
  const std::size_t n = static_cast<std::size_t>(spec.bodies);
  std::vector<Body> bodies(n);
  for (Body& b : bodies) {
    const Real size = spec.heavy ? std::pow(10, dice.between(-3, 3)) : dice.between(0.5, 2);
    b = solid(size,
              size * Vec3(dice.between(0.1, 0.2), dice.between(0.1, 0.2), dice.between(0.1, 0.2)),
              {dice.in_cube(1), dice.orientation()});
    b.velocity = dice.in_cube(1), b.angular_velocity = dice.in_cube(2);
  }
  struct Tie {
    std::size_t a, b;  // n: the ground
    JointKind kind;
    Vec3 point;
    Quat axes;
  };
  std::vector<Tie> ties;
  constexpr JointKind kKinds[] = {JointKind::ball,  JointKind::hinge,       JointKind::universal,
                                  JointKind::fixed, JointKind::cylindrical, JointKind::prismatic,
                                  JointKind::screw, JointKind::planar,      JointKind::distance};
  std::vector<std::size_t> meets(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t parent = i == 0 ? n : dice.below(i);
    for (std::size_t hub = 0; hub < static_cast<std::size_t>(spec.hubs) && i > 0; ++hub)
      if (i > hub && meets[hub] < 8) {
        parent = hub;
        break;
      }
    ties.push_back(
        {parent, i, kKinds[dice.below(std::size(kKinds))], dice.in_cube(1), dice.orientation()});
    ++meets[i];
    if (parent < n) ++meets[parent];
  }
  for (int i = 0; i < spec.loops; ++i) {
    const std::size_t a = dice.below(n), b = dice.below(n);
    if (a != b) ties.push_back({a, b, JointKind::distance, dice.in_cube(1), dice.orientation()});
  }
  std::vector<std::size_t> order(n), links(ties.size());
  std::iota(order.begin(), order.end(), 0), std::iota(links.begin(), links.end(), 0);
  if (shuffled) {
    dice.shuffle(order);
    dice.shuffle(links);
  }
  Body base;
  base.motion = spec.driven ? Motion::kinematic : Motion::fixed;
  w.time = 0.4;
  const KinematicPath sway{kSway};
  if (spec.driven) base.pose = pose_at(sway, w.time);
  const Entity ground = w.add_body(base);
  if (spec.driven) w.paths.add(ground, sway);
  std::vector<Entity> e(n + 1, ground);
  for (std::size_t i : order) e[i] = w.add_body(bodies[i]);
  for (std::size_t i : links) {
    const Tie& t = ties[i];
    Joint j = joint_at(w, e[t.a], e[t.b], t.kind, t.point, t.axes);
    if (t.kind == JointKind::distance)
      j.anchor_b += Vec3(0.6, 0, 0), j.parameters.edit().length = 0.6;
    if (t.kind == JointKind::screw) j.parameters.edit().pitch = 0.2;
    add_link(w, {e[t.a], e[t.b], j});
  }
  if (made) *made = {e.begin(), e.end() - 1};
  return w;
}

/// Where all bodies are and how frames move; the sway by differences of its own.
Real compare_with_dense(const World& w, const lagrangian::Island& m, Motion2& dense) {
  std::vector<BodyState> at;
  std::vector<Vec3> known(2 * w.bodies.size(), Vec3(0));
  for (std::size_t s = 0; s < w.bodies.size(); ++s) {
    at.push_back(placed_of(w.bodies.values()[s]));
    const KinematicPath* drive = w.paths.find(w.bodies.owners()[s]);
    if (!drive) continue;
    // Second differences with Richardson's step; turns as vectors from where the body is.
    const auto pose = [&](Real t) { return pose_at(*drive, w.time + t); };
    const auto rotation = [&](Real t) {
      return rotation_vector(pose(t).rotation * glm::conjugate(pose(0).rotation));
    };
    const auto first = [&](auto f, Real h) { return (f(h) - f(-h)) / (2 * h); };
    const auto second = [&](auto f, Real h) { return (f(h) - 2.0 * f(0) + f(-h)) / (h * h); };
    const auto best = [&](auto rule, auto f) {
      const Real h = 4e-3;
      const Vec3 a = rule(f, h), b = rule(f, h / 2), c = rule(f, h / 4);
      return (64.0 * c - 20.0 * b + a) / 45.0;
    };
    const auto place = [&](Real t) { return pose(t).position; };
    at[s].velocity = best(first, place), at[s].angular_velocity = best(first, rotation);
    known[2 * s] = best(second, place), known[2 * s + 1] = best(second, rotation);
  }
  dense = dense_motion(w, at, known);
  Real worst = 0, size = 1;
  for (std::size_t b = 0; b < m.count(); ++b)
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 want = dense.a[2 * m.slots[b] + i];
      size = std::max(size, glm::length(want));
      worst = std::max(worst, glm::length(m.scratch.motion[2 * b + i] - want));
    }
  return worst / size;
}

}  // namespace

TEST_CASE("accelerations and forces of constraint are those of the vectors") {
  for (const json& k : vectors().at("kkt")) {
    World w = system_of(k);
    lagrangian::Island& m = ready(w);
    lagrangian::accelerate(w, m, 0, 1e-3);
    const std::vector<Vec3> forces = constraint_forces(m);
    Real size = 0, worst = 0, worst_force = 0;
    for (std::size_t i = 0; i < 6 * m.count(); ++i) {
      const Real a = k.at("acc")[i], f = k.at("constraint_force")[i];
      size = std::max(size, std::abs(a));
      const int part = static_cast<int>(i % 3);
      worst = std::max(worst, std::abs(m.scratch.motion[i / 3][part] - a));
      worst_force = std::max(worst_force, std::abs(-forces[i / 3][part] - f));
    }
    INFO(k.at("name") << ": accelerations " << worst / size << ", forces " << worst_force);
    CHECK(worst <= 1e-11 * size);
    CHECK(worst_force <= 1e-9);
    CHECK(lack_of(m) <= 1e-12);

    Simulation sim(system_of(k), {1e-4});
    const StepReport report = sim.step();
    CHECK(report.status == Status::ok);
    CHECK(report.rows == static_cast<int>(k.at("J").size()));
    CHECK(report.rank == k.at("rank").get<int>());
    int redundant = 0;
    for (const lagrangian::Fault& f : lagrangian::islands_of(sim.world)[0].faults) {
      CHECK(f.kind == lagrangian::Fault::redundant);
      CHECK(sim.world.links.find(
          lagrangian::joint_of(sim.world, lagrangian::islands_of(sim.world)[0].blocks[f.block])));
      redundant += f.rows;
    }
    CHECK(redundant == report.rows - report.rank);
  }
}

TEST_CASE("random trees, hubs and loops: as by dense elimination") {
  Real worst[4] = {}, lack = 0, lack_heavy = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    WorldSpec spec;
    spec.bodies = 3 + static_cast<int>(seed * 27 / 59);
    spec.hubs = seed % 3 == 1 ? 2 : 0, spec.loops = seed % 4 == 3 ? spec.bodies / 6 : 0;
    spec.driven = seed % 5 == 2, spec.heavy = seed % 6 == 5;
    INFO("seed " << seed);
    World w = random_world(spec, seed);
    lagrangian::Island& m = ready(w);
    lagrangian::accelerate(w, m, 0, 1e-3);
    Motion2 dense;
    const Real miss = compare_with_dense(w, m, dense);
    if (dense.rank < dense.rows) continue;  // rows that contradict one another have no solution
    if (spec.hubs > 0 && spec.bodies > 12) CHECK(m.scratch.pattern.hubs.size() >= 1);
    Real& most = worst[spec.heavy ? 3 : spec.driven ? 2 : spec.loops > 0 ? 1 : 0];
    most = std::max(most, miss);
    (spec.heavy ? lack_heavy : lack) = std::max(spec.heavy ? lack_heavy : lack, lack_of(m));
  }
  INFO("trees " << worst[0] << ", loops " << worst[1] << ", driven " << worst[2] << ", heavy "
                << worst[3] << ", lack " << lack << " and " << lack_heavy);
  CHECK(worst[0] <= 3e-13);
  CHECK(worst[1] <= 5e-12);
  CHECK(worst[2] <= 2e-10);  // differences of the path, on both sides
  CHECK(worst[3] <= 5e-9);
  CHECK(lack <= 1e-12);
  CHECK(lack_heavy <= 2e-9);
}

TEST_CASE("the order in which bodies and links are named does not matter") {
  Real worst = 0;
  for (unsigned seed = 100; seed < 130; ++seed) {
    WorldSpec spec;
    spec.bodies = 4 + static_cast<int>(seed % 20), spec.hubs = seed % 2, spec.loops = seed % 3;
    std::vector<Entity> bodies[2];
    World w[2] = {random_world(spec, seed, &bodies[0]), random_world(spec, seed, &bodies[1], true)};
    std::vector<Vec3> a[2];
    for (int i = 0; i < 2; ++i) {
      lagrangian::Island& m = ready(w[i]);
      lagrangian::accelerate(w[i], m, 0, 1e-3);
      for (Entity e : bodies[i])
        for (std::size_t b = 0; b < m.count(); ++b)
          if (m.bodies[b] == e)
            a[i].push_back(m.scratch.motion[2 * b]), a[i].push_back(m.scratch.motion[2 * b + 1]);
    }
    REQUIRE(a[0].size() == a[1].size());
    Motion2 dense;
    compare_with_dense(w[0], lagrangian::islands_of(w[0])[0], dense);
    if (dense.rank < dense.rows) continue;
    Real size = 1;
    for (std::size_t i = 0; i < a[0].size(); ++i) size = std::max(size, glm::length(a[0][i]));
    for (std::size_t i = 0; i < a[0].size(); ++i)
      worst = std::max(worst, glm::length(a[0][i] - a[1][i]) / size);
  }
  INFO(worst);
  CHECK(worst <= 5e-13);
}

TEST_CASE("forces of constraint do no work and have no sum") {
  Real worst = 0, sum = 0;
  for (unsigned seed = 200; seed < 230; ++seed) {
    WorldSpec spec;
    spec.bodies = 3 + static_cast<int>(seed % 20), spec.hubs = seed % 2;
    World w = random_world(spec, seed);
    lagrangian::Island& m = ready(w);
    lagrangian::update_kinematics(m), lagrangian::update_frames(w, m, 0, 1);
    lagrangian::write_all_rows(w, m, {true, false});
    lagrangian::factor(m);
    lagrangian::project_twists(m, {});
    lagrangian::accelerate(w, m, 0, 1e-3);
    Real power = 0, size = 1e-300;
    for (const lagrangian::Block& b : m.blocks)
      for (std::size_t r = 0; r < b.rows; ++r)
        for (std::size_t k = 0; k < b.count; ++k) {
          if (b.body[k] >= m.count()) continue;
          const lagrangian::RowVectors j =
              lagrangian::row_of(b, &m.scratch.jacobian[b.first_vector], r, k);
          const Real load = m.scratch.lambda[b.first_row + r];
          power += load * (glm::dot(j.v, m.scratch.state.v[b.body[k]]) +
                           glm::dot(j.w, m.scratch.state.w[b.body[k]]));
          size = std::max(size, std::abs(load));  // twists are of order one
        }
    worst = std::max(worst, std::abs(power) / size);
    // Each block pushes its two bodies equally, force and moment about the origin.
    for (const lagrangian::Block& b : m.blocks)
      for (std::size_t r = 0; r < b.rows; ++r) {
        const lagrangian::RowVectors on_a =
            lagrangian::row_of(b, &m.scratch.jacobian[b.first_vector], r, 0);
        const lagrangian::RowVectors on_b =
            lagrangian::row_of(b, &m.scratch.jacobian[b.first_vector], r, 1);
        const Vec3 x = m.scratch.body_states[b.body[0]].position,
                   y = m.scratch.body_states[b.body[1]].position;
        sum = std::max(sum, glm::length(on_a.v + on_b.v));
        if (std::abs(m.scratch.c[b.first_row]) < 1e-12)
          sum = std::max(
              sum, glm::length(on_a.w + on_b.w + glm::cross(x, on_a.v) + glm::cross(y, on_b.v)));
      }
  }
  INFO("power " << worst << ", sum " << sum);
  CHECK(worst <= 1e-11);
  CHECK(sum <= 1e-13);
}

namespace {

using Long = long double;
struct Quat4 {
  Long q[4];
};
Quat4 of(Quat q) { return {{q.w, q.x, q.y, q.z}}; }

/// d(q v q*)/dq, three rows of four. [method, sec. 7]
void rotation_slope(const Quat4& at, Vec3 v, Long d[3][4]) {
  const Long a = at.q[0], x = at.q[1], y = at.q[2], z = at.q[3];
  const Long rows[3][4] = {{a * v.x + y * v.z - z * v.y, x * v.x + y * v.y + z * v.z,
                            a * v.z + x * v.y - y * v.x, -a * v.y - z * v.x + x * v.z},
                           {a * v.y + z * v.x - x * v.z, -a * v.z - x * v.y + y * v.x,
                            x * v.x + y * v.y + z * v.z, a * v.x + y * v.z - z * v.y},
                           {a * v.z + x * v.y - y * v.x, a * v.y + z * v.x - x * v.z,
                            -a * v.x - y * v.z + z * v.y, x * v.x + y * v.y + z * v.z}};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) d[i][k] = 2 * rows[i][k];
}

/// G of w_body = 2 G q'.
void body_map(const Quat4& at, Long g[3][4]) {
  const Long a = at.q[0], x = at.q[1], y = at.q[2], z = at.q[3];
  const Long rows[3][4] = {{-x, a, z, -y}, {-y, -z, a, x}, {-z, y, -x, a}};
  std::copy(&rows[0][0], &rows[0][0] + 12, &g[0][0]);
}

}  // namespace

TEST_CASE("the slope of a turned vector by the quaternion is that of the vectors") {
  const json& k = vectors().at("quaternion_derivative");
  Long d[3][4];
  rotation_slope(of(quat(k.at("q"))), vec(k.at("v")), d);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t c = 0; c < 4; ++c)
      CHECK(std::abs(static_cast<Real>(d[i][c]) - k.at("d_qvqstar_dq")[i][c].get<Real>()) <= 5e-14);
}

TEST_CASE("spherical chains: as in quaternion coordinates with a norm to keep") {
  for (const std::size_t n : {1u, 5u, 20u}) {
    Random dice(n);
    World w = exact_world(Integrator::rk4);
    Entity before = add_ground(w);
    Vec3 at(0);
    for (std::size_t i = 0; i < n; ++i) {
      const Quat q = dice.orientation();
      Body b = solid(dice.between(0.5, 2), {0.04, 0.09, 0.12}, {at + q * Vec3(0.5, 0, 0), q});
      b.angular_velocity = dice.in_cube(2), b.velocity = dice.in_cube(1);
      const Entity e = w.add_body(b);
      add_link(w, {before, e, joint_at(w, before, e, JointKind::ball, at)});
      at += q * Vec3(1, 0, 0), before = e;
    }
    lagrangian::Island& m = ready(w);
    lagrangian::update_kinematics(m), lagrangian::update_frames(w, m, 0, 1);
    lagrangian::write_all_rows(w, m, {true, false});
    lagrangian::factor(m);
    lagrangian::project_twists(m, {});
    lagrangian::accelerate(w, m, 0, 1e-3);

    // Unknowns: x'' and q'' of all bodies, multipliers of joints, of norms.
    Dense system(7 * n + 3 * n + n);
    std::vector<Quat4> q(n), rate(n);
    for (std::size_t i = 0; i < n; ++i) {
      q[i] = of(m.scratch.state.q[i]);
      rate[i] = of(Quat(0, 0.5 * m.scratch.state.w[i]) * m.scratch.state.q[i]);
      Long g[3][4], gd[3][4];
      body_map(q[i], g), body_map(rate[i], gd);
      Long angular_velocity[3] = {};  // G q'
      for (int a = 0; a < 3; ++a)
        for (int c = 0; c < 4; ++c) angular_velocity[a] += g[a][c] * rate[i].q[c];
      Long speed = 0;
      for (std::size_t r = 0; r < 3; ++r) {
        system.at(7 * i + r, 7 * i + r) = m.mass[i];
        system.right(7 * i + r) = m.mass[i] * w.gravity[static_cast<int>(r)];
      }
      for (std::size_t r = 0; r < 4; ++r) {
        for (std::size_t a = 0; a < 3; ++a) {
          const Long inertia = m.inertia[i][static_cast<int>(a)];
          for (std::size_t c = 0; c < 4; ++c)
            system.at(7 * i + 3 + r, 7 * i + 3 + c) += 4 * g[a][r] * inertia * g[a][c];
          system.right(7 * i + 3 + r) += -8 * gd[a][r] * inertia * angular_velocity[a];
        }
        system.at(10 * n + i, 7 * i + 3 + r) = system.at(7 * i + 3 + r, 10 * n + i) = 2 * q[i].q[r];
        speed += rate[i].q[r] * rate[i].q[r];
      }
      system.right(10 * n + i) = -2 * speed;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const Joint& j = w.links.values()[i].joint;
      const auto end = [&](std::size_t body, Vec3 anchor, Long sign) {
        Long d[3][4], dd[3][4];
        rotation_slope(q[body], anchor, d), rotation_slope(rate[body], anchor, dd);
        for (std::size_t r = 0; r < 3; ++r) {
          const std::size_t row = 7 * n + 3 * i + r;
          system.at(row, 7 * body + r) = system.at(7 * body + r, row) = sign;
          for (std::size_t c = 0; c < 4; ++c) {
            system.at(row, 7 * body + 3 + c) = system.at(7 * body + 3 + c, row) = sign * d[r][c];
            system.right(row) -= sign * dd[r][c] * rate[body].q[c];
          }
        }
      };
      end(i, j.anchor_b, 1);
      if (i > 0) end(i - 1, j.anchor_a, -1);
    }
    const std::vector<Long> x = system.solve();
    Real worst = 0, size = 1;
    for (std::size_t i = 0; i < n; ++i) {
      Long g[3][4];
      body_map(q[i], g);
      Vec3 a, rotation(0);
      for (int r = 0; r < 3; ++r) {
        a[r] = static_cast<Real>(x[7 * i + static_cast<std::size_t>(r)]);
        for (std::size_t c = 0; c < 4; ++c)
          rotation[r] += static_cast<Real>(2 * g[r][c] * x[7 * i + 3 + c]);
      }
      rotation = m.scratch.state.q[i] * rotation;
      size = std::max({size, glm::length(a), glm::length(rotation)});
      worst = std::max({worst, glm::length(a - m.scratch.motion[2 * i]),
                        glm::length(rotation - m.scratch.motion[2 * i + 1])});
    }
    INFO(n << " bodies: " << worst / size);
    CHECK(worst <= 1e-12 * size);
  }
}
