#pragma once
/// What the comparison knows of an engine: a module that offers one function, pantin_peer().
///
/// Modules are opened when the program runs, so that each may be missing and two builds of one
/// engine may stand side by side. They share this file and nothing else; it is C++17, for Simbody's
/// headers are not C++20.
#include <cstddef>
#include <memory>

namespace pantin::peers {

/// Motions are looked at this often, in times a second.
inline constexpr int kFrames = 60;

/// Solid cylinders in a row along x from the origin, at rest, joined by balls, the first held at
/// the origin. Gravity pulls along -y. SI units.
struct Chain {
  int links = 0;
  double length = 0.1, radius = 0.02, density = 1000;
  double gravity = 9.81;

  double mass() const { return density * 3.14159265358979323846 * radius * radius * length; }
  double inertia_along() const { return mass() * radius * radius / 2; }
  double inertia_across() const { return mass() * (3 * radius * radius + length * length) / 12; }
  /// What it can give: the potential energy from level to hanging straight, J.
  double energy() const { return mass() * gravity * length * links * links / 2; }
};

/// Where a link is and how it moves, world axes.
struct LinkState {
  double centre[3], axis[3];  // axis: unit, from the joint before to the joint behind
  double velocity[3], angular_velocity[3];
};

/// Steps and evaluations of the accelerations; below zero where an engine does not tell.
struct Counts {
  long steps = 0, evaluations = 0;
};

/// One chain in one engine.
class Run {
 public:
  virtual ~Run() = default;
  /// Back to the start, with all room for the motion made: not timed.
  virtual void reset() = 0;
  /// Goes on by `frames` frames, in one go where steps adapt. False: the engine gave up.
  virtual bool advance(int frames) = 0;
  /// Of all links, from the held one on.
  virtual void read(LinkState* links) = 0;
  /// Since the reset.
  virtual Counts counts() = 0;
};

struct Method {
  const char* name;
  bool adaptive;  // `setting` is a tolerance, from `loosest` to `tightest`; else steps in a frame
  double loosest, tightest;
  int stride;  // frames that must be taken at once
  bool exact;  // of the solver that is compared; else it stands beside it
  std::unique_ptr<Run> (*start)(const Chain& chain, double setting);
};

struct Engine {
  const char* version;
  const char* built;  // flags of the compiler
  const Method* methods;
  std::size_t count;  // of methods
};

}  // namespace pantin::peers

extern "C" const pantin::peers::Engine* pantin_peer();
