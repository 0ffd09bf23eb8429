// Claims of the scenes of laminas: parts held or pushed by fingers.
#include <sstream>

#include "engine/modes/feasible.hpp"
#include "engine/modes/lamina_plan.hpp"
#include "engine/world/lamina.hpp"
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;
namespace modes = pantin::detail::modes;

namespace {

/// What the reports of a run tell of the lamina.
struct Told {
  int switches = 0, to_dynamics = 0, back = 0;
  std::string why;
};

Told run(World& world, Real h, Real until) {
  Simulation sim(std::move(world), {h});
  Told told;
  while (sim.world.time < until - h / 2) {
    const StepReport r = sim.step();
    REQUIRE(r.status == Status::ok);
    told.switches += r.mode_switches;
    if (!r.lamina) continue;
    (*r.changed ? told.to_dynamics : told.back) += 1;
    if (*r.changed) told.why = r.changed;
  }
  world = std::move(sim.world);
  return told;
}

/// The modes at the start, at the friction of the file.
modes::ModeSet modes_of(const Scene& scene) {
  const detail::LaminaPlan& plan = scene.laminas->front();
  std::vector<modes::Contact> contacts;
  std::vector<Real> roll, slide;
  for (const detail::FingerPlan& f : plan.fingers) {
    contacts.push_back({f.point, f.normal, detail::first_velocity(f)});
    roll.push_back(f.roll), slide.push_back(f.slide);
  }
  modes::Prepared prepared;
  modes::prepare({contacts, plan.load()}, prepared);
  modes::ModeSet set;
  modes::find_modes(prepared, {roll, slide}, set);
  return set;
}

}  // namespace

CLAIM("rod", "the fingers take turns to slide, and end close to each other below the mass centre") {
  const Played p = play("rod");
  World again = p.scene.world;
  const Told told = run(again, p.scene.step, p.scene.duration);
  CHECK(told.switches == 8);
  CHECK(told.to_dynamics == 1);  // at the start two modes hold
  CHECK(told.back == 1);
  // By hand: arms shrink by 0.6 from switch to switch.
  CHECK(p.place("rod").x - p.start("rod").x == Approx(-0.0742).margin(1e-3));
  const Real centre = p.body("rod").pose.position.x;
  CHECK(p.place("rod/left").x < centre);
  CHECK(p.place("rod/right").x > centre);
  CHECK(p.place("rod/right").x - p.place("rod/left").x == Approx(0.01).margin(1e-9));
  CHECK(p.body("rod").pose.position.y == Approx(0.01).margin(1e-6));
}

CLAIM("push", "the box goes where the finger pushes it, which climbs its side") {
  const Played p = play("push");
  CHECK(p.place("box").x - p.start("box").x == Approx(0.4).epsilon(1e-6));
  CHECK(p.place("box").y == Approx(0).margin(1e-9));
  CHECK(angle_of(p.end, p.end.find("box")) == Approx(0).margin(1e-9));
  CHECK(p.place("box/finger").y - p.start("box/finger").y == Approx(0.08).epsilon(1e-9));
  CHECK(p.last.handed_over == 0);
}

CLAIM("peg", "it goes in where friction is low, and jams where it is high") {
  const Played p = play("peg");
  CHECK(p.last.handed_over == 0);
  CHECK(p.place("peg").y - p.start("peg").y < -0.09);
  World rough = p.scene.world;
  for (detail::Lamina& lamina : detail::laminas_of(rough).values())
    for (detail::LaminaFinger& f : lamina.fingers) f.roll = f.slide = 0.9;
  const Told told = run(rough, p.scene.step, 1);
  CHECK(told.to_dynamics >= 1);
  CHECK(told.why.find("no mode has both") != std::string::npos);
}

CLAIM("regrasp", "the bar stays held while the fingers change places") {
  Extent height, angle;
  const Played p = play("regrasp", [&](const World& w) {
    height.add(w.bodies[w.find("bar")].pose.position.y), angle.add(angle_of(w, w.find("bar")));
  });
  CHECK(height.least > 0.01);
  CHECK(height.most < 0.06);
  CHECK(std::max(-angle.least, angle.most) < 0.08);
  // In the end the first and the third carry it, the second is below.
  CHECK(p.place("bar/second").y < -0.04);
  CHECK(p.last.handed_over == 0);
  CHECK(p.last.contacts == 2);
  CHECK(std::abs(p.place("bar").x - p.start("bar").x) < 0.005);
}

CLAIM("grasp", "friction decides which finger sticks") {
  const Played p = play("grasp");
  CHECK(p.end.bodies.size() == 0);  // without an outline it is no body
  const modes::ModeSet now = modes_of(p.scene);
  REQUIRE(now.modes.size() == 1);
  Scene slippery = p.scene;
  auto plans = *slippery.laminas;
  for (std::size_t i : {0, 1}) plans.front().fingers[i].roll = plans.front().fingers[i].slide = 0;
  slippery.laminas = std::make_shared<const std::vector<detail::LaminaPlan>>(plans);
  const modes::ModeSet then = modes_of(slippery);
  REQUIRE(then.modes.size() == 1);
  // All slide at 0.5; the middle finger sticks where the two others are smooth.
  CHECK(now.modes[0].force[0] > 0);
  CHECK(now.modes[0].region == 0);
  CHECK(then.modes[0].region > 0);
}

CLAIM("ambiguous", "four modes hold at once") {
  const Played p = play("ambiguous");
  const modes::ModeSet now = modes_of(p.scene);
  CHECK(now.verdict == modes::Verdict::ambiguous);
  CHECK(now.modes.size() == 4);
}
