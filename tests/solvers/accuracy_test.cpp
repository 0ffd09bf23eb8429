// How near the motion of chains is to that of minimal coordinates, and of which order it is.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

SolverSettings solved_by(Solver solver) {
  SolverSettings s;
  s.solver = solver;
  return s;
}

ChainSpec links(int count) {
  ChainSpec spec;
  spec.links = count;
  return spec;
}

/// When the tip of a chain passes below its holder for the last time, s.
template <class Tip>
Real last_crossing(const Tip& tip_after_step, Real rate, Real duration) {
  Real crossing = 0, before = 1;
  const int steps = static_cast<int>(std::lround(duration * rate));
  for (int i = 1; i <= steps; ++i) {
    const Real now = tip_after_step();
    if ((now > 0) != (before > 0)) crossing = (i - 1 + before / (before - now)) / rate;
    before = now;
  }
  return crossing;
}

}  // namespace

TEST_CASE("a pendulum of 30 degrees stays within 0.7 % of its path at 60 Hz, 0.05 % at 240 Hz") {
  const SwingResult coarse = swing(links(1), 60, 4, solved_by(Solver::articulated));
  const SwingResult fine = swing(links(1), 240, 4, solved_by(Solver::articulated));
  INFO("rms of the tip: " << coarse.rms_error << " at 60 Hz, " << fine.rms_error << " at 240 Hz");
  CHECK(coarse.rms_error < 7e-3);
  CHECK(fine.rms_error < 5e-4);
}

TEST_CASE("after 4 s a pendulum at 60 Hz is early or late by less than 0.2 %") {
  const ChainSpec spec = links(1);
  std::vector<Entity> bodies;
  Simulation sim(chain(spec, &bodies), {1.0 / 60});
  PlanarChain reference(spec);
  const Real found = last_crossing(
      [&] {
        sim.step();
        return tip_of(sim.world, bodies[0], spec).x;
      },
      60, 4);
  const Real exact = last_crossing(
      [&] {
        reference.advance(1.0 / 240, 20);
        return reference.tip().x;
      },
      240, 4);
  INFO("last crossing at " << found << " s, exactly " << exact << " s");
  CHECK(exact > 3);
  CHECK(std::abs(found - exact) < 2e-3 * exact);
}

TEST_CASE("a chain of ten links stays within 1.3 % at 60 Hz and 0.13 % at 240 Hz: second order") {
  const SwingResult coarse = swing(links(10), 60, 4, solved_by(Solver::articulated));
  const SwingResult fine = swing(links(10), 240, 4, solved_by(Solver::articulated));
  INFO("rms of the tip: " << coarse.rms_error << " at 60 Hz, " << fine.rms_error << " at 240 Hz");
  CHECK(coarse.rms_error < 1.3e-2);
  CHECK(fine.rms_error < 1.3e-3);
  CHECK(coarse.rms_error / fine.rms_error > 8);
  CHECK(coarse.energy_max <= coarse.energy_start + 1e-3 * std::abs(coarse.energy_start));
}

TEST_CASE("a sweep that lets no parent give way is wrong by most of a swing, at any rate",
          "[limit]") {
  // Its reaction on the parents is missing, so smaller steps do not help.
  CHECK(swing(links(10), 60, 4, solved_by(Solver::sweep)).rms_error > 0.5);
  CHECK(swing(links(10), 240, 4, solved_by(Solver::sweep)).rms_error > 0.5);
}

TEST_CASE("two Newton steps in start-of-step directions are more accurate where they are stable") {
  // Their bound is omega_max h < 2; ten links have 84 rad/s.
  const SwingResult coarse = swing(links(10), 60, 4, solved_by(Solver::shake2));
  const SwingResult fine = swing(links(10), 240, 4, solved_by(Solver::shake2));
  INFO("rms of the tip: " << coarse.rms_error << " at 60 Hz, " << fine.rms_error << " at 240 Hz");
  CHECK(coarse.rms_error < 5e-3);
  CHECK(fine.rms_error < 4e-4);
}

TEST_CASE("a tip ten thousand times as heavy as the first link is followed to 0.5 %") {
  ChainSpec spec = links(5);
  spec.mass_ratio = 10;
  const SwingResult coarse = swing(spec, 60, 4, solved_by(Solver::articulated));
  const SwingResult fine = swing(spec, 240, 4, solved_by(Solver::articulated));
  INFO("rms of the tip: " << coarse.rms_error << " at 60 Hz, " << fine.rms_error << " at 240 Hz");
  CHECK(coarse.rms_error < 5e-3);
  CHECK(fine.rms_error < 5e-4);
}

