// The program `peers_bodies`: spells scenes out for other engines, runs them in pantin, and
// measures what came of it. tools/peers/contact is its front.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/solvers/solver.hpp"
#include "tools/peers/bodies/judge.hpp"

namespace {

using namespace pantin;
using namespace pantin::peers;

constexpr const char* kUsage = R"(usage: peers_bodies spell SCENE FRAMES OUT
       peers_bodies run SCENE FRAMES SUBSTEPS OUT
       peers_bodies judge SCENE MOTION

FRAMES: at 60 Hz; 0: as many as the scene's own duration holds. SUBSTEPS: of a step; 0: the scene's.
)";

int complain(const std::string& what) {
  std::fprintf(stderr, "peers_bodies: %s\n", what.c_str());
  return 2;
}

int frames_of(const Scene& scene, const char* word) {
  const int frames = std::atoi(word);
  return frames > 0 ? frames : static_cast<int>(std::lround(scene.duration * kFramesPerSecond));
}

int spell(const Scene& scene, const char* frames, const std::string& path) {
  std::ofstream out(path);
  write_plain(scene.world, frames_of(scene, frames), out);
  return out.good() ? 0 : complain("cannot write '" + path + "'");
}

Moving moving(const Body& b) {
  const Vec3 &x = b.pose.position, &v = b.velocity, &w = b.angular_velocity;
  const Quat& q = b.pose.rotation;
  return {{x.x, x.y, x.z}, {q.x, q.y, q.z, q.w}, {v.x, v.y, v.z}, {w.x, w.y, w.z}};
}

int run(const Scene& scene, const char* frames, const char* substeps, const std::string& path) {
  MotionWriter out(path);
  const int steps = std::max(1, static_cast<int>(std::lround(1.0 / kFramesPerSecond / scene.step)));
  StepSettings settings;
  settings.h = 1.0 / kFramesPerSecond / steps;
  settings.substeps = std::atoi(substeps) > 0 ? std::atoi(substeps) : scene.substeps;
  Simulation sim = Simulation::copy_of(scene.world, settings);
  for (const detail::SolverRow* solver : detail::kSolvers) solver->prepare(sim.world);
  const auto islands = static_cast<int>(detail::partition_of(sim.world).islands.size());

  char told[120];
  std::snprintf(told, sizeof told, "auto, %d step%s a frame of %d substep%s, 1 thread", steps,
                steps == 1 ? "" : "s", settings.substeps, settings.substeps == 1 ? "" : "s");
  out.tell("engine", "pantin"), out.tell("version", PANTIN_PEERS_COMMIT);
  out.tell("settings", told), out.tell("built", PANTIN_PEERS_FLAGS);
  out.begin(sim.world.bodies.size());
  Frame frame;
  frame.bodies.resize(sim.world.bodies.size());
  for (int i = frames_of(scene, frames); i > 0; --i) {
    StepReport report;
    const double before = cpu_ms();
    for (int step = 0; step < steps; ++step) report = sim.step();
    frame.ms = cpu_ms() - before;
    frame.awake = islands - report.asleep;
    for (std::size_t b = 0; b < frame.bodies.size(); ++b)
      frame.bodies[b] = moving(sim.world.bodies.values()[b]);
    out.add(frame);
  }
  return out.good() ? 0 : complain("cannot write '" + path + "'");
}

void print(const char* key, double value) {
  if (std::isfinite(value))
    std::printf("\"%s\": %.9g, ", key, value);
  else
    std::printf("\"%s\": null, ", key);
}

/// Quotes and backslashes cannot be in what engines tell of themselves.
void print(const std::string& key, const std::string& value) {
  std::printf("\"%s\": \"%s\", ", key.c_str(), value.c_str());
}

int judge_file(const Scene& scene, const std::string& path) {
  Verdict v;
  if (!judge(scene.world, path, v)) return complain("'" + path + "' is no motion of this scene");
  std::printf("{");
  std::string without;
  for (const auto& [key, value] : v.told)
    if (key == "without")
      without += (without.empty() ? "" : ", ") + value;
    else
      print(key, value);
  print("without", without);
  print("median_ms", v.median_ms), print("p99_ms", v.p99_ms), print("most_ms", v.most_ms);
  print("mean_ms", v.mean_ms), print("opening_m", v.opening);
  print("opening_at_rest_m", v.opening_at_rest), print("stretch_m", v.stretch);
  print("turn_rad", v.turn), print("turn_at_rest_rad", v.turn_at_rest);
  print("depth_m", v.depth), print("depth_at_rest_m", v.depth_at_rest);
  print("depth_at_start_m", v.depth_at_start);
  print("energy_change_J", v.energy), print("energy_gained_J", v.gained);
  print("kinetic_J", v.kinetic), print("moved_in_last_second_m", v.moved);
  print("asleep_after_s", v.asleep_after < 0 ? NAN : v.asleep_after);
  std::printf("\"lost\": %d, \"bodies\": %d, \"frames\": %d}\n", v.lost, v.bodies, v.frames);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  const std::vector<std::string> given(words + 1, words + count);
  if (count == 2 && given[0] == "--help") return std::fputs(kUsage, stdout), 0;
  const std::string what = given.empty() ? "" : given[0];
  const std::size_t wanted = what == "spell" ? 4 : what == "run" ? 5 : what == "judge" ? 3 : 0;
  if (given.size() != wanted) return std::fputs(kUsage, stderr), 2;
  Result<Scene> scene = load_scene(given[1]);
  if (!scene) {
    for (const Error& e : scene.errors()) std::fprintf(stderr, "%s\n", e.message.c_str());
    return 2;
  }
  detail::compile_if_changed(scene->world);
  if (what == "spell") return spell(*scene, words[3], words[4]);
  if (what == "run") return run(*scene, words[3], words[4], words[5]);
  return judge_file(*scene, words[3]);
}
