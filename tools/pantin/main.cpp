#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include <CLI/CLI.hpp>
#include <clocale>
#include <cstdio>
#include <iostream>

#include "engine/scene/words.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

using namespace pantin::program;

namespace {

/// What is wrong with a command line, in one line. A word that nobody asked for is named, with what
/// it may have been meant for: CLI11 would rather speak of the command that is missing.
std::string complaint_of(const CLI::App& program, const CLI::ParseError& error) {
  const auto chosen = program.get_subcommands();
  const CLI::App& command = chosen.empty() ? program : *chosen.front();
  const std::vector<std::string> parameters = program.remaining(true);
  const bool is_option = !parameters.empty() && parameters.front().starts_with('-');
  const bool is_extra = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  if (parameters.empty() || (!chosen.empty() && !is_extra)) return error.what();
  const std::string& word = parameters.front();
  std::vector<std::string> known;
  if (chosen.empty())
    for (const CLI::App* sub : program.get_subcommands({})) known.push_back(sub->get_name());
  const std::string commands = fmt::format("{}", fmt::join(known, ", "));
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  const std::vector<std::string_view> candidates(known.begin(), known.end());
  return fmt::format("found \"{}\", expected {}{}", word,
                     is_option || !chosen.empty() ? "one of the options" : "one of " + commands,
                     pantin::detail::hint(word, candidates));
}

/// Whether a word stands on the command line that nobody asked for: it is no mere call for help.
bool has_stray_words(const CLI::App& program) { return !program.remaining(true).empty(); }

/// What is left to say at the end: what could not be written. One rule for all that is printed.
int closed(int exit_code) {
  std::cout.flush();
  const bool written = std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout.good();
  if (written) return exit_code;
  complain("could not write to the standard output");
  return exit_code == kOk ? kUnwritable : exit_code;
}

constexpr const char* kExamples = R"(Examples:
  pantin run assets/scenes/chain.json --frames out/chain --video out/chain.mp4
  pantin run assets/scenes/marionette.json --record out/puppet.csv --json
  pantin check assets/scenes/*.json
  pantin bench assets/scenes/chain.json --json
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
  CLI::App program{"Real-time animation of jointed things: chains, string puppets, ragdolls.",
                   "pantin"};
  program.set_version_flag("--version", "pantin " PANTIN_VERSION);
  program.footer(kExamples);
  program.require_subcommand(1);
  program.get_formatter()->column_width(30);
  int exit_code = kOk;
  add_run(program, exit_code);
  add_check(program, exit_code);
  add_bench(program, exit_code);
  add_doctor(program, exit_code);
  add_view(program, exit_code);
  add_modes(program, exit_code);
  add_schema(program, exit_code);
  add_surface(program, exit_code);
  add_new(program, exit_code);
  add_completion(program, exit_code);
  add_help(program, exit_code);
  for (CLI::App* command : program.get_subcommands({}))
    command->parse_complete_callback([command] { check_files(*command); });
  catch_interrupts();
  try {
    if (argc == 1)
      fmt::print("{}", program.help());
    else
      program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // --help, --version
    if (e.get_exit_code() == 0 && !has_stray_words(program)) return closed(program.exit(e));
    // One line, and where to read more.
    const auto chosen = program.get_subcommands();
    const std::string who = chosen.empty() ? "pantin" : "pantin " + chosen.front()->get_name();
    const CLI::ExtrasError strays(who, program.remaining(true));
    const CLI::ParseError& why = e.get_exit_code() == 0 ? strays : e;
    fmt::print(stderr, "{}: {}; see {} --help\n", who, complaint_of(program, why), who);
    return kUsage;
  } catch (const std::exception& e) {
    if (std::ferror(stdout)) return closed(kOk);
    complain(e.what());
    return kFailed;
  }
  return closed(exit_code);
}
