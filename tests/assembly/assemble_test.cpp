// Parts come together from anywhere, as the laws and nothing else say.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/assembly/mechanisms.hpp"

using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::assembly;

namespace {

/// The largest gap of a joint, by the measure of its kind, and of its axes, by the rotation that
/// the kind allows: neither uses the rows of the solver.
Real worst_gap(const World& w) {
  Real worst = 0;
  for (const Link& l : w.links.values()) {
    const Pose a = w.bodies[l.a].pose, b = w.bodies[l.b].pose;
    worst = std::max(worst, info_of(l.joint.kind).gap(l.joint, a, b));
    worst = std::max(worst, violation(l.joint, relative_rotation(l.joint, a.rotation, b.rotation)));
  }
  return worst;
}

AssemblyReport assemble_scattered(World& w, std::uint64_t seed, Real spread,
                                  AssemblyChoices choices = {}) {
  scatter(w, seed, spread, choices.held);
  return assemble(w, choices);
}

bool are_equal(const World& a, const World& b) {
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const Pose &x = a.bodies.values()[i].pose, &y = b.bodies.values()[i].pose;
    if (x.position != y.position || x.rotation != y.rotation) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("assembly: mechanisms close from far random poses") {
  const std::pair<World, Real> all[] = {{bendy(4), 3},   {bendy(20), 3}, {stewart(), 1},
                                        {polygon(3), 1}, {bricard(), 1}, {bent(6), 1}};
  for (const auto& [model, spread] : all)
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      World w = model;
      const AssemblyReport r = assemble_scattered(w, seed, spread);
      CHECK(r.assembled);
      CHECK(r.residual <= 1e-12);
      CHECK(r.wrong_branch.empty());
      CHECK(worst_gap(w) < 1e-7);  // angles of axes by arc cosine: half the digits
    }
}

TEST_CASE("assembly: rank and mobility are those of the mechanism") {
  const struct {
    World world;
    std::size_t rows, rank;
    std::int64_t mobility;
  } all[] = {{polygon(3), 20, 17, 1},
             {bricard(), 30, 29, 1},
             {stewart(), 66, 66, 12},
             {polygon(4), 25, 22, 2},
             {bendy(8), 27, 27, 21}};
  for (const auto& c : all) {
    World w = c.world;
    const AssemblyReport r = assemble_scattered(w, 3, 0.2);
    CHECK(r.assembled);
    CHECK(r.rows == c.rows);
    CHECK(r.rank == c.rank);
    CHECK(r.mobility == c.mobility);
    std::size_t redundant = 0;
    for (const RedundantLaw& l : r.redundant) redundant += static_cast<std::size_t>(l.rows);
    CHECK(redundant == c.rows - c.rank);
  }
}

TEST_CASE("assembly: what holds already stays to the bit") {
  for (const World& model : {bendy(8), stewart(), polygon(3)}) {
    World w = model;
    assemble_scattered(w, 2, 1);
    World again = w;
    CHECK(assemble(again, {}).iterations == 0);
    CHECK(are_equal(again, w));
  }
}

TEST_CASE("assembly: the same start ends in the same bits, held bodies stay") {
  World w = stewart();
  AssemblyChoices choices;
  choices.held = {w.find("platform"), w.find("lower3")};
  const Pose platform = w.bodies[choices.held[0]].pose;
  World again = w;
  CHECK(assemble_scattered(w, 11, 1, choices).assembled);
  CHECK(assemble_scattered(again, 11, 1, choices).assembled);
  CHECK(are_equal(w, again));
  CHECK(w.bodies[choices.held[0]].pose.position == platform.position);
  CHECK(w.bodies[choices.held[0]].pose.rotation == platform.rotation);
}

TEST_CASE("assembly: moves with the whole World") {
  const Pose by{{3, -2, 5}, glm::normalize(Quat(0.3, 0.5, -0.2, 0.8))};
  for (const World& model : {bendy(8), stewart(), bricard()}) {
    World w = model;
    scatter(w, 5, 0.3, {});
    World moved = w;
    for (Body& b : moved.bodies.values()) b.pose = compose(by, b.pose);
    const AssemblyReport here = assemble(w, {}), there = assemble(moved, {});
    CHECK(here.assembled);
    CHECK(there.assembled);
    // Further starts are random in world axes.
    REQUIRE((here.starts == 0 && here.perturbations == 0));
    for (std::size_t i = 0; i < w.bodies.size(); ++i) {
      const Pose expected = compose(by, w.bodies.values()[i].pose),
                 found = moved.bodies.values()[i].pose;
      CHECK(glm::distance(expected.position, found.position) < 1e-7);
    }
  }
}

TEST_CASE("assembly: Levenberg-Marquardt only goes down") {
  World w = bendy(8);
  AssemblyChoices choices;
  choices.method = &methods()[2];
  REQUIRE(choices.method->name == "lm");
  std::vector<Real> merits;
  choices.watch = [&](const Iteration& i) { merits.push_back(i.merit); };
  CHECK(assemble_scattered(w, 4, 3, choices).assembled);
  REQUIRE(merits.size() > 5);
  CHECK(std::is_sorted(merits.rbegin(), merits.rend()));
}

TEST_CASE("assembly: limits hold, and the unlimited mechanism would violate them") {
  World free = polygon(6);
  int violated = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    World w = free;
    for (Link& l : w.links.values()) l.joint.limits.edit().angle = {true, -0.5, 0.5};
    scatter(w, seed, 0.7, {});
    World without = w;
    for (Link& l : without.links.values()) l.joint.limits.edit().angle.on = false;
    CHECK(assemble(without, {}).assembled);
    const AssemblyReport r = assemble(w, {});
    CHECK(r.assembled);
    const auto beyond = [](const World& of) {
      Real most = 0;
      for (const Link& l : of.links.values()) {
        const Quat q =
            relative_rotation(l.joint, of.bodies[l.a].pose.rotation, of.bodies[l.b].pose.rotation);
        most = std::max(most, std::abs(std::remainder(2 * std::atan2(q.x, q.w), 2 * kPi)));
      }
      return most;
    };
    CHECK(beyond(w) < 0.5 + 1e-9);
    violated += beyond(without) > 0.5 + 1e-3;
  }
  CHECK(violated > 0);
}

