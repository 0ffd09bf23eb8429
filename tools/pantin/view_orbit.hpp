#pragma once
// How a user leads the camera.
#include "engine/world/look.hpp"

namespace pantin::program {

using namespace detail;

/// A camera that turns about its target. Never automatic.
class Orbit {
 public:
  /// `home` is where reset() goes back to.
  void start(const Camera& home) { camera_ = home_ = home; }
  void set_home(const Camera& home) { home_ = home; }
  const Camera& camera() const { return camera_; }

  /// About the target, by pixels of the mouse: to the right, down.
  void turn(double right, double down);
  /// Moves what is seen by pixels; `metres` is the size of a pixel at the target.
  void pan(double right, double down, double metres);
  /// Towards the target, by clicks of a wheel.
  void zoom(double clicks);
  void reset() { camera_ = home_; }
  /// Looks at a point from the same side and as far away.
  void look_at(Vec3 point);
  /// The smoothly followed point of the target has moved.
  void move(Vec3 by) { camera_.eye += by, camera_.target += by; }

 private:
  Camera camera_, home_;
};

}  // namespace pantin::program
