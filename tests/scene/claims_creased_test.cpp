// Claims of the scene of bodies that touch by edges and corners of NURBS faces.
#include <cmath>

#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

CLAIM("brackets",
      "what is stacked stays on one another, the slider in its rail, the peg in its hole") {
  Real aside = 0, off_rail = 0;
  bool has_left = false;
  const Quat tilt(std::cos(25 * kPi / 360), std::sin(25 * kPi / 360), 0, 0);
  const Played p = play("brackets", [&](const World& w) {
    // The slider in the rail's own frame, until it comes out below.
    const Vec3 at =
        glm::conjugate(tilt) * (w.origin_pose(w.find("slider")).position - Vec3(-0.55, 0.2, -0.1));
    has_left = has_left || at.z > 0.25;
    if (!has_left) {
      aside = std::max(aside, std::abs(at.x));
      off_rail = std::max(off_rail, std::abs(at.y - 0.04));
    }
  });
  CHECK(has_left);
  CHECK(aside <= 1.5e-3);     // a millimetre to spare
  CHECK(off_rail <= 1.5e-3);  // half a millimetre
  // Brackets, each a plate of 0.03 m above the one below.
  for (const auto& [name, height] :
       {std::pair{"bracket_1", 0.05}, {"bracket_2", 0.08}, {"bracket_3", 0.11}})
    CHECK(p.place(name).y == Approx(height).margin(5e-4));
  CHECK(p.place("bracket_2").x - p.place("bracket_1").x >= 0.0295);
  CHECK(p.place("bracket_3").x - p.place("bracket_2").x >= 0.0295);
  // The peg stands on the floor, half a millimetre of play around it.
  CHECK(p.place("peg").y == Approx(0.1).margin(5e-4));
  CHECK(std::hypot(p.place("peg").x - 0.45, p.place("peg").z - 0.25) <= 1e-3);
  // The pot stands in its tray.
  CHECK(p.place("tray").y == Approx(0).margin(5e-4));
  CHECK(p.place("pot").y == Approx(0.012).margin(5e-4));
  CHECK(glm::distance(p.place("pot"), p.place("tray")) <= 0.1);
  CHECK(fastest(p.end) <= 0.02);
  CHECK(p.worst_depth <= 2e-3);
}
