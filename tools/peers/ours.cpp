// The chain in pantin.
#include <iterator>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/ties.hpp"
#include "tools/peers/peer.hpp"

namespace {

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::peers;

World build(const Chain& chain) {
  World w;
  w.gravity = {0, -chain.gravity, 0};
  Body ground;
  ground.motion = Motion::fixed;
  Entity before = w.add_body(ground);
  const Real half = chain.length / 2;
  for (int i = 0; i < chain.links; ++i) {
    Body b;
    b.mass = chain.mass();
    b.inertia = {chain.inertia_along(), chain.inertia_across(), chain.inertia_across()};
    b.pose.position = {(2 * i + 1) * half, 0, 0};
    b.drag = 0;
    const Entity e = w.add_body(b);
    Joint ball;
    ball.kind = JointKind::ball;
    ball.anchor_a = i == 0 ? Vec3(0) : Vec3(half, 0, 0);
    ball.anchor_b = {-half, 0, 0};
    add_link(w, {before, e, ball});
    before = e;
  }
  return w;
}

struct Way {
  Solver solver;
  Integrator integrator;
  int evaluations;      // of a step of the integrator; 0: it does not tell
  int step_frames = 0;  // frames of an adaptive step as a whole
};

class OurRun final : public Run {
 public:
  OurRun(const Chain& chain, const Way& way, double setting) : chain_(chain), way_(way) {
    start_ = build(chain);
    SolverSettings& settings = start_.default_settings;
    settings.solver = way.solver, settings.integrator = way.integrator;
    if (way.step_frames > 0) {
      settings.step_tolerance = setting;
      h_ = Real(way.step_frames) / kFrames;
    } else {
      steps_in_frame_ = static_cast<int>(setting);
      h_ = 1 / (kFrames * setting);
    }
    compile_if_changed(start_);
    reset();
  }

  void reset() override {
    sim_.world = start_;
    articulated::prepare(sim_.world), lagrangian::prepare(sim_.world);
    sim_.settings.h = h_;
    counts_ = {};
  }

  bool advance(int frames) override {
    const int steps = way_.step_frames > 0 ? frames / way_.step_frames : frames * steps_in_frame_;
    for (int i = 0; i < steps; ++i) {
      const StepReport report = sim_.step();
      counts_.steps += way_.solver == Solver::lagrangian ? report.substeps : 1;
      if (report.status != Status::ok) return false;
    }
    counts_.evaluations = way_.evaluations > 0 ? counts_.steps * way_.evaluations : -1;
    return true;
  }

  void read(LinkState* links) override {
    for (std::size_t i = 0; i < static_cast<std::size_t>(chain_.links); ++i) {
      const Body& b = sim_.world.bodies.values()[i + 1];
      const Vec3 axis = b.pose.rotation * Vec3(1, 0, 0);
      for (int k = 0; k < 3; ++k) {
        links[i].centre[k] = b.pose.position[k], links[i].axis[k] = axis[k];
        links[i].velocity[k] = b.velocity[k], links[i].angular_velocity[k] = b.angular_velocity[k];
      }
    }
  }

  Counts counts() override { return counts_; }

 private:
  Chain chain_;
  Way way_;
  World start_;
  Simulation sim_;
  Real h_ = 0;
  int steps_in_frame_ = 1;
  Counts counts_;
};

template <Solver solver, Integrator integrator, int evaluations, int step_frames = 0>
std::unique_ptr<Run> make(const Chain& chain, double setting) {
  return std::make_unique<OurRun>(chain, Way{solver, integrator, evaluations, step_frames},
                                  setting);
}

constexpr Solver kExact = Solver::lagrangian;
constexpr Method kMethods[] = {
    {"euler", false, 0, 0, 1, true, make<kExact, Integrator::euler, 1>},
    {"rattle", false, 0, 0, 1, true, make<kExact, Integrator::rattle, 1>},
    {"rk4", false, 0, 0, 1, true, make<kExact, Integrator::rk4, 4>},
    {"implicit", false, 0, 0, 1, true, make<kExact, Integrator::implicit, 0>},
    {"rk54 by frames", true, 1e-1, 1e-10, 1, true, make<kExact, Integrator::rk4, 7, 1>},
    {"rk54 in one go", true, 1e-1, 1e-10, kFrames, true, make<kExact, Integrator::rk4, 7, kFrames>},
    {"auto", false, 0, 0, 1, false, make<Solver::articulated, Integrator::rk4, 0>},
};
constexpr Engine kEngine{PANTIN_PEERS_COMMIT, PANTIN_PEERS_FLAGS, kMethods, std::size(kMethods)};

}  // namespace

extern "C" const Engine* pantin_peer() { return &kEngine; }
