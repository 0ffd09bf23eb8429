#pragma once
/// What the programs of tools/peers/motion share: one run of a spelt-out scene in one engine, whose
/// places and CPU time are written frame by frame (see motion.hpp).
///
///   peers_ENGINE SPELT OUT METHOD SETTING
///
/// SETTING is a tolerance for methods that choose their own steps. All others take the steps that
/// the scene has for a frame, and know it as 0.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tools/peers/bodies/motion.hpp"
#include "tools/peers/bodies/spelt.hpp"

namespace pantin::peers {

/// s
inline double frame_of(const Spelt& scene) { return 1.0 / scene.rate; }
/// s
inline double step_of(const Spelt& scene) { return 1.0 / (scene.rate * scene.parts); }

class EngineRun {
 public:
  virtual ~EngineRun() = default;
  /// Goes on by a frame. False: the engine gave up.
  virtual bool advance() = 0;
  /// Positions of the mass centres, in the order of the scene's bodies.
  virtual void read(Frame& to) = 0;
  /// Settings in words.
  virtual std::string settings() const = 0;
};

struct EngineInfo {
  const char *name, *version;
  /// Null: there is no such method, or it has no words for the scene.
  std::unique_ptr<EngineRun> (*start)(const Spelt&, const std::string& method, double setting);
};

/// The place on the path at a time, s, and how often it was differentiated by time.
inline Three place_of(const SpeltSway& s, double time, int derivative = 0) {
  Three place{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double rate = 2 * 3.14159265358979323846 * s.frequency[k];
    const double angle = rate * time + s.phase[k] + derivative * 1.57079632679489661923;
    place[k] = (derivative == 0 ? s.centre[k] : 0) +
               s.amplitude[k] * std::pow(rate, derivative) * std::sin(angle);
  }
  return place;
}

inline bool is_finite(const Frame& frame) {
  for (const Moving& m : frame.bodies)
    for (const double x : m.position)
      if (!std::isfinite(x)) return false;
  return true;
}

/// The whole program.
inline int run_engine(int count, char** words, const EngineInfo& engine) {
  Spelt scene;
  if (count != 5 || !read_spelt(words[1], scene)) {
    std::fprintf(stderr, "usage: peers_%s SPELT OUT METHOD SETTING\n", engine.name);
    return 2;
  }
  const std::unique_ptr<EngineRun> run = engine.start(scene, words[3], std::atof(words[4]));
  if (!run) {
    std::fprintf(stderr, "peers_%s: found method %s, which does not run this scene\n", engine.name,
                 words[3]);
    return 3;
  }
  MotionWriter out(words[2]);
  out.tell("version", engine.version), out.tell("settings", run->settings());
  out.begin(scene.bodies.size());
  Frame frame;
  frame.bodies.resize(scene.bodies.size());
  for (int i = 0; i < scene.frames; ++i) {
    const double before = cpu_ms();
    const bool goes_on = run->advance();
    frame.ms = cpu_ms() - before;
    if (!goes_on) break;
    run->read(frame);
    if (!is_finite(frame)) break;
    out.add(frame);
  }
  return out.good() ? 0 : 4;
}

}  // namespace pantin::peers
