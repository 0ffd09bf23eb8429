#include "engine/world/kinematic_path.hpp"

namespace pantin {

Pose pose_at(const KinematicPath& path, Real time) {
  return std::visit([time](const auto& curve) { return curve.at(time); }, path.curve);
}

KinematicPath moved(const KinematicPath& path, const Pose& by) {
  KinematicPath result = path;
  std::visit([&](auto& curve) { curve.move(by); }, result.curve);
  return result;
}

KinematicPath shifted(const KinematicPath& path, Real ahead) {
  KinematicPath result = path;
  std::visit([&](auto& curve) { curve.shift(ahead); }, result.curve);
  return result;
}

namespace detail {

KinematicPath started(const KinematicPath& path, const Pose& start) {
  KinematicPath result = path;
  std::visit([&](auto& curve) { curve.start_from(start); }, result.curve);
  return result;
}

PathBounds bounds_of(const KinematicPath& path) {
  return std::visit([](const auto& curve) { return curve.bounds(); }, path.curve);
}

std::size_t parts_of(const KinematicPath& path) {
  return std::visit(
      [](const auto& curve) -> std::size_t {
        if constexpr (requires { curve.parts(); })
          return curve.parts();
        else
          return 0;
      },
      path.curve);
}

Pose seam_of(const KinematicPath& path) {
  return std::visit(
      [](const auto& curve) -> Pose {
        if constexpr (requires { curve.seam(); })
          return curve.seam();
        else
          return {};
      },
      path.curve);
}

}  // namespace detail
}  // namespace pantin
