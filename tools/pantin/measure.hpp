#pragma once
// Measurements of a scene under a choice of solver, integrator and step: its motion at given times,
// what it cost, what it counted. `pantin chart` and `pantin stability` are made of these.
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "tools/pantin/program.hpp"

namespace pantin::program {

/// A way to run a scene.
struct Method {
  std::string name;  // "auto", "lagrangian/rk4", "lagrangian/radau/tolerance"
  SolverChoices choices;
  bool is_adaptive = false;  // its accuracy is set by a tolerance, its step is the longest one
};

/// All ways to run a whole scene: every solver, the Lagrangian solver with every integrator, and
/// with every tolerance that its integrators take. "scene" stands for the settings of the file.
std::vector<Method> all_methods();
/// The method of that name, or nothing.
std::optional<Method> method_named(std::string_view name);

/// A scene as one method runs it, or why that method refuses it.
struct Loaded {
  Method method;
  std::optional<Scene> scene;
  std::string refusal;
};
/// Reads a scene from the text of its file. A scene of which the method would leave a part out is
/// refused, too: it would be another scene.
Loaded load(const std::string& path, std::string_view text, const Method& method);

/// Equidistant times, from 0 to count * interval: the ends of intervals, which are steps of all
/// runs, and `between` parts of each.
struct Sampling {
  double interval = 0;  // s
  int count = 0, between = 1;
  double duration() const { return interval * count; }
  double spacing() const { return interval / between; }
  std::size_t samples() const {
    return static_cast<std::size_t>(count) * static_cast<std::size_t>(between) + 1;
  }
};

/// The motion of the bodies that are dynamic at the start, at the times of a sampling. Between the
/// steps of a run it is interpolated, by Hermite's cubic through its poses and velocities.
struct Track {
  std::vector<std::string> names;
  std::vector<Vec3> centres;     // m, of mass, in the bodies' own frames
  std::vector<double> radii;     // m: from the mass centre to the farthest point
  std::vector<Pose> poses;       // of the bodies' own frames: all at time 0, all at the next time
  std::vector<double> energies;  // J, by time; NaN between steps
  std::uint64_t steps = 1, between = 1;  // in an interval of the sampling
  std::size_t samples() const { return energies.size(); }
  bool is_step(std::size_t sample) const { return sample * steps % between == 0; }
};
/// Of the bodies of a World, without motion. The radius is the reach of a body's shapes, or its
/// radius of gyration if it has none.
Track track_for(const World& world);

/// What solvers count, summed over islands and steps.
struct Counts {
  std::uint64_t steps = 0, factorisations = 0, iterations = 0, substeps = 0, sweeps = 0;
};

/// A run and its measures.
struct Outcome {
  std::string status = "ok";  // as in run_status(); "stopped" where it was not ended
  std::string reason;         // of another status, a clause
  double ended_at = 0;        // s
  Track track;                // up to there
  Counts counts;
  double gap = 0;                                // m, the widest of joints, pins and cables
  double gap_rel = 0;                            // of joints, as a fraction of the mechanism's size
  double depth = 0;                              // m, the deepest overlap
  double seconds = 0;                            // s, CPU time of the steps with their measures
  double slowest = 0;                            // s, CPU time of the slowest step
  int unsolved = 0, rescued = 0, unreached = 0;  // steps with such islands, pins or cables
  std::vector<Finding> findings;
  bool is_ok() const { return status == "ok"; }
};

/// The word of a status of steps.
std::string_view run_status(Status status);

/// Parameters of a run.
struct Trial {
  const Scene* scene = nullptr;
  double step = 0;       // s; intervals of the sampling are multiples of it
  double tolerance = 0;  // of an adaptive method
  Sampling sampling;
  bool watch = false;  // also lists findings
  /// Asked after each step with the CPU seconds so far; true stops the run.
  std::function<bool(double)> stop = {};
  /// Called after each step.
  std::function<void(const World&, const StepReport&)> look = {};
};

/// Hands a track the states of a run, step by step.
class Sampler {
 public:
  Sampler(const Trial& trial, const World& world, Track& track);
  /// After a step: all times of the sampling up to there.
  void take(const World& world, double energy);

