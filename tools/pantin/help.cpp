// `pantin help`: the help of a command, or the manual page, both generated from the command line.
#include <fmt/format.h>

#include <memory>
#include <sstream>

#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

namespace {

struct Variable {
  const char *name, *about;
};
/// Environment variables of the program; the README lists the same.
constexpr Variable kEnvironment[] = {
    {"PANTIN_GL", "OpenGL context if --gl does not give it: surfaceless, device or osmesa"},
    {"PANTIN_KERNELS",
     "instruction set of the inner loops: baseline, avx2 or avx512; by default the best of the "
     "processor. The results are the same"},
    {"NO_COLOR", "set: no bold text"},
    {"DISPLAY, WAYLAND_DISPLAY", "the display for the window of pantin view"},
    {"SDL_VIDEODRIVER", "SDL's video driver; \"dummy\" for an invisible window"},
    {"PATH",
     "searched for ffmpeg, for --video and --gif, and for python3, which draws charts and maps"},
};

/// Escapes a line of text for roff.
std::string escaped(const std::string& line) {
  std::string text;
  if (line.starts_with('.') || line.starts_with('\'')) text = "\\&";
  for (const char c : line) {
    if (c == '\\')
      text += "\\e";
    else if (c == '-')
      text += "\\-";
    else if (c == '"')
      text += "\\(dq";
    else
      text += c;
  }
  return text;
}

/// The type of a value, which may be broken after each choice.
std::string breakable(const std::string& type) {
  std::string text;
  for (const char c : escaped(type)) text += c == ',' ? std::string(", ") : std::string(1, c);
  return text;
}

/// Prose is filled; indented lines are verbatim.
void add_footer(std::string& page, const std::string& footer) {
  enum class Part { prose, example } part = Part::prose;
  const auto turn_to = [&](Part next) {
    if (next != part) page += next == Part::example ? ".EX\n" : ".EE\n";
    part = next;
  };
  std::istringstream lines(footer);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) {
      turn_to(Part::prose);
      page += ".PP\n";
      continue;
    }
    turn_to(line.starts_with(' ') ? Part::example : Part::prose);
    const bool is_heading =
        part == Part::prose && line.ends_with(':') && line.find(' ') == line.npos;
    page += (is_heading ? ".B " : "") + escaped(line) + "\n";
    if (is_heading) page += ".br\n";
  }
  turn_to(Part::prose);
}

void add_arguments(std::string& page, const std::vector<Argument>& arguments) {
  for (const Argument& a : arguments) {
    page += ".TP\n";
    for (std::size_t i = 0; i < a.names.size(); ++i)
      page += fmt::format("{}\\fB{}\\fR", i > 0 ? ", " : "", escaped(a.names[i]));
    if (!a.type.empty()) page += fmt::format(" \\fI{}\\fR", breakable(a.type));
    page += fmt::format("\n{}\n", escaped(a.about));
  }
}

std::string manual(const CommandLine& program) {
  const std::vector<Command> commands = program.described();
  const Command& whole = commands.front();
  std::string page = fmt::format(
      ".TH PANTIN 1 \"\" \"{}\" \"User Commands\"\n.SH NAME\npantin \\- {}\n.SH SYNOPSIS\n"
      ".B pantin\n.I COMMAND\n[\\fIOPTIONS\\fR] ...\n.SH OPTIONS\n",
      program.version(), escaped(whole.about));
  add_arguments(page, whole.options);
  page += ".SH COMMANDS\n";
  for (std::size_t i = 1; i < commands.size(); ++i) {
    const Command& c = commands[i];
    page += fmt::format(".SS pantin {}{}\n{}.\n", c.name, escaped(c.usage), escaped(c.about));
    add_arguments(page, c.positionals);
    add_arguments(page, c.options);
    page += ".PP\n";
    add_footer(page, c.footer);
  }
  page += ".SH ENVIRONMENT\n";
  for (const Variable& v : kEnvironment)
    page += fmt::format(".TP\n.B {}\n{}\n", v.name, escaped(v.about));
  page += ".SH EXAMPLES AND EXIT STATUS\n";
  add_footer(page, whole.footer);
  return page;
}

constexpr const char* kExamples = R"(Examples:
  pantin help run
  pantin help --man > out/pantin.1

Exit codes: 0 ok, 2 usage.)";

}  // namespace

void add_help(CommandLine& program) {
  struct Choices {
    std::string command;
    bool man = false;
  };
  auto choices = std::make_shared<Choices>();
  std::vector<std::string> names = program.names();
  names.insert(names.begin(), "help");
  const Subcommand command = program.add("help", "Prints this help, or that of a command");
  command.option("command", choices->command, "the command").one_of(names);
  command.flag("--man", choices->man, "print the manual page, in roff");
  command.footer(kExamples);
  command.runs([choices, &program] {
    fmt::print("{}", choices->man               ? manual(program)
                     : choices->command.empty() ? program.help()
                                                : program.help(choices->command));
    return kOk;
  });
}

}  // namespace pantin::program
