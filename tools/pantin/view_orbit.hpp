#pragma once
// Camera control by the user.
#include "engine/world/look.hpp"

namespace pantin::program {

using namespace detail;

/// A camera that orbits its target. Never automatic.
class Orbit {
 public:
  /// `home` is restored by reset().
  void start(const Camera& home) { camera_ = home_ = home; }
  void set_home(const Camera& home) { home_ = home; }
  const Camera& camera() const { return camera_; }

  /// Orbits the target, by mouse motion in pixels: to the right, down.
  void turn(double right, double down);
  /// Moves the image by pixels; `metres` is the size of a pixel at the target.
  void pan(double right, double down, double metres);
  /// Zooms towards the target, by clicks of a wheel.
  void zoom(double clicks);
  void reset() { camera_ = home_; }
  /// Looks at a point in the same direction and from the same distance.
  void look_at(Vec3 point);
  /// Follows a moving target point.
  void move(Vec3 by) { camera_.eye += by, camera_.target += by; }

 private:
  Camera camera_, home_;
};

}  // namespace pantin::program
