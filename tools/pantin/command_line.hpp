#pragma once
// The command line as data, read from what parses it: for the manual and for shells.
#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>
#include <vector>

namespace pantin::program {

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

/// The program first, then its subcommands, in the order of --help.
std::vector<Command> commands_of(const CLI::App& program);

/// Types of values for --help: completion offers what they say.
inline constexpr const char *kSceneType = "FILE:.json|.json5|.jsonc", *kFolderType = "FOLDER",
                            *kFileType = "FILE";
/// A file whose name ends in one of these. Together with kFileType.
CLI::Validator named(std::initializer_list<const char*> endings);

/// Throws a CLI::ValidationError where a command was given one name for two files, one of which
/// would take the other's place: for two outputs, or for an output and the scene.
void check_files(const CLI::App& command);

}  // namespace pantin::program
