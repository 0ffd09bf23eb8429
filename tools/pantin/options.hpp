#pragma once
/// Options that several subcommands share, and how their values are checked: what does not fit is
/// refused in one line that says what was found and what was expected.
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <string>
#include <vector>

#include "engine/render/renderer.hpp"
#include "engine/scene/scene.hpp"

namespace pantin::program {

struct Range {
  double least, most;
  const char* words;  // "a number of seconds from 1e-6 to 10"
};

inline constexpr Range kStepRange{1e-6, 10, "seconds from 1e-6 to 10"};
inline constexpr Range kSubstepsRange{1, 1000, "a whole number from 1 to 1000"};
inline constexpr Range kDurationRange{1e-6, 1e6, "seconds from 1e-6 to 1e6"};
inline constexpr Range kFpsRange{1e-3, 1000, "frames a second from 0.001 to 1000"};
inline constexpr Range kThreadsRange{1, 256, "a whole number from 1 to 256"};

CLI::Validator number_in(const Range& range);
CLI::Validator whole_number_in(const Range& range);
CLI::Validator one_of(std::vector<std::string> words);
/// WIDTHxHEIGHT, each from 16 to 8192.
CLI::Validator size_of_picture();
/// Whether both sides of a well-formed size are even, as H.264 needs them.
bool is_even_size(const std::string& size);
/// A file name that ends in .mp4 or .mkv.
CLI::Validator video_name();

/// What of a scene the command line may replace; zero and empty leave it as it is.
struct Overrides {
  std::string solver;
  double step = 0;  // s
  int substeps = 0;
  double duration = 0;  // s
};

void add_solver(CLI::App& command, std::string& solver);
void add_step(CLI::App& command, Overrides& wanted);
void add_duration(CLI::App& command, double& duration);
void add_threads(CLI::App& command, int& threads);

/// Solves everything in `world` by one method, whatever its articulations ask for.
void solve_by(World& world, Solver solver);
void apply(const Overrides& wanted, Scene& scene);

/// How pictures are made.
struct PictureOptions {
  std::string frames, video;  // where to; empty: none
  std::string size;           // "": as the scene says
  double fps = 0;             // 0: as the scene says
  std::string gl = "auto";
  bool overlay = false;

  bool wanted() const { return !frames.empty() || !video.empty(); }
};

void add_size(CLI::App& command, PictureOptions& pictures);
void add_fps(CLI::App& command, PictureOptions& pictures);
void add_gl(CLI::App& command, PictureOptions& pictures);

/// How a scene is to be drawn once the scene's own wishes are known.
RenderOptions render_options(const PictureOptions& pictures, const Scene& scene);
double frame_rate(const PictureOptions& pictures, const Scene& scene);

/// Threads that a step can really use.
int usable_threads(int wanted, std::vector<std::string>& warnings);

}  // namespace pantin::program
