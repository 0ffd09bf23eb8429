#pragma once
// The command line: arguments of commands, also as data for the manual and for shell completion.
// Only command_line.cpp includes the parser, whose header takes seconds to compile.
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

/// Types of values in --help; completion uses them.
inline constexpr const char *kSceneType = "FILE:.json|.json5|.jsonc", *kFolderType = "FOLDER",
                            *kFileType = "FILE";

/// An option, a flag or a positional of a subcommand, for configuration. A handle: copies refer to
/// the same object.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  const Option& required() const;
  /// The type of its values in --help.
  const Option& type(const char* name) const;
  const Option& one_of(const std::vector<std::string>& words) const;
  /// A whole number within bounds.
  const Option& within(int least, int most) const;
  /// A finite number within bounds.
  const Option& between(double least, double most) const;
  /// A file whose name ends in one of these. Use it with kFileType.
  const Option& ends_in(std::initializer_list<const char*> endings) const;
  /// Translates each value before it is checked.
  const Option& read_as(const std::function<std::string(std::string)>& word) const;
  /// Several values in one word.
  const Option& separated_by(char delimiter) const;
  const Option& count(int values) const;
  const Option& shows_default() const;
  /// One value each time it is given, of several.
  const Option& one_at_a_time() const;
  /// The two options exclude each other.
  const Option& excludes(const Option& other) const;

 private:
  CLI::Option* option_;
};

/// A subcommand, for configuration. Also a handle.
class Subcommand {
 public:
  Subcommand(CLI::App& parser, int& exit_code) : parser_(&parser), exit_code_(&exit_code) {}

  /// A positional if its name does not begin with a dash. The value is text, an int, a double, or
  /// an optional or vector of these, as listed in command_line.cpp. It must outlive the command.
  template <typename T>
  Option option(const char* name, T& value, const std::string& about) const;
  Option flag(const char* name, bool& value, const std::string& about) const;
  /// An argument that was added before.
  Option added(const char* name) const;
  void footer(const char* text) const;
  /// Sets the action of the command; its result is the exit code of the program.
  void runs(std::function<int()> action) const;

 private:
  CLI::App* parser_;
  int* exit_code_;
};

/// The kind of value of an option or positional.
enum class ValueKind { none, text, choice, file, folder };

/// An option or a positional.
struct Argument {
  std::vector<std::string> names;  // "-h" and "--help"; the single name of a positional
  std::string about, type;         // type as shown by --help
  ValueKind kind = ValueKind::none;
  std::vector<std::string> values;  // choices; or endings of files, empty: any file
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
  /// The names of the subcommands so far, in the order of --help.
  std::vector<std::string> names() const;
  /// The program, followed by its subcommands.
  std::vector<Command> described() const;
  std::string version() const;
  /// The output of --help, for the program or a subcommand.
  std::string help() const;
  std::string help(const std::string& command) const;

  /// Runs the requested command; returns the exit code. Reports a faulty command line in one line
  /// on stderr.
  int run(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> parser_;
  int exit_code_ = 0;
};

/// The version of the parser library.
const char* parser_version();

}  // namespace pantin::program
