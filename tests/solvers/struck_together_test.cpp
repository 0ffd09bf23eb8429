// Limits, cables and contacts that are struck in one instant: the velocities of least kinetic
// energy that joints, stops, cables and the ground allow (plastic blow), whatever the integrator
// and the step.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"

using namespace pantin;
using nlohmann::json;

namespace {

constexpr int kBodies = 4;
constexpr Real kRadius = 0.05;  // m, of what touches the ground

enum class Row : std::uint8_t { holds, pushes };

/// The motion of all bodies, two vectors each.
using Motion6 = std::vector<Vec3>;

/// A scene, its motion before, and its constraints on velocities: J v = 0 or J v >= 0.
struct Struck {
  json scene;
  Motion6 before;
  std::vector<Real> mass;
  std::vector<Vec3> inertia, at;
  std::vector<Motion6> rows;
  std::vector<Row> kinds;

  Motion6& add_row(Row kind) {
    rows.emplace_back(2 * kBodies, Vec3(0)), kinds.push_back(kind);
    return rows.back();
  }
  /// A force along `n` at a point of a body; none of the world.
  void push_at(Motion6& row, int body, Vec3 point, Vec3 n) const {
    if (body < 0) return;
    row[2 * std::size_t(body)] += n;
    row[2 * std::size_t(body) + 1] += glm::cross(point - at[std::size_t(body)], n);
  }
};

json list_of(Vec3 v) { return {v.x, v.y, v.z}; }
std::string name_of(int body) { return body < 0 ? "world" : "b" + std::to_string(body); }

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  Real any(Real from, Real to) { return std::uniform_real_distribution<Real>(from, to)(random_); }
  Vec3 in_cube(Real half) { return {any(-half, half), any(-half, half), any(-half, half)}; }
  bool coin() { return random_() % 2 == 0; }

 private:
  std::mt19937 random_;
};

/// A hinge at a stop, from the body before.
void add_hinge(Struck& s, Dice& dice, int b, Vec3 anchor) {
  const int a = b - 1;
  const Vec3 axis = glm::normalize(dice.in_cube(1));
  const bool low = dice.coin();
  s.scene["joints"].push_back({{"kind", "hinge"},
                               {"a", name_of(a)},
                               {"b", name_of(b)},
                               {"anchor", list_of(anchor)},
                               {"axis", list_of(axis)},
                               {"limits", {{"angle_deg", {low ? 0 : -30, low ? 30 : 0}}}}});
  const auto turn = [&](Row kind, Vec3 about) {
    Motion6& row = s.add_row(kind);
    row[2 * std::size_t(b) + 1] = about;
    if (a >= 0) row[2 * std::size_t(a) + 1] = -about;
  };
  for (int k = 0; k < 3; ++k) {
    Vec3 n(0);
    n[k] = 1;
    Motion6& row = s.add_row(Row::holds);
    s.push_at(row, b, anchor, n), s.push_at(row, a, anchor, -n);
  }
  const Vec3 across = glm::normalize(glm::cross(axis, dice.in_cube(1)));
  turn(Row::holds, across), turn(Row::holds, glm::cross(axis, across));
  turn(Row::pushes, low ? axis : -axis);
}

/// A cable that is just taut.
void add_cable(Struck& s, int a, int b, const std::array<Vec3, 2>& ends) {
  s.scene["cables"].push_back({{"a", name_of(a)},
                               {"b", name_of(b)},
                               {"point_a", list_of(ends[0])},
                               {"point_b", list_of(ends[1])}});
  const Vec3 way = glm::normalize(ends[0] - ends[1]);
  Motion6& row = s.add_row(Row::pushes);
  s.push_at(row, b, ends[1], way), s.push_at(row, a, ends[0], -way);
}

/// A round end of a body that stands on a fixed block.
void add_ground(Struck& s, Dice& dice, int body) {
  const Vec3 offset = dice.in_cube(0.05), middle = s.at[std::size_t(body)] + offset;
  s.scene["bodies"][std::size_t(body)]["shape"] = {
      {"type", "sphere"}, {"radius", kRadius}, {"position", list_of(offset)}};
  s.scene["bodies"][std::size_t(body)]["centre_of_mass"] = {0, 0, 0};
  s.scene["bodies"].push_back({{"name", "block" + std::to_string(body)},
                               {"motion", "fixed"},
                               {"position", list_of(middle - Vec3(0, kRadius + 0.05, 0))},
                               {"shape", {{"type", "box"}, {"size", {0.1, 0.1, 0.1}}}}});
  s.push_at(s.add_row(Row::pushes), body, middle, {0, 1, 0});
}

