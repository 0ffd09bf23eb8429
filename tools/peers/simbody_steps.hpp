#pragma once
/// Simbody's integrators, as both comparisons use them.
#include <Simbody.h>

#include <exception>
#include <memory>

namespace pantin::peers {

inline std::unique_ptr<SimTK::Integrator> integrator_within(const SimTK::MultibodySystem& system,
                                                            double accuracy) {
  auto made = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
  made->setAccuracy(accuracy);
  return made;
}

/// Of steps of h seconds.
inline std::unique_ptr<SimTK::Integrator> integrator_of(const SimTK::MultibodySystem& system,
                                                        double h) {
  return std::make_unique<SimTK::SemiExplicitEulerIntegrator>(system, h);
}

/// Goes on to a time, s. False: it gave up.
inline bool advance_to(SimTK::Integrator& integrator, double time) {
  try {
    // As a scheduled time and not as one of report: it is stepped to, not interpolated.
    while (integrator.getTime() < time)
      if (integrator.stepTo(time, time) == SimTK::Integrator::EndOfSimulation) return false;
  } catch (const std::exception&) {
    return false;
  }
  return true;
}

}  // namespace pantin::peers
