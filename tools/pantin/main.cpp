#include <algorithm>
#include <cstdio>
#include <iostream>
#include <string_view>

#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"
#include "tools/pantin/sweep.hpp"

using namespace pantin::program;

namespace {

/// Flushes the output, and reports if it could not be written: one rule for everything that is
/// printed.
int closed(int exit_code) {
  std::cout.flush();
  const bool written = std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout.good();
  if (written) return exit_code;
  complain("could not write to the standard output");
  return exit_code == kOk ? kUnwritable : exit_code;
}

/// The words after "--" of `pantin sweep`: a command that it passes on. Takes them off.
std::vector<std::string> take_passed_on(int& argc, char** argv) {
  if (argc < 2 || argv[1] != std::string_view("sweep")) return {};
  char** const end = argv + argc;
  char** const dashes = std::find(argv, end, std::string_view("--"));
  argc = static_cast<int>(dashes - argv);
  return dashes == end ? std::vector<std::string>{} : std::vector<std::string>(dashes + 1, end);
}

constexpr const char* kExamples = R"(Examples:
  pantin run assets/scenes/chain.json --frames out/chain --video out/chain.mp4
  pantin run assets/scenes/marionette.json --record out/puppet.csv --json
  pantin check assets/scenes/*.json
  pantin assemble assets/scenes/four_bar.json --scatter 1
  pantin bench assets/scenes/chain.json --json
  pantin chart assets/scenes/chain10.json --out out/chart
  pantin stability assets/scenes/heavy_tip.json --over step=1e-3..0.1
  pantin tune assets/scenes/planar_four_bar.json --error 1e-2 --out out/tuned.json
  pantin sweep assets/scenes/pendulum.json --over /bodies/0/mass=1..10:4
  pantin doctor
  pantin modes assets/laminas/rod.json
  pantin new scene.json
  pantin schema --out scene.schema.json
  pantin surface assets/surfaces/groove.json
  pantin view assets/scenes/marionette.json
  pantin help run
  pantin completion bash > out/pantin.bash

Exit codes: 0 ok, 1 failed run, 2 usage or bad input, 3 diverged or check failed,
4 could not write, 130 interrupted.)";

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> passed_on = take_passed_on(argc, argv);
  CommandLine program({"Real-time simulation of jointed mechanisms: chains, marionettes, ragdolls.",
                       "pantin " PANTIN_VERSION, kExamples});
  add_run(program);
  add_check(program);
  add_assemble(program);
  add_bench(program);
  add_chart(program);
  add_stability(program);
  add_tune(program);
  add_sweep(program, passed_on);
  add_doctor(program);
  add_view(program);
  add_modes(program);
  add_schema(program);
  add_surface(program);
  add_new(program);
  add_completion(program);
  add_help(program);
  catch_interrupts();
  try {
    return closed(program.run(argc, argv));
  } catch (const std::exception& e) {
    if (std::ferror(stdout)) return closed(kOk);
    complain(e.what());
    return kFailed;
  }
}