Struck make_struck(unsigned seed, Real speed) {
  Dice dice(seed);
  Struck s;
  s.scene = {{"version", 1},
             {"gravity", {0, 0, 0}},
             {"solver", {{"sleep_speed", 0}}},
             {"collision", {{"friction", 0}}},
             {"bodies", json::array()},
             {"joints", json::array()},
             {"cables", json::array()}};
  std::vector<Vec3> anchors{Vec3(0)};
  for (int i = 0; i < kBodies; ++i) {
    const Vec3 next = anchors.back() + Vec3(0.4, 0, 0) + dice.in_cube(0.1);
    s.at.push_back(0.5 * (anchors.back() + next) + dice.in_cube(0.03));
    anchors.push_back(next);
    s.mass.push_back(dice.any(0.2, 2));
    s.inertia.push_back(s.mass.back() * (Vec3(0.01) + 0.004 * (Vec3(1) + dice.in_cube(1))));
    s.before.push_back(speed * dice.in_cube(1)), s.before.push_back(speed * dice.in_cube(5));
    s.scene["bodies"].push_back({{"name", name_of(i)},
                                 {"position", list_of(s.at.back())},
                                 {"mass", s.mass.back()},
                                 {"inertia", list_of(s.inertia.back())},
                                 {"drag", 0},
                                 {"velocity", list_of(s.before[s.before.size() - 2])},
                                 {"angular_velocity", list_of(s.before.back())}});
  }
  for (int i = dice.coin() ? 0 : 1; i < kBodies; ++i)
    add_hinge(s, dice, i, anchors[std::size_t(i)]);
  const auto near = [&](int body) { return s.at[std::size_t(body)] + dice.in_cube(0.05); };
  add_cable(s, -1, 2, {Vec3(0.8, 1, 0) + dice.in_cube(0.5), near(2)});
  add_cable(s, 0, 3, {near(0), near(3)});
  add_ground(s, dice, 1), add_ground(s, dice, 3);
  return s;
}

Real dot(const Motion6& a, const Motion6& b) {
  Real sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += glm::dot(a[i], b[i]);
  return sum;
}

/// Solves a dense symmetric system in place; false where it is singular.
bool solve_dense(std::vector<std::vector<Real>> a, std::vector<Real>& x) {
  const std::size_t n = x.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t r = k + 1; r < n; ++r)
      if (std::abs(a[r][k]) > std::abs(a[pivot][k])) pivot = r;
    if (std::abs(a[pivot][k]) < 1e-11) return false;
    std::swap(a[k], a[pivot]), std::swap(x[k], x[pivot]);
    for (std::size_t r = 0; r < n; ++r) {
      if (r == k) continue;
      const Real part = a[r][k] / a[k][k];
      for (std::size_t c = k; c < n; ++c) a[r][c] -= part * a[k][c];
      x[r] -= part * x[k];
    }
  }
  for (std::size_t k = 0; k < n; ++k) x[k] /= a[k][k];
  return true;
}

/// The motion after the blow: every choice of rows that push is tried, one passes.
Motion6 motion_after(const Struck& s) {
  const std::size_t n = s.rows.size();
  std::vector<Motion6> gives;  // what an impulse of 1 does
  for (const Motion6& row : s.rows) {
    gives.push_back(row);
    for (std::size_t b = 0; b < kBodies; ++b)
      gives.back()[2 * b] /= s.mass[b], gives.back()[2 * b + 1] /= s.inertia[b];
  }
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < n; ++i)
    if (s.kinds[i] == Row::pushes) free.push_back(i);
  for (std::size_t choice = 0; choice < std::size_t(1) << free.size(); ++choice) {
    std::vector<std::size_t> on;
    for (std::size_t i = 0, f = 0; i < n; ++i)
      if (s.kinds[i] == Row::holds || (choice >> f++ & 1) != 0) on.push_back(i);
    std::vector<std::vector<Real>> w(on.size(), std::vector<Real>(on.size()));
    std::vector<Real> x(on.size());
    for (std::size_t i = 0; i < on.size(); ++i) {
      x[i] = -dot(s.rows[on[i]], s.before);
      for (std::size_t j = 0; j < on.size(); ++j) w[i][j] = dot(s.rows[on[i]], gives[on[j]]);
    }
    if (!solve_dense(w, x)) continue;
    bool right = true;
    Motion6 after = s.before;
    for (std::size_t i = 0; i < on.size(); ++i) {
      right = right && (s.kinds[on[i]] == Row::holds || x[i] >= 0);
      for (std::size_t k = 0; k < after.size(); ++k) after[k] += x[i] * gives[on[i]][k];
    }
    const Real scale = std::sqrt(dot(s.before, s.before));
    for (const std::size_t i : free) right = right && dot(s.rows[i], after) >= -1e-12 * scale;
    if (right) return after;
  }
  FAIL("no choice of rows passes");
  return {};
}

/// One step of the scene.
Motion6 motion_in_step(json scene, const char* integrator, Real h) {
  scene["step"] = scene["duration"] = h;
  scene["solver"]["type"] = "lagrangian", scene["solver"]["integrator"] = integrator;
  const auto read = parse_scene(scene.dump(), "struck");
  REQUIRE(read);
  Simulation sim = Simulation::copy_of(read->world, {h});
  REQUIRE(sim.step().status == Status::ok);
  Motion6 after;
  for (int i = 0; i < kBodies; ++i) {
    const Body& b = sim.world.bodies[sim.world.find(name_of(i))];
    after.push_back(b.velocity), after.push_back(b.angular_velocity);
  }
  return after;
}

}  // namespace

TEST_CASE("stops, cables and ground that are struck at once leave the least kinetic energy") {
  const char* integrator = GENERATE("euler", "rattle", "rk4", "implicit", "radau");
  const Real h = GENERATE(1e-5, 1e-4, 1e-3, 1.0 / 240, 1.0 / 60);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    // So slow that nothing moves by what matters within the step.
    const Struck s = make_struck(seed, 1e-8 / h);
    const Motion6 exact = motion_after(s), found = motion_in_step(s.scene, integrator, h);
    const Real fastest = std::sqrt(dot(s.before, s.before));
    Real off = 0;
    for (std::size_t i = 0; i < exact.size(); ++i)
      off = std::max(off, glm::length(found[i] - exact[i]));
    INFO(integrator << ", step " << h << " s, seed " << seed);
    CHECK(off <= 1e-6 * fastest);
  }
}
