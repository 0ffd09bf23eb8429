#include "tools/pantin/view_orbit.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::program {

using namespace detail;

namespace {

constexpr double kTurnPerPixel = 0.006;  // rad
constexpr double kSteepest = 1.5;        // rad, above and below the horizon
constexpr double kZoomPerClick = 0.9;    // factor of the distance

}  // namespace

void Orbit::turn(double right, double down) {
  const Vec3 back = camera_.eye - camera_.target;
  const Real distance = glm::length(back);
  if (!(distance > 0)) return;
  const Real around = std::atan2(back.x, back.z) - kTurnPerPixel * right;
  const Real above =
      std::clamp(std::asin(std::clamp(back.y / distance, -1.0, 1.0)) + kTurnPerPixel * down,
                 -kSteepest, kSteepest);
  camera_.eye =
      camera_.target + distance * Vec3(std::cos(above) * std::sin(around), std::sin(above),
                                       std::cos(above) * std::cos(around));
}

void Orbit::pan(double right, double down, double metres) {
  const Vec3 forward = camera_.target - camera_.eye;
  Vec3 side = glm::cross(forward, Vec3(0, 1, 0));
  if (!(glm::length(side) > 0)) side = Vec3(1, 0, 0);
  side = glm::normalize(side);
  const Vec3 up = glm::normalize(glm::cross(side, forward));
  move(metres * (down * up - right * side));
}

void Orbit::zoom(double clicks) {
  const Vec3 back = camera_.eye - camera_.target;
  const Real distance = glm::length(back);
  if (!(distance > 0)) return;
  const Real to = std::clamp(distance * std::pow(kZoomPerClick, clicks), 1e-3, 1e6);
  camera_.eye = camera_.target + to / distance * back;
}

void Orbit::look_at(Vec3 point) {
  if (is_finite(point)) move(point - camera_.target);
}

}  // namespace pantin::program
