#include "tools/pantin/options.hpp"

#include <algorithm>
#include <charconv>
#include <functional>

namespace pantin::program {
namespace {

constexpr int kLeastSide = 16, kMostSide = 8192;  // pixels

std::string refusal(const std::string& found, const std::string& expected) {
  return "found \"" + found + "\", expected " + expected;
}

template <class Number>
bool parse(std::string_view text, Number& number) {
  const auto [end, trouble] = std::from_chars(text.data(), text.data() + text.size(), number);
  return trouble == std::errc() && end == text.data() + text.size();
}

bool parse_size(std::string_view text, int& width, int& height) {
  const std::size_t x = text.find('x');
  return x != std::string_view::npos && parse(text.substr(0, x), width) &&
         parse(text.substr(x + 1), height);
}

CLI::Validator check(std::function<std::string(const std::string&)> why_not) {
  return CLI::Validator([why_not](std::string& text) { return why_not(text); }, "");
}

}  // namespace

CLI::Validator number_in(const Range& range) {
  return check([range](const std::string& text) {
    double x = 0;
    const bool fits = parse(text, x) && x >= range.least && x <= range.most;
    return fits ? std::string() : refusal(text, range.words);
  });
}

CLI::Validator whole_number_in(const Range& range) {
  return check([range](const std::string& text) {
    int n = 0;
    const bool fits = parse(text, n) && n >= range.least && n <= range.most;
    return fits ? std::string() : refusal(text, range.words);
  });
}

CLI::Validator one_of(std::vector<std::string> words) {
  return check([words](const std::string& text) {
    std::string all;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (text == words[i]) return std::string();
      all += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
    }
    return refusal(text, all);
  });
}

CLI::Validator size_of_picture() {
  return check([](const std::string& text) {
    int w = 0, h = 0;
    const bool fits =
        parse_size(text, w, h) && std::min(w, h) >= kLeastSide && std::max(w, h) <= kMostSide;
    return fits ? std::string()
                : refusal(text, "WIDTHxHEIGHT in pixels, as in 1280x720, each from 16 to 8192");
  });
}

bool is_even_size(const std::string& size) {
  int w = 0, h = 0;
  return parse_size(size, w, h) && w % 2 == 0 && h % 2 == 0;
}

CLI::Validator video_name() {
  return check([](const std::string& text) {
    const bool fits = text.size() > 4 && (text.ends_with(".mp4") || text.ends_with(".mkv"));
    return fits ? std::string() : refusal(text, "a name that ends in .mp4 or .mkv");
  });
}

void add_solver(CLI::App& command, std::string& solver) {
  command.add_option("--solver", solver, "Solve everything by auto, sweep, shake2 or paper")
      ->type_name("NAME")
      ->check(one_of({"auto", "sweep", "shake2", "paper"}));
}

void add_step(CLI::App& command, Overrides& wanted) {
  command.add_option("--step", wanted.step, "Step length, s")
      ->type_name("S")
      ->check(number_in(kStepRange));
  command.add_option("--substeps", wanted.substeps, "Equal parts each step is taken in")
      ->type_name("N")
      ->check(whole_number_in(kSubstepsRange));
}

void add_duration(CLI::App& command, double& duration) {
  command.add_option("--duration", duration, "How long to run, s")
      ->type_name("S")
      ->check(number_in(kDurationRange));
}

void add_threads(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "Threads that share a step; the result is the same")
      ->type_name("N")
      ->check(whole_number_in(kThreadsRange));
}

void solve_by(World& world, Solver solver) {
  world.default_settings.solver = solver;
  for (SolverSettings& settings : world.settings.values()) settings.solver = solver;
  world.touch();
}

void apply(const Overrides& wanted, Scene& scene) {
  if (wanted.step > 0) scene.step = wanted.step;
  if (wanted.substeps > 0) scene.substeps = wanted.substeps;
  if (wanted.duration > 0) scene.duration = wanted.duration;
  Solver solver{};
  if (solver_from_name(wanted.solver.c_str(), solver)) solve_by(scene.world, solver);
}

void add_size(CLI::App& command, PictureOptions& pictures) {
  command.add_option("--size", pictures.size, "Size of the pictures, pixels")
      ->type_name("WxH")
      ->check(size_of_picture());
}

void add_fps(CLI::App& command, PictureOptions& pictures) {
  command.add_option("--fps", pictures.fps, "Frames a second of scene time")
      ->type_name("N")
      ->check(number_in(kFpsRange));
}

void add_gl(CLI::App& command, PictureOptions& pictures) {
  command
      .add_option("--gl", pictures.gl,
                  "Way to OpenGL: auto (the first that works), surfaceless, device or osmesa")
      ->type_name("WAY")
      ->check(one_of({"auto", "surfaceless", "device", "osmesa"}));
}

RenderOptions render_options(const PictureOptions& pictures, const Scene& scene) {
  RenderOptions options;
  options.width = scene.output.width, options.height = scene.output.height;
  parse_size(pictures.size, options.width, options.height);
  options.path = pictures.gl == "surfaceless" ? GlPath::surfaceless
                 : pictures.gl == "device"    ? GlPath::device
                 : pictures.gl == "osmesa"    ? GlPath::osmesa
                                              : GlPath::automatic;
  return options;
}

double frame_rate(const PictureOptions& pictures, const Scene& scene) {
  return pictures.fps > 0 ? pictures.fps : scene.output.fps;
}

int usable_threads(int wanted, std::vector<std::string>& warnings) {
#ifndef PANTIN_HAS_TBB
  if (wanted > 1) {
    warnings.push_back("--threads " + std::to_string(wanted) +
                       ": built without oneTBB, runs on one thread");
    return 1;
  }
#endif
  static_cast<void>(warnings);
  return wanted;
}

}  // namespace pantin::program
