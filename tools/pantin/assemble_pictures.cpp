// Pictures of an assembly, iteration by iteration.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tools/pantin/assemble.hpp"
#include "tools/pantin/program.hpp"

#ifdef PANTIN_HAS_RENDER
#include "engine/render/renderer.hpp"
#endif

namespace pantin::program {
namespace {

/// s: how long a film shows one iteration, and its end.
constexpr double kShown = 0.15, kEndShown = 1;

#ifdef PANTIN_HAS_RENDER

/// A camera that sees what two cameras with the same direction see, below the labels.
Camera seeing_both(const Camera& a, const Camera& b, Real aspect) {
  constexpr Real kLabels = 0.15;  // of the height of the picture
  const Vec3 forward = glm::normalize(a.target - a.eye), apart = b.eye - a.eye;
  const Vec3 right = glm::normalize(glm::cross(forward, Vec3(0, 1, 0))),
             up = glm::cross(right, forward);
  const Real tan_y = std::tan(a.field_of_view / 2), depth = glm::distance(a.target, a.eye);
  const Real back = std::max(
      {std::abs(glm::dot(apart, right)) / (aspect * tan_y), std::abs(glm::dot(apart, up)) / tan_y});
  Camera c = a;
  c.eye = 0.5 * (a.eye + b.eye) - 0.5 * (std::abs(glm::dot(apart, forward)) + back) * forward +
          kLabels * depth * (tan_y * up - forward);
  c.target = c.eye + (1 + kLabels) * depth * forward;
  return c;
}

/// The camera of the scene, or one that sees all bodies at the start and at the end if they reach
/// beyond its picture.
void frame(Scene& shown, const Scene& end, const std::string& size) {
  int width = shown.output.width, height = shown.output.height;
  if (!size.empty() && !parse_size(size, width, height)) return;  // is told when they are drawn
  const Real aspect = static_cast<Real>(width) / static_cast<Real>(height);
  shown.view.ground_height =
      std::min(ground_height_of(shown.world, shown.view), ground_height_of(end.world, shown.view));
  const Camera wide = seeing_both(framing_camera(shown.world, shown.view, aspect),
                                  framing_camera(end.world, shown.view, aspect), aspect);
  const Camera& own = shown.view.camera;
  if (own.automatic || glm::dot(wide.eye - own.eye, own.target - own.eye) < 0)
    shown.view.camera = wide;
}

#endif

}  // namespace

int draw_assembly(const PictureChoices& choices, const Scene& scene, const AssemblyFilm& film) {
  if (film.poses.empty()) return kOk;
  Scene shown = scene;
  const auto place = [&](std::size_t iteration) {
    for (std::size_t b = 0; b < film.poses[iteration].size(); ++b)
      shown.world.bodies.values()[b].pose = film.poses[iteration][b];
  };
  place(0);
#ifdef PANTIN_HAS_RENDER
  frame(shown, scene, choices.size);
#endif
  // A film stays at its end; a strip ends there.
  const std::size_t last = film.poses.size() - 1,
                    steps = last + (choices.captured() ? std::size_t(kEndShown / kShown) : 1);
  shown.step = kShown, shown.duration = kShown * static_cast<double>(steps);
  PictureChoices labelled = choices;
  for (std::size_t i = 0; i <= steps; ++i)
    labelled.labels.push_back(fmt::format("iteration {}, residual {:.0e}", std::min(i, last),
                                          film.residuals[std::min(i, last)]));
  auto opened = Pictures::open(labelled, shown, steps_of(shown));
  const auto fail = [](const PictureFailure& f) {
    for (const Error& e : f.errors) complain(e.message);
    return f.exit_code;
  };
  if (auto* f = std::get_if<PictureFailure>(&opened)) return fail(*f);
  Pictures& pictures = *std::get<0>(opened);
  for (std::size_t i = 1; i <= steps; ++i) {
    pictures.before_step(shown.world);
    place(std::min(i, last));
    ++shown.world.tick, shown.world.time += kShown;
    if (!pictures.after_step(shown.world, film.residuals[std::min(i, last)])) break;
  }
  const auto finished = pictures.finish();
  if (const auto* f = std::get_if<PictureFailure>(&finished)) return fail(*f);
  return kOk;
}

}  // namespace pantin::program
