#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/solvers/articulated/kernels.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

#ifdef PANTIN_HAS_RENDER
#include "engine/render/renderer.hpp"
#include "engine/solvers/solver.hpp"
#endif
#ifdef PANTIN_HAS_VIEW
#include <SDL.h>
#endif

namespace pantin::program {

using namespace detail;

namespace {

#ifdef PANTIN_HAS_RENDER
/// Tries each path to OpenGL, and the default choice.
Json look_at_gl() {
  Json j;
  const auto attempt = [](GlPath path) {
    Json found;
    const auto start = std::chrono::steady_clock::now();
    RenderOptions options;
    options.width = options.height = 64;
    options.path = path;
    const auto renderer = Renderer::create(options);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    found["works"] = static_cast<bool>(renderer);
    if (renderer) {
      const GlReport& r = (*renderer)->report();
      found["path"] = r.path, found["renderer"] = r.renderer, found["version"] = r.version;
      found["samples"] = r.samples, found["font"] = r.font;
      found["create_ms"] = took.count();
      found["refused"] = r.refused;
    } else {
      found["refused"] = Json::array();
      for (const Error& e : renderer.errors()) found["refused"].push_back(e.message);
    }
    return found;
  };
  j["chosen"] = attempt(GlPath::automatic);
  j["surfaceless"] = attempt(GlPath::surfaceless);
  j["device"] = attempt(GlPath::device);
  j["osmesa"] = attempt(GlPath::osmesa);
  return j;
}
#endif

/// The output of a fixed command, empty if it cannot be run.
std::string output_of(const char* command) {
  std::string text;
  std::FILE* pipe = popen(command, "re");
  if (!pipe) return text;
  std::array<char, 4096> part;
  for (std::size_t n; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    text.append(part.data(), n);
  return pclose(pipe) == 0 ? text : std::string();
}

Json look_at_ffmpeg() {
  Json j;
  const std::string version = output_of("ffmpeg -hide_banner -version 2>/dev/null");
  j["found"] = !version.empty();
  if (version.empty()) return j;
  j["version"] = version.substr(0, version.find('\n'));
  j["x264"] =
      output_of("ffmpeg -hide_banner -encoders 2>/dev/null").find("libx264 ") != std::string::npos;
  return j;
}

#ifdef PANTIN_HAS_VIEW
Json look_at_sdl() {
  SDL_version version;
  SDL_GetVersion(&version);
  Json j;
  j["version"] = fmt::format("{}.{}.{}", version.major, version.minor, version.patch);
  j["video_drivers"] = Json::array();
  for (int i = 0; i < SDL_GetNumVideoDrivers(); ++i)
    j["video_drivers"].push_back(SDL_GetVideoDriver(i));
  return j;
}
#endif

Json examine() {
  Json j;
  j["version"] = PANTIN_VERSION;
#ifdef PANTIN_COMMIT
  j["commit"] = PANTIN_COMMIT;
#endif
  j["cores"] = sysconf(_SC_NPROCESSORS_ONLN);
  j["threads"] = has_threads();
  j["kernels"] = Json::array();
  for (const articulated::Kernels* const* k = articulated::all_kernels(); *k; ++k)
    j["kernels"].push_back((*k)->name);
  j["kernels_in_use"] = articulated::kernels().name;
  j["libraries"] = {
      {"glm", fmt::format("{}.{}.{}.{}", GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH,
                          GLM_VERSION_REVISION)},
      {"nlohmann_json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                    NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
      {"CLI11", parser_version()},
      {"fmt",
       fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)}};
#ifdef PANTIN_HAS_RENDER
  j["gl"] = look_at_gl();
#else
  j["gl"] = nullptr;
#endif
#ifdef PANTIN_HAS_VIEW
  j["sdl"] = look_at_sdl();
#else
  j["sdl"] = nullptr;
#endif
  j["ffmpeg"] = look_at_ffmpeg();
  return j;
}

void print_gl(const Json& gl) {
  if (gl.is_null()) {
    fmt::print("  pictures    left out of this build\n");
    return;
  }
  const Json& chosen = gl["chosen"];
  if (chosen["works"].get<bool>()) {
    fmt::print("  pictures    by {}: {}, OpenGL {}\n", chosen["path"].get<std::string>(),
               chosen["renderer"].get<std::string>(), chosen["version"].get<std::string>());
    fmt::print("              {} samples per pixel, font {}\n", chosen["samples"].get<int>(),
               chosen["font"].get<std::string>());
  } else {
    fmt::print("  pictures    none: no OpenGL context could be created; scenes run without\n");
  }
  for (const char* path : {"surfaceless", "device", "osmesa"}) {
    const Json& g = gl[path];
    if (g["works"].get<bool>())
      fmt::print("    {:<12}works, {:.0f} ms to open\n", path, g["create_ms"].get<double>());
    else
      for (const Json& line : g["refused"])
        fmt::print("    {:<12}refused: {}\n", path, line.get<std::string>());
  }
}

void print_findings(const Json& j) {
  fmt::print("{}\n", bold("pantin " PANTIN_VERSION));
  std::string kernels;
  for (const Json& k : j["kernels"])
    kernels += (kernels.empty() ? "" : ", ") + k.get<std::string>();
  fmt::print("  kernels     {} in use, of {}\n", j["kernels_in_use"].get<std::string>(), kernels);
  fmt::print("  threads     {}, {} cores\n",
             has_threads() ? "by oneTBB" : "one: built without oneTBB", j["cores"].get<long>());
  print_gl(j["gl"]);
  const Json& ffmpeg = j["ffmpeg"];
  if (!ffmpeg["found"].get<bool>())
    fmt::print("  video       none: ffmpeg was not found; frames can still be written\n");
  else
    fmt::print("  video       {}{}\n", ffmpeg["version"].get<std::string>(),
               ffmpeg["x264"].get<bool>() ? "" : "; without the encoder libx264 it needs");
  if (j["sdl"].is_null()) {
    fmt::print("  window      left out of this build\n");
  } else {
    std::string drivers;
    for (const Json& d : j["sdl"]["video_drivers"]) drivers += " " + d.get<std::string>();
    fmt::print("  window      SDL {}, drivers{}\n", j["sdl"]["version"].get<std::string>(),
               drivers);
  }
  fmt::print("  libraries   glm {}, nlohmann_json {}, CLI11 {}, fmt {}\n",
             j["libraries"]["glm"].get<std::string>(),
             j["libraries"]["nlohmann_json"].get<std::string>(),
             j["libraries"]["CLI11"].get<std::string>(), j["libraries"]["fmt"].get<std::string>());
}

constexpr const char* kExamples =
    R"(Reports which OpenGL context is used and why others are not, the versions and codecs found, and
what this build leaves out.

Examples:
  pantin doctor
  pantin doctor --json

Exit codes: 0 ok, 2 usage.)";

}  // namespace

void add_doctor(CommandLine& program) {
  auto json = std::make_shared<bool>(false);
  const Subcommand command = program.add("doctor", "Reports what works on this machine");
  command.flag("--json", *json, "print one JSON object instead of text");
  command.footer(kExamples);
  command.runs([json] {
    const Json found = examine();
    *json ? print_json(found) : print_findings(found);
    return kOk;
  });
}

}  // namespace pantin::program