TEST_CASE("in space too the error falls with the square of the step") {
  // Three links of spherical inertia, thrown sideways; the reference is the same chain at steps 16
  // times finer still.
  const auto pose_after = [](Real rate) {
    World w;
    Body wall;
    wall.motion = Motion::fixed;
    Entity before = w.add_body(wall);
    Vec3 out(0);
    std::vector<Entity> made;
    for (int i = 0; i < 3; ++i) {
      Body b;
      b.mass = 1 + 0.5 * i, b.inertia = Vec3(0.004 * b.mass), b.drag = 0;
      b.pose.position = {0.15 + 0.3 * i, 0, 0};
      // One rigid turn about the holder, which no joint hinders.
      b.angular_velocity = {0, 2, 1}, b.velocity = glm::cross(b.angular_velocity, b.pose.position);
      const Entity e = w.add_body(b);
      add_link(w, {before, e, {out, {-0.15, 0, 0}}});
      before = e, out = {0.15, 0, 0};
      made.push_back(e);
    }
    Simulation sim(std::move(w), {1 / rate});
    const int steps = static_cast<int>(std::lround(rate));
    for (int i = 0; i < steps; ++i) sim.step();
    std::vector<Vec3> at;
    for (Entity e : made) at.push_back(sim.world.bodies[e].pose.position);
    return at;
  };
  const std::vector<Vec3> reference = pose_after(61440);
  const auto error_at = [&](Real rate) {
    const std::vector<Vec3> at = pose_after(rate);
    Real worst = 0;
    for (std::size_t i = 0; i < at.size(); ++i)
      worst = std::max(worst, glm::length(at[i] - reference[i]));
    return worst;
  };
  const Real e240 = error_at(240), e960 = error_at(960), e3840 = error_at(3840);
  INFO("errors " << e240 << ", " << e960 << ", " << e3840 << " m");
  CHECK(e240 < 1e-2);
  CHECK(e240 / e960 > 12);
  CHECK(e960 / e3840 > 12);
  CHECK(e960 / e3840 < 20);
}

TEST_CASE("30, 60, 120 and 240 Hz agree, with drag as without") {
  // A damped chain of three; the difference to 960 Hz falls with the step, so that nothing in the
  // damping depends on the rate of the frames.
  const Real drag = GENERATE(0.0, 0.3, 3.0);
  const auto path = [&](Real rate) {
    std::vector<Entity> bodies;
    World w = chain(links(3), &bodies);
    for (Entity e : bodies) w.bodies[e].drag = drag;
    Simulation sim(std::move(w), {1 / rate});
    std::vector<Vec3> tips;
    for (int i = 1; i <= 2 * static_cast<int>(rate); ++i) {
      sim.step();
      if (i % (static_cast<int>(rate) / 30) == 0)
        tips.push_back(tip_of(sim.world, bodies.back(), links(3)));
    }
    return tips;
  };
  const std::vector<Vec3> exact = path(3840);
  const auto worst_at = [&](Real rate) {
    const std::vector<Vec3> tips = path(rate);
    REQUIRE(tips.size() == exact.size());
    Real worst = 0;
    for (std::size_t i = 0; i < tips.size(); ++i)
      worst = std::max(worst, glm::length(tips[i] - exact[i]));
    return worst;
  };
  const Real e30 = worst_at(30), e60 = worst_at(60), e120 = worst_at(120), e240 = worst_at(240);
  INFO("drag " << drag << ": " << e30 << ", " << e60 << ", " << e120 << ", " << e240 << " m");
  CHECK(e30 < 0.05);
  CHECK(e60 < 0.015);
  CHECK(e120 < 0.005);
  CHECK(e240 < 0.0015);
}

TEST_CASE("the kinematic sweep loses speed by exp(-c t) at every rate") {
  for (Real rate : {30.0, 60.0, 120.0, 240.0}) {
    World w;
    w.gravity = Vec3(0);
    w.default_settings.solver = Solver::sweep;
    Body b;
    b.drag = 0.7, b.velocity = {1, 0, 0}, b.angular_velocity = {0, 2, 0};
    const Entity e = w.add_body(b);
    Simulation sim(std::move(w), {1 / rate});
    for (int i = 0; i < static_cast<int>(rate); ++i) sim.step();
    CHECK(sim.world.bodies[e].velocity.x == Approx(std::exp(-0.7)).epsilon(1e-12));
    CHECK(sim.world.bodies[e].angular_velocity.y == Approx(2 * std::exp(-0.7)).epsilon(1e-12));
  }
}