 private:
  struct State {
    Pose pose;
    Vec3 velocity{0}, angular_velocity{0};
  };
  void add(const World& world, double part);
  Track& track_;
  std::vector<Entity> bodies_;
  std::vector<State> before_, now_;  // of the last two steps
  double step_ = 0;                  // s
  std::uint64_t taken_ = 0;          // steps
};

/// Steps in so many seconds, at least one.
std::uint64_t steps_in(double seconds, double step);

/// Seconds of a steady clock on the wall.
double wall_seconds();

Outcome run_motion(const Trial& trial);

/// CPU time of the steps alone, without measures, s: the mean of as many runs as a fiftieth of a
/// second holds. The first step of a run, which builds its structure, is not timed; one more at its
/// end takes its place. Not a number if the run fails.
double time_run(const Trial& trial);

/// The greatest differences of two motions.
struct Apart {
  double position = 0;     // m, of points of a body: of its mass centre, and its radius times the
                           // angle between its rotations; where these are unknown, of its origin
  double origin = 0;       // m, of the origins of the bodies' frames alone
  double orientation = 0;  // rad; NaN where it is unknown
  double energy = 0;       // J, at steps; NaN where it is unknown
};
/// Over the first `samples` times at which both have steps. Where the steps of one are so long that
/// interpolation between them misses more than a tenth of the way of a body, as where a wheel turns
/// once in a step, that body is compared between them, too.
Apart apart(const Track& a, const Track& b, std::size_t samples);
/// The number of times, from the first on, at which no body is further apart than `most`, m.
std::size_t agreement(const Track& a, const Track& b, double most);
/// The diagonal of the box that encloses all positions of a motion, m; 1 if nothing moves.
double size_of(const Track& motion);
/// What errors are fractions of: that diagonal, or the diameter of the largest body if that is
/// longer, m.
double scale_of(const Track& motion);

/// The motion that others are compared with.
struct Reference {
  std::string method;  // or the name of a file
  double step = 0;     // s; 0: from a file
  Track track;
  std::size_t agreed = 0;    // samples up to which the last two refinements agree
  std::size_t compared = 0;  // of these: all of the time, or the first half of what agrees
  Apart own;        // its own error: the difference of the two, over these; NaN where it is unknown
  double size = 1;  // m, of the motion: see scale_of()
  /// What every method that was tried agreed to.
  struct Tried {
    std::string method;
    double step = 0;  // s
    Apart own;
    std::size_t agreed = 0;
  };
  std::vector<Tried> tried;
  bool is_whole(const Sampling& of) const { return agreed == of.samples(); }
  bool holds() const { return compared > 1; }
};

/// Refinements agree where they differ by less than this part of the motion's size. Where they
/// part, the motion amplifies errors: over the first half of the time until then the error of the
/// reference is that of kAgreement squared, and the errors of others are not yet as large as the
/// motion itself. Where an event follows, refinements that come closer over the whole time agree if
/// they differ by less than kConverges there.
inline constexpr double kAgreement = 1e-4, kConverges = 1e-2;
/// A run follows the reference while it differs by less than this part of the motion's size.
inline constexpr double kFollows = 1e-2;

/// A search for the reference.
struct Search {
  Sampling sampling;
  double step = 0;     // s, of the first run
  double seconds = 0;  // of a clock on the wall that it may take
};
/// Halves the step of the most accurate method until two runs agree to 1e-11 of the size of the
/// motion, no longer come closer, or the time is over. Where that method does not agree with itself
/// over the whole time, others are tried. The result may hold for less than the whole time.
Reference find_reference(std::span<const Loaded> methods, const Search& search);

/// A motion from a file as `pantin run --record` writes it: time_s, NAME.x, .y, .z, .qx, .qy, .qz,
/// .qw and energy_j. Its times are equidistant; `sampling` becomes them, with intervals of several
/// such that at most `most` remain. Bodies that the file leaves out are not compared. Its own error
/// is unknown.
Result<Reference> read_reference(const std::string& path, const World& world, int most,
                                 Sampling& sampling);

/// The time of the first event after so many samples, s; nothing if these are all, or none follows.
std::optional<double> event_after(const World& world, const Sampling& sampling,
                                  std::size_t samples);

/// Divides the intervals of a sampling: into so many parts that there are two hundred at least, and
/// further, as memory allows, until they are far shorter than the longest step, of which an
/// interval has `longest`. Shorter steps then are steps of the sampling.
void divide(Sampling& sampling, std::uint64_t longest, std::size_t bodies);
/// The number of poses that a track may have.
inline constexpr std::size_t kMostPoses = 400000;

}  // namespace pantin::program
