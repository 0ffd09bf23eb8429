// data/procedural.json: numbers computed in 50-digit arithmetic by other routes (matrices and dense
// systems). All components are of order one, except where a target lies a million metres away.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/articulated/procedural/compulsive.hpp"
#include "engine/world/ties.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/stages.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;
using nlohmann::json;

namespace {

constexpr Real kTolerance = 5e-15;

const json& vectors() {
  static const json kAll = json::parse(std::ifstream(test_data("procedural.json")));
  return kAll;
}

Vec3 vec(const json& j) { return {j.at(0), j.at(1), j.at(2)}; }
Quat quat(const json& j) { return Quat(j.at(0), j.at(1), j.at(2), j.at(3)); }
Pose pose(const json& j) { return {vec(j.at("x")), quat(j.at("q"))}; }

/// The bodies of an entry at their predicted poses; parents precede their children.
World world_of(const json& bodies, std::vector<Entity>& made) {
  World world;
  Body wall;
  wall.motion = Motion::fixed;
  const Entity ground = world.add_body(wall);
  for (const json& j : bodies) {
    Body b;
    b.mass = j.at("m"), b.inertia = vec(j.at("I"));
    b.pose = pose(j);
    const Entity e = world.add_body(b);
    const int parent = j.at("parent");
    if (parent >= -1)
      add_link(world, {parent < 0 ? ground : made[static_cast<std::size_t>(parent)],
                       e,
                       {vec(j.at("ra")), vec(j.at("rb"))}});
    made.push_back(e);
  }
  return world;
}

Real miss(Vec3 a, Vec3 b) {
  const Vec3 scale = glm::max(Vec3(1), glm::abs(b)), d = glm::abs(a - b) / scale;
  return std::max({d.x, d.y, d.z});
}
Real miss(Quat a, Quat b) {
  const auto far = [&](Quat q) {
    return std::max(
        {std::abs(q.w - b.w), std::abs(q.x - b.x), std::abs(q.y - b.y), std::abs(q.z - b.z)});
  };
  return std::min(far(a), far(-a));
}
Real miss(const Pose& a, const Pose& b) {
  return std::max(miss(a.position, b.position), miss(a.rotation, b.rotation));
}

Real worst_miss(Stages& s, const std::vector<Entity>& bodies, const json& out) {
  Real worst = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    worst = std::max(worst, miss(s.final(bodies[i]), pose(out.at(i))));
  return worst;
}

bool is_procedural(const json& entry) {
  return entry.at("rule").get<std::string>().starts_with("procedural");
}
bool is_linear(const json& entry) {
  return entry.at("rule").get<std::string>().starts_with("articulated linear");
}

/// One fixed pair by the functions for a single body.
Pose moved(const json& body, Vec3 goal, bool procedural) {
  const Pose at = pose(body);
  const Real mass = body.at("m");
  const Vec3 arm = at.rotation * vec(body.at("rb")), gap = goal - (at.position + arm);
  const Mat3 inertia = world_inertia(at.rotation, vec(body.at("I")));
  const articulated::CompulsiveMotion m =
      procedural ? articulated::literal_rule(
                       arm, gap, articulated::inertia_about_turn(arm, gap, inertia) / mass)
                 : articulated::least_displacement(arm, gap, {mass, inertia});
  return {at.position + m.translation, glm::normalize(m.rotation * at.rotation)};
}

}  // namespace

TEST_CASE("vectors: one body tied to a fixed place") {
  REQUIRE(vectors().at("fixed_two_object").size() == 20);
  for (const json& entry : vectors().at("fixed_two_object")) {
    INFO(entry.at("name") << ", " << entry.at("rule"));
    const json& body = entry.at("body").at(0);
    const Pose expected = pose(entry.at("out").at(0));
    CHECK(miss(moved(body, vec(body.at("ra")), is_procedural(entry)), expected) <= kTolerance);

    std::vector<Entity> bodies;
    Stages stages(world_of(entry.at("body"), bodies));
    if (is_procedural(entry))
      stages.literal(1.0 / 60);
    else
      stages.sweep();
    CHECK(worst_miss(stages, bodies, entry.at("out")) <= kTolerance);
  }
}

