#pragma once
// The command line: what commands take, and the same as data, for the manual and for shells. What
// parses it is known to command_line.cpp alone: its header takes seconds to compile.
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace pantin::program {

/// Types of values for --help: completion offers what they say.
inline constexpr const char *kSceneType = "FILE:.json|.json5|.jsonc", *kFolderType = "FOLDER",
                            *kFileType = "FILE";

/// An option, a flag or a positional of a subcommand, to say more of it. A handle: copies mean the
/// same one.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  const Option& required() const;
  /// What --help calls its values.
  const Option& type(const char* name) const;
  const Option& one_of(const std::vector<std::string>& words) const;
  /// A whole number.
  const Option& within(int least, int most) const;
  /// A finite number.
  const Option& between(double least, double most) const;
  /// A file whose name ends in one of these. Together with kFileType.
  const Option& ends_in(std::initializer_list<const char*> endings) const;
  /// What stands in one word for another, before it is checked.
  const Option& read_as(const std::function<std::string(std::string)>& word) const;
  /// Several values in one word.
  const Option& separated_by(char delimiter) const;
  const Option& count(int values) const;
  const Option& shows_default() const;
  /// Either this or the other.
  const Option& excludes(const Option& other) const;

 private:
  CLI::Option* option_;
};

/// A subcommand, to say what it takes. A handle, too.
class Subcommand {
 public:
  Subcommand(CLI::App& parser, int& exit_code) : parser_(&parser), exit_code_(&exit_code) {}

  /// A positional if its name begins with no dash. The value is text, an int or a double, an
  /// optional or a vector of such, as command_line.cpp lists them; it has to live until the command
  /// has run.
  template <typename T>
  Option option(const char* name, T& value, const std::string& about) const;
  Option flag(const char* name, bool& value, const std::string& about) const;
  /// One that was added already.
  Option added(const char* name) const;
  void footer(const char* text) const;
  /// What the command does, in the end; its result is the exit code of the program.
  void runs(std::function<int()> action) const;

 private:
  CLI::App* parser_;
  int* exit_code_;
};

/// What stands behind an option, or in a positional place.
enum class ValueKind { none, text, choice, file, folder };

/// An option or a positional.
struct Argument {
  std::vector<std::string> names;  // "-h" and "--help"; of a positional its one name
  std::string about, type;         // type: as --help shows it
  ValueKind kind = ValueKind::none;
  std::vector<std::string> values;  // choices; endings of files, none: any file
  bool repeats = false, is_required = false;
};

/// The program, or a subcommand of it.
struct Command {
  std::string name, about, usage, footer;
  std::vector<Argument> options, positionals;
};

/// The program `pantin` with its subcommands.
class CommandLine {
 public:
  struct Texts {
    const char *about, *version, *footer;
  };
  explicit CommandLine(const Texts& texts);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  Subcommand add(const char* name, const char* about);
  /// Of the subcommands so far, in the order of --help.
  std::vector<std::string> names() const;
  /// The program first, then its subcommands.
  std::vector<Command> described() const;
  std::string version() const;
  /// What --help prints, of the program or of a subcommand.
  std::string help() const;
  std::string help(const std::string& command) const;

  /// Runs the command that is asked for; the exit code. Tells what is wrong with the command line,
  /// in one line on stderr.
  int run(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> parser_;
  int exit_code_ = 0;
};

/// Of the library that parses.
const char* parser_version();

}  // namespace pantin::program
