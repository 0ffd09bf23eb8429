#include "tools/pantin/strip_times.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr std::size_t kMostSamples = 4000;
constexpr double kReturn = 0.02;  // of the largest displacement: the configuration has returned
constexpr double kRepeat = 0.05;  // the same, for all configurations of the period before
constexpr double kLeft = 0.3;     // it has left the configuration before it returns
constexpr int kCompared = 24;     // times in a period

using Configuration = std::vector<double>;

/// Three points of each body that moves: its mass centre, and two at its usual reach, so that
/// rotations count.
Configuration configuration_of(const World& world, double reach) {
  Configuration x;
  for (const Body& b : world.bodies.values()) {
    if (b.motion == Motion::fixed) continue;
    for (const Vec3 arm : {Vec3(0), Vec3(reach, 0, 0), Vec3(0, reach, 0)}) {
      const Vec3 p = to_world(b.pose, arm);
      x.insert(x.end(), {p.x, p.y, p.z});
    }
  }
  return x;
}

/// Half the mean distance between mass centres and their middle; 0.1 m for bodies in one place.
double usual_reach(const World& world) {
  Vec3 middle(0);
  double count = 0, sum = 0;
  for (const Body& b : world.bodies.values()) middle += b.pose.position, ++count;
  for (const Body& b : world.bodies.values())
    sum += 0.5 * glm::distance(b.pose.position, middle / count) / count;
  return sum > 0 && std::isfinite(sum) ? sum : 0.1;
}

/// A sampled run, at equal intervals.
class Track {
 public:
  double interval = 0;  // s
  std::vector<Configuration> samples;

  double end() const { return interval * static_cast<double>(samples.size() - 1); }
  double distance(std::size_t i, const Configuration& to) const {
    double sum = 0;
    for (std::size_t k = 0; k < to.size(); ++k) {
      const double d = samples[i][k] - to[k];
      sum += d * d;
    }
    return std::sqrt(sum);
  }
  /// Interpolated linearly.
  Configuration at(double time) const {
    const double where = std::clamp(time / interval, 0.0, static_cast<double>(samples.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(where), samples.size() - 2);
    const double part = where - static_cast<double>(i);
    Configuration x = samples[i];
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += part * (samples[i + 1][k] - x[k]);
    return x;
  }
  /// The point of the segment from sample i to the next one that is nearest to a configuration: its
  /// time and distance.
  std::pair<double, double> nearest(std::size_t i, const Configuration& to) const {
    double along = 0, length2 = 0;
    for (std::size_t k = 0; k < to.size(); ++k) {
      const double d = samples[i + 1][k] - samples[i][k];
      along += d * (to[k] - samples[i][k]), length2 += d * d;
    }
    const double part = length2 > 0 ? std::clamp(along / length2, 0.0, 1.0) : 0;
    const double time = interval * (static_cast<double>(i) + part);
    const Configuration x = at(time);
    double sum = 0;
    for (std::size_t k = 0; k < to.size(); ++k) sum += (x[k] - to[k]) * (x[k] - to[k]);
    return {time, std::sqrt(sum)};
  }
};

/// Whether the last two periods are alike, and the same way round.
bool repeats(const Track& track, double period, double span) {
  for (int i = 0; i < kCompared; ++i) {
    const double time = track.end() - period * i / kCompared;
    const Configuration now = track.at(time), before = track.at(time - period);
    double sum = 0;
    for (std::size_t k = 0; k < now.size(); ++k) sum += (now[k] - before[k]) * (now[k] - before[k]);
    if (std::sqrt(sum) > kRepeat * span) return false;
  }
  return true;
}

}  // namespace

std::optional<double> period_of_run(const Scene& scene, std::uint64_t steps) {
  if (scene.world.bodies.size() > kMostFollowed || steps < 8) return std::nullopt;
  Simulation sim = Simulation::copy_of(scene.world, settings_of(scene, 1));
  const std::uint64_t every = (steps + kMostSamples - 1) / kMostSamples;
  const double reach = usual_reach(sim.world);
  const std::size_t bodies = sim.world.bodies.size();
  Track track;
  track.interval = scene.step * static_cast<double>(every);
  track.samples.push_back(configuration_of(sim.world, reach));
  for (std::uint64_t i = 1; i <= steps / every * every; ++i) {
    const StepReport report = sim.step();
    if (report.status != Status::ok || sim.world.bodies.size() != bodies || interrupted())
      return std::nullopt;
    if (i % every == 0) track.samples.push_back(configuration_of(sim.world, reach));
  }
  const Configuration& last = track.samples.back();
  double span = 0;
  for (std::size_t i = 0; i < track.samples.size(); ++i)
    span = std::max(span, track.distance(i, last));
  if (!(span > 0) || last.empty()) return std::nullopt;
  bool has_left = false;
  for (std::size_t i = track.samples.size() - 1; i-- > 0;) {
    has_left |= track.distance(i, last) > kLeft * span;
    const auto [time, distance] = track.nearest(i, last);
    const double period = track.end() - time;
    if (2 * period > track.end() * (1 + 1e-9)) return std::nullopt;
    if (has_left && distance < kReturn * span && repeats(track, period, span)) return period;
  }
  return std::nullopt;
}

}  // namespace pantin::program