TEST_CASE("vectors: how much of its angle the printed rule turns") {
  REQUIRE(vectors().at("procedural_units").size() == 6);
  for (const json& entry : vectors().at("procedural_units")) {
    const Real h = entry.at("dt"), r = entry.at("r"), s = entry.at("s");
    const Real gyration2 = entry.at("I_over_m");
    const Real reluctance = entry.at("h_rule") == "I/m" ? gyration2 : gyration2 * h * h / 2;
    // Any direction of the gap will do: the exponential knows lengths only.
    for (Real phi : {0.3, kPi / 2, 2.5}) {
      const Vec3 arm(0, r, 0), gap = s * Vec3(std::sin(phi), std::cos(phi), 0);
      const articulated::CompulsiveMotion m = articulated::literal_rule(arm, gap, reluctance);
      const Real ratio = glm::length(rotation_vector(m.rotation)) / phi;
      CHECK(std::abs(ratio - entry.at("ratio").get<Real>()) <= kTolerance);
    }
  }
}

TEST_CASE("vectors: two free bodies meet") {
  REQUIRE(vectors().at("free_two_object").size() == 3);
  for (const json& entry : vectors().at("free_two_object")) {
    INFO(entry.at("rule"));
    std::vector<Entity> e;
    Stages s(world_of(entry.at("bodies"), e));
    const json &a = entry.at("bodies").at(0), &b = entry.at("bodies").at(1);
    const Real ma = a.at("m"), mb = b.at("m");
    Pose to[2];
    if (!is_linear(entry)) {
      const Vec3 meet = articulated::meeting_point(ma, to_world(pose(a), vec(b.at("ra"))), mb,
                                                   to_world(pose(b), vec(b.at("rb"))));
      CHECK(miss(meet, vec(entry.at("c"))) <= kTolerance);
      json first = a;
      first["rb"] = b.at("ra");  // the root's side of the joint
      to[0] = moved(first, meet, is_procedural(entry)),
      to[1] = moved(b, meet, is_procedural(entry));
    } else {
      s.inward_pass();
      to[0] = pose(a), to[1] = pose(b);
      s.answer_linearly(to[0], to[1]);
    }
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(miss(to[i], pose(entry.at("out").at(i))) <= kTolerance);
    const Vec3 shift =
        ma * (to[0].position - pose(a).position) + mb * (to[1].position - pose(b).position);
    CHECK(std::abs(glm::length(shift) - entry.at("linear_momentum_shift_m_dx").get<Real>()) <=
          kTolerance);
  }
}

TEST_CASE("vectors: a chain of five and a tree of four limbs") {
  for (const char* which : {"chain_of_5", "tree_4_limbs"}) {
    REQUIRE(vectors().at(which).size() == 2);
    for (const json& entry : vectors().at(which)) {
      INFO(which << ", " << entry.at("rule"));
      std::vector<Entity> bodies;
      Stages s(world_of(entry.at("bodies"), bodies));
      if (is_procedural(entry))
        s.literal(1.0 / 60);
      else
        s.sweep();
      CHECK(worst_miss(s, bodies, entry.at("out")) <= kTolerance);
      CHECK(std::abs(s.action() - entry.at("displacement_action").get<Real>()) <= kTolerance);
    }
  }
}

TEST_CASE("vectors: the update stage") {
  REQUIRE(vectors().at("update").size() == 1);
  const json& v = vectors().at("update").at(0);
  const Real h = v.at("dt"), keep = v.at("k");
  const Vec3 x_before = vec(v.at("x_prev")), x = vec(v.at("x")), a = vec(v.at("a"));
  const Quat q_before = quat(v.at("q_prev")), q = quat(v.at("q"));
  CHECK(miss(articulated::verlet_position(x_before, x, a, {.h = h, .keep = keep}),
             vec(v.at("x_next"))) <= kTolerance);
  CHECK(miss(articulated::verlet_rotation(q_before, q, keep), quat(v.at("q_next"))) <= kTolerance);

  // The same through a step, where the recursion is kept as a velocity.
  World world;
  world.gravity = a;
  world.default_settings.solver = Solver::sweep;
  Body b;
  b.drag = -std::log(keep) / h;
  const Entity e = world.add_body(b);
  Simulation sim = Simulation::copy_of(world, {h});
  sim.step();  // the first step of all would start from rest: half the acceleration
  Body& body = sim.world.bodies[e];
  body.pose = {x, q}, body.restart = true;
  body.velocity = (x - x_before) / h,
  body.angular_velocity = angular_velocity_between(q_before, q, h);
  sim.step();
  CHECK(miss(body.pose, {vec(v.at("x_next")), quat(v.at("q_next"))}) <= kTolerance);
}
