// The rod on two fingers that approach each other, by an engine that knows nothing of modes: Box2D
// steps its dynamics, with a friction that is set anew by slip. Slowly moved, it switches where the
// quasi-static stepper says.
#include <box2d/box2d.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/modes/stepper.hpp"

using namespace pantin;
using namespace pantin::detail::modes;

namespace {

constexpr std::array<Real, 2> kArms{1, 0.7};        // m, of the fingers about the centre, at first
constexpr std::array<Real, 2> kRolling{0.45, 0.4};  // coefficients by finger
constexpr std::array<Real, 2> kSliding{0.3, 0.28};
constexpr Real kSlow = 0.2;  // of the closing speed: slip below it is none

/// The arms of the finger that slides, m, where it stops to.
using Switches = std::array<Real, 3>;

class Dynamics final : public b2ContactListener {
 public:
  explicit Dynamics(Real closing) : closing_(closing) {
    world_.SetContactListener(this), world_.SetAllowSleeping(false);
    b2BodyDef at;
    at.type = b2_dynamicBody, at.position.Set(0, 0.01f);
    rod_ = world_.CreateBody(&at);
    b2PolygonShape box;
    box.SetAsBox(2, 0.01f);
    rod_->CreateFixture(&box, 12.5f);  // 1 kg
    for (int i = 0; i < 2; ++i) {
      b2CircleShape tip;
      tip.m_radius = 0.02f;
      const Real side = i == 0 ? -1 : 1;
      at.type = b2_kinematicBody;
      at.position.Set(static_cast<float>(side * kArms[i]), -tip.m_radius);
      at.linearVelocity.Set(static_cast<float>(-side * closing / 2), 0);
      fingers_[i] = world_.CreateBody(&at), fingers_[i]->CreateFixture(&tip, 0);
    }
  }

  Switches run(Real hz) {
    Switches found{};
    std::size_t count = 0;
    int sliding = 0;  // the left finger slides first
    const Real most = (kArms[0] + kArms[1]) / closing_;
    for (Real t = 0; t < most && count < found.size(); t += 1 / hz) {
      world_.Step(static_cast<float>(1 / hz), 20, 10);
      const int now = slip(0) > slip(1) ? 0 : 1;
      if (t < 0.5 || now == sliding) continue;  // at first it settles
      found[count++] = std::abs(fingers_[sliding]->GetPosition().x - rod_->GetWorldCenter().x);
      sliding = now;
    }
    return found;
  }

 private:
  Real slip(int i) const {
    return std::abs(rod_->GetLinearVelocity().x - fingers_[i]->GetLinearVelocity().x);
  }
  void PreSolve(b2Contact* contact, const b2Manifold*) override {
    const b2Body* one = contact->GetFixtureA()->GetBody();
    const int i = (one == rod_ ? contact->GetFixtureB()->GetBody() : one) == fingers_[1] ? 1 : 0;
    const bool slides = slip(i) > kSlow * closing_;
    contact->SetFriction(static_cast<float>(slides ? kSliding[i] : kRolling[i]));
  }

  Real closing_;
  b2World world_{b2Vec2(0, -10)};
  b2Body* rod_ = nullptr;
  std::array<b2Body*, 2> fingers_{};
};

Switches quasi_static(Real closing) {
  const std::vector<Vec2> rod{{-2, 0}, {2, 0}, {2, 0.02}, {-2, 0.02}};
  const Part part{rod, {0, 0.01}, {0, -10}, 0};
  Stepper stepper;
  Switches found{};
  std::size_t count = 0;
  Real t = 0;
  for (const Real h = 0.25; count < found.size() && t < (kArms[0] + kArms[1]) / closing;) {
    std::vector<Finger> fingers;
    for (int i = 0; i < 2; ++i) {
      const Real side = i == 0 ? -1 : 1, v = -side * closing / 2;
      fingers.push_back(
          {{side * kArms[i] + v * t, 0}, {v, 0}, {}, false, kRolling[i], kSliding[i]});
    }
    const StepEnd end = stepper.step(part, fingers, h);
    REQUIRE(end.ending == Ending::done);
    t += end.time;
    // What slides now is not what slid: the arm of that one stays until it slides again.
    if (end.switches == 0) continue;
    const std::size_t slid = count % 2;
    const Real side = slid == 0 ? -1 : 1;
    found[count++] = std::abs(side * (kArms[slid] - closing / 2 * t) - stepper.placed.shift.x);
  }
  return found;
}

}  // namespace

TEST_CASE("A rod switches fingers under Box2D where the stepper says, the closer the slower") {
  const Switches modes = quasi_static(0.008);
  // l1 mu2R = l2 mu1S, then l2 mu1R = l1 mu2S, and so on; a step of 1 mm.
  CHECK(std::abs(modes[0] - 0.525) < 1.1e-3);
  CHECK(std::abs(modes[1] - 0.525 * 0.28 / 0.45) < 1.1e-3);
  CHECK(std::abs(modes[2] - 0.525 * 0.7 / 1.5) < 1.1e-3);
  const Real ratio = kSliding[0] * kSliding[1] / (kRolling[0] * kRolling[1]);
  const auto error = [&](const Switches& s) {
    return std::max(std::abs(s[1] / kArms[1] / ratio - 1), std::abs(s[2] / s[0] / ratio - 1));
  };
  const Switches fast = Dynamics(0.08).run(240), slow = Dynamics(0.008).run(2000);
  CAPTURE(fast[0], fast[1], fast[2], slow[0], slow[1], slow[2]);
  CHECK(error(slow) < 0.03);
  CHECK(error(fast) > 0.1);
  for (std::size_t i = 0; i < slow.size(); ++i) CHECK(slow[i] == Approx(modes[i]).epsilon(0.03));
}
