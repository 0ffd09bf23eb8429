// A chain dropped over a box and a ball stays there: friction holds it.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("drape");
  demos::Extras extras;
  extras.last_picture = 1.2;
  extras.check = [](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    Real squares = 0, over_box = 0, over_ball = 0;
    int links = 0;
    const Vec3 box = w.bodies[w.find("box")].pose.position;
    const Vec3 ball = w.bodies[w.find("ball")].pose.position;
    for (const Body& b : w.bodies.values()) {
      if (b.motion != Motion::dynamic) continue;
      const Vec3 p = b.pose.position;
      squares += glm::dot(b.velocity, b.velocity), ++links;
      over_box += std::abs(p.x - box.x) < 0.22 && std::abs(p.z - box.z) < 0.25 && p.y > 0.5;
      over_ball += glm::length(p - ball) < 0.42 && p.y > ball.y + 0.28;
    }
    f.expect("links on the box", over_box, 8, 11);
    f.expect("links on the upper half of the ball", over_ball, 10, 16);
    f.expect("rms speed at the end, m/s", std::sqrt(squares / links), 0, 5e-3);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 5e-3);
  };
  return demos::run(argc, argv, {.name = "drape", .scene = scene, .extras = extras});
}