TEST_CASE("assembly: a chain that is too short shares its gap as the weights say") {
  // Two links of 1 m between points 3 m apart. Joints to the ground move one body, the joint
  // between them two, so it takes twice their share of the gap of 1 m.
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity one = add_solid(w, {{0.6, 0.1, 0}, kIdentity}, "one"),
               two = add_solid(w, {{2.3, 0.1, 0}, kIdentity}, "two");
  const auto ball = [&](Entity a, Vec3 at_a, Entity b, Vec3 at_b, const char* name) {
    Joint j;
    j.anchor_a = at_a, j.anchor_b = at_b;
    add_link(w, {a, b, j}, name);
  };
  const Vec3 half(0.5, 0, 0);
  ball(ground, Vec3(0), one, -half, "left"), ball(one, half, two, -half, "middle");
  ball(two, half, ground, {3, 0, 0}, "right");
  const AssemblyReport r = assemble(w, {});
  CHECK_FALSE(r.assembled);
  REQUIRE(r.residuals.size() == 3);
  CHECK(w.name_of(r.residuals[0].law) == "middle");
  CHECK(r.residuals[0].residual == Approx(0.5).margin(1e-6));
  CHECK(r.residuals[1].residual == Approx(0.25).margin(1e-6));
  CHECK(r.residuals[2].residual == Approx(0.25).margin(1e-6));
  CHECK(r.contradictory.size() == 3);
}

TEST_CASE("assembly: leaves a saddle by a perturbation that it reports") {
  // A rod whose ends belong to each other's places: all forces are along it.
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity rod = add_solid(w, {{0.5, 0, 0}, from_rotation_vector({0, 0, kPi})}, "rod");
  Joint j;
  j.anchor_b = {-0.5, 0, 0};
  add_link(w, {ground, rod, j}, "left");
  j.anchor_a = {1, 0, 0}, j.anchor_b = {0.5, 0, 0};
  add_link(w, {ground, rod, j}, "right");
  const AssemblyReport r = assemble(w, {});
  CHECK(r.assembled);
  CHECK(r.perturbations > 0);
}

TEST_CASE("assembly: joints leave spurious branches") {
  World w = polygon(3);
  const Entity link = w.find("link1");
  w.bodies[link].pose.rotation = w.bodies[link].pose.rotation * from_rotation_vector({kPi, 0, 0});
  const AssemblyReport r = assemble(w, {});
  CHECK(r.assembled);
  CHECK(r.turned_over > 0);
  CHECK(r.wrong_branch.empty());
}

TEST_CASE("assembly: every method closes what is nearly closed") {
  for (const Method& m : methods()) {
    World w = bendy(4);
    AssemblyChoices choices;
    choices.method = &m;
    choices.effort.tolerance = 1e-8, choices.effort.iterations = 20000, choices.starts = 0;
    const AssemblyReport r = assemble_scattered(w, 1, 0, choices);
    INFO(m.name);
    CHECK(r.assembled);
    CHECK(worst_gap(w) < 1e-7);
  }
}

TEST_CASE("assembly: the gradient has the same bits for any number of threads") {
  World first;
  for (const int threads : {1, 2, 3}) {
    World w = stewart();
    AssemblyChoices choices;
    choices.method = &methods()[3];
    REQUIRE(choices.method->name == "gradient");
    choices.effort = {1e-3, 500, threads}, choices.starts = 0;
    choices.finds_contradictions = false;
    assemble_scattered(w, 6, 0.3, choices);
    if (threads == 1)
      first = w;
    else
      CHECK(are_equal(w, first));
  }
}
