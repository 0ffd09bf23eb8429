// pantin run: a scene from its first step to its last.
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "engine/runtime/simulation.hpp"
#include "tools/pantin/allocations.hpp"
#include "tools/pantin/frame_clock.hpp"
#include "tools/pantin/interrupt.hpp"
#include "tools/pantin/options.hpp"
#include "tools/pantin/pictures.hpp"
#include "tools/pantin/record.hpp"
#include "tools/pantin/summary.hpp"
#include "tools/pantin/terminal.hpp"

namespace pantin::program {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kMostSteps = 10'000'000;
constexpr std::size_t kWarmUp = 10;  // steps that may still allocate

struct RunOptions {
  std::string scene;
  Overrides overrides;
  PictureOptions pictures;
  std::string record;
  int threads = 1;
  bool hash = false, json = false;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// CPU time of this process and of the children it has waited for, s.
double cpu_seconds() {
  double sum = 0;
  for (int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    struct rusage use {};
    ::getrusage(who, &use);
    for (const timeval& t : {use.ru_utime, use.ru_stime})
      sum += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  return sum;
}

/// A scene on its way: steps, frames, rows, and what was measured meanwhile.
class Run {
 public:
  Run(const RunOptions& options, Scene scene)
      : options_(options),
        scene_(std::move(scene)),
        steps_(steps_for(scene_.duration, scene_.step)),
        clock_{frame_rate(options.pictures, scene_), scene_.step},
        frames_(frames_for(scene_.duration, clock_.fps)) {}

  Summary take() {
    describe();
    if (steps_ > kMostSteps) {
      summary_.fail(Exit::usage, "bad_input",
                    fmt::format("{}: found {} steps, expected at most {}: shorten --duration or "
                                "lengthen --step",
                                options_.scene, steps_, kMostSteps));
      return summary_;
    }
    if (open()) loop();
    close();
    return summary_;
  }

 private:
  void describe() {
    simulation_.world = scene_.world;
    summary_.threads = usable_threads(options_.threads, scene_.warnings);
    simulation_.settings = {scene_.step, scene_.substeps, summary_.threads, false};
    for (std::string& line : structure_faults(simulation_.world))
      scene_.warnings.push_back(options_.scene + ": " + line);
    summary_.scene = options_.scene, summary_.title = scene_.title;
    summary_.solver = solvers_of(simulation_.world);
    summary_.step = scene_.step, summary_.substeps = scene_.substeps;
    summary_.counts = counts_of(simulation_.world);
    summary_.warnings = scene_.warnings;
    summary_.ruler.start(simulation_.world);
    caption_ = {scene_.title, summary_.solver, scene_.step, scene_.substeps};
    if (!options_.json) warn(scene_.warnings);
  }

  /// Everything that can be refused is refused before the first step.
  bool open() {
    if (options_.pictures.wanted()) {
      Exit why{};
      auto opened = Pictures::open(options_.pictures, scene_, static_cast<std::size_t>(frames_),
                                   why);
      if (!opened) {
        for (const Error& e : opened.errors()) summary_.fail(why, status_of(why), e.message);
        return false;
      }
      pictures_ = std::move(*opened);
    }
    if (!options_.record.empty()) {
      auto opened = Record::open(options_.record, simulation_.world);
      if (!opened) return fail(Exit::not_written, opened.errors());
      record_ = std::move(*opened);
    }
    return true;
  }

  void loop() {
    const auto count = static_cast<std::size_t>(steps_);
    step_ns_.reserve(count);
    poses_.resize(pictures_ ? simulation_.world.bodies.size() : 0);
    frame_start_ = Clock::now();
    if (!note_row()) return;
    while (true) {
      if (pictures_ && !draw_due()) return;
      if (taken_ == steps_) return;
      if (is_interrupted()) {
        summary_.fail(Exit::interrupted, "interrupted",
                      fmt::format("{}: interrupted at {:.6g} s; what was written so far is whole",
                                  options_.scene, simulation_.world.time));
        return;
      }
      if (!step() || !note_row()) return;
      show_progress();
    }
  }

  /// One step, timed; the rulers are taken outside of the timed part. False if it diverged.
  bool step() {
    const std::uint64_t allocated = allocations_here();
    const Clock::time_point start = Clock::now();
    // advance() keeps the poses before the step, which frames between steps need.
    const StepReport report = pictures_ ? simulation_.advance(scene_.step).report
                                        : simulation_.step();
    const double taken = seconds_since(start);
    if (step_ns_.size() >= kWarmUp) allocations_ += allocations_here() - allocated;
    ++taken_;
    step_ns_.push_back(1e9 * taken);
    if (!pictures_) {
      frame_part_ += taken;
      if (taken_ * clock_.fps * clock_.h >= static_cast<double>(frame_ms_.size() + 1) - 1e-6)
        frame_ms_.push_back(1e3 * std::exchange(frame_part_, 0));
    }
    summary_.ruler.take(simulation_.world, report);
    if (report.status != Status::diverged) return true;
    summary_.diverged = {simulation_.world.name_of(report.body), report.time,
                         summary_.ruler.last.worst_gap};
    summary_.fail(Exit::diverged, "diverged",
                  fmt::format("{}: diverged: body \"{}\" at {:.6g} s, widest joint gap {:.3g} m",
                              options_.scene, summary_.diverged->body, report.time,
                              summary_.diverged->residual));
    return false;
  }

  /// The frames whose states are there. False if they cannot be written.
  bool draw_due() {
    for (; frame_ < frames_; ++frame_) {
      const FramePlace place = clock_.at(frame_);
      if (place.step > taken_) return true;
      const World& world = simulation_.world;
      for (std::size_t i = 0; i < poses_.size(); ++i)
        poses_[i] = place.fraction < 1
                        ? simulation_.interpolated(world.bodies.owners()[i], place.fraction)
                        : world.bodies.values()[i].pose;
      auto done = pictures_->add(world, poses_, overlay(frame_));
      if (!done) return fail(Exit::not_written, done.errors());
      // The first frame pays for shaders; it counts for neither clock.
      if (frame_ > 0) frame_ms_.push_back(1e3 * seconds_since(frame_start_));
      if (frame_ == 0) cpu_start_ = cpu_seconds();
      frame_start_ = Clock::now();
    }
    return true;
  }

  Overlay overlay(std::int64_t frame) const {
    const World& world = simulation_.world;
    Overlay overlay;
    overlay.lines =
        caption_lines(caption_, static_cast<double>(frame) / clock_.fps, world.tick,
                      summary_.ruler.last, unreached(world));
    overlay.joints = options_.pictures.overlay;
    if (overlay.joints) overlay.legend = legend_of(world);
    return overlay;
  }

  bool note_row() {
    if (!record_) return true;
    auto done = record_->add(simulation_.world, summary_.ruler.last);
    return done ? true : fail(Exit::not_written, done.errors());
  }

  void show_progress() {
    if (!progress_.is_due()) return;
    std::string line = fmt::format("{:3.0f} %  t = {:.2f} s of {:.6g} s",
                                   100.0 * static_cast<double>(taken_) / static_cast<double>(steps_),
                                   simulation_.world.time, scene_.duration);
    if (pictures_) line += fmt::format("  frame {} of {}", frame_, frames_);
    progress_.show(line);
  }

  /// Brings files to their names and sums up.
  void close() {
    progress_.clear();
    if (pictures_) {
      auto finished = pictures_->finish();
      if (finished) {
        summary_.frames_written = *finished;
        summary_.frames = options_.pictures.frames, summary_.video = options_.pictures.video;
      } else if (summary_.exit != Exit::not_written) {
        fail(Exit::not_written, finished.errors());
      }
      if (frame_ > 1)
        summary_.frame_cpu_ms = 1e3 * (cpu_seconds() - cpu_start_) /
                                static_cast<double>(frame_ - 1);
      if (!summary_.frames.empty()) {
        const auto stale = stale_frames(summary_.frames, summary_.frames_written);
        summary_.warnings.insert(summary_.warnings.end(), stale.begin(), stale.end());
        if (!options_.json) warn(stale);
      }
    }
    if (record_) {
      auto finished = record_->finish();
      if (finished)
        summary_.record = options_.record;
      else if (summary_.exit != Exit::not_written)
        fail(Exit::not_written, finished.errors());
    }
    sum_up();
  }

  void sum_up() {
    summary_.steps = static_cast<std::size_t>(taken_), summary_.time = simulation_.world.time;
    summary_.unreached = unreached(simulation_.world);
    if (step_ns_.size() > kWarmUp)
      summary_.allocations_per_step =
          static_cast<double>(allocations_) / static_cast<double>(step_ns_.size() - kWarmUp);
    const auto links = static_cast<double>(std::max<std::size_t>(1, summary_.counts.dynamic));
    for (double& ns : step_ns_) ns /= links;
    summary_.ns_per_link_step = ranks_of(std::move(step_ns_));
    summary_.frame_ms = ranks_of(std::move(frame_ms_));
    summary_.hash = state_hash(simulation_.world);
  }

  bool fail(Exit with, const std::vector<Error>& errors) {
    for (const Error& e : errors) summary_.fail(with, status_of(with), e.message);
    return false;
  }

  const RunOptions& options_;
  Scene scene_;
  Simulation simulation_;
  const std::int64_t steps_;
  const FrameClock clock_;
  const std::int64_t frames_;
  std::unique_ptr<Pictures> pictures_;
  std::unique_ptr<Record> record_;
  Caption caption_;
  Summary summary_;
  Progress progress_;

  std::int64_t taken_ = 0, frame_ = 0;  // steps and frames so far
  std::vector<Pose> poses_;             // of the frame being drawn, by slot
  std::vector<double> step_ns_, frame_ms_;
  std::uint64_t allocations_ = 0;
  double frame_part_ = 0, cpu_start_ = 0;  // s
  Clock::time_point frame_start_;
};

Exit run_scene(const RunOptions& options) {
  watch_for_interrupts();
  auto scene = load_scene(options.scene);
  if (!scene) {
    complain(scene.errors());
    return Exit::usage;
  }
  apply(options.overrides, *scene);
  const Summary summary = Run(options, std::move(*scene)).take();
  for (const std::string& line : summary.messages) complain(line);
  if (summary.exit == Exit::usage) return summary.exit;
  const bool told = print(options.json ? dump(to_json(summary)) : to_text(summary, options.hash));
  return told || summary.exit != Exit::ok ? summary.exit : Exit::not_written;
}

}  // namespace

void add_run(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<RunOptions>();
  CLI::App& command = *app.add_subcommand("run", "Run a scene; make frames, a video, a record");
  command.add_option("SCENE", options->scene, "Scene file")->required();
  add_solver(command, options->overrides.solver);
  add_step(command, options->overrides);
  add_duration(command, options->overrides.duration);
  add_threads(command, options->threads);
  command.add_option("--frames", options->pictures.frames, "Write DIR/frame_000000.png and so on")
      ->type_name("DIR");
  command.add_option("--video", options->pictures.video, "Write a video, .mp4 or .mkv")
      ->type_name("FILE")
      ->check(video_name());
  add_size(command, options->pictures);
  add_fps(command, options->pictures);
  command.add_flag("--overlay", options->pictures.overlay, "Mark joints, pins and slack strings");
  add_gl(command, options->pictures);
  command.add_option("--record", options->record, "Write a CSV file with the state at every step")
      ->type_name("FILE");
  command.add_flag("--hash", options->hash, "Print the fingerprint of the last state");
  command.add_flag("--json", options->json, "Print one JSON object instead of text");
  command.footer(
      "Examples:\n"
      "  pantin run assets/scenes/chain.json --video chain.mp4\n"
      "  pantin run assets/scenes/marionette.json --frames out --size 640x360 --duration 2\n"
      "  pantin run assets/scenes/chain.json --solver sweep --step 0.008 --record chain.csv\n"
      "  pantin run assets/scenes/chain.json --json | jq .worst_gap_m\n\n"
      "Frame k shows the time k / fps; between two steps it is drawn from both. An interrupt\n"
      "(Ctrl-C) ends the run after the step it is in; frames, video and record stay whole.\n\n" +
      std::string(kRecordColumns) + "\n\n" + kSummaryKeys + "\n\n" + kExitCodes);
  command.callback([options, &chosen] {
    if (!options->pictures.video.empty() && !options->pictures.size.empty() &&
        !is_even_size(options->pictures.size))
      throw CLI::ValidationError("--size", "found \"" + options->pictures.size +
                                               "\", expected even numbers for a video");
    chosen = [options] { return run_scene(*options); };
  });
}

}  // namespace pantin::program
