#include "tools/pantin/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace pantin::program {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> parts_of(std::string_view text, char between) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(between, at), text.size());
    parts.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

/// Reads "TEXT:{a,b}", "FILE", "FILE:.a|.b" and "FOLDER".
void read_type(Argument& argument) {
  const std::string_view type = argument.type;
  const std::size_t open = type.find('{'), close = type.find('}');
  argument.kind = ValueKind::text;
  if (open != type.npos && close != type.npos) {
    argument.kind = ValueKind::choice;
    argument.values = parts_of(type.substr(open + 1, close - open - 1), ',');
  } else if (type.starts_with(kFileType)) {
    argument.kind = ValueKind::file;
    if (const std::size_t colon = type.find(':'); colon != type.npos)
      argument.values = parts_of(type.substr(colon + 1), '|');
  } else if (type == kFolderType) {
    argument.kind = ValueKind::folder;
  }
}

Argument argument_of(const CLI::Option& option) {
  Argument argument;
  for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  if (option.get_positional()) argument.names = {option.get_name(true)};
  argument.about = option.get_description();
  argument.is_required = option.get_required();
  argument.repeats = option.get_expected_max() > 1;
  if (option.get_items_expected() == 0) return argument;  // a flag
  argument.type = option.get_type_name();
  read_type(argument);
  return argument;
}

Command command_of(const CLI::App& app) {
  Command command{app.get_name(), app.get_description(), "", app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    auto& list = option->get_positional() ? command.positionals : command.options;
    list.push_back(argument_of(*option));
  }
  if (!command.options.empty()) command.usage += " [OPTIONS]";
  for (const Argument& p : command.positionals) {
    const std::string name = p.names.front() + (p.repeats ? "..." : "");
    command.usage += p.is_required ? " " + name : " [" + name + "]";
  }
  return command;
}

/// A file that a command was given by name.
struct NamedFile {
  std::string option, path;
  bool is_read = false;
  fs::path whole = {};  // of links and points free
};

/// Whether what is there by this name is no file that another would take the place of.
bool is_a_device(const fs::path& path) {
  std::error_code none;
  const fs::file_type kind = fs::status(path, none).type();
  return kind != fs::file_type::not_found && kind != fs::file_type::regular;
}

std::vector<NamedFile> files_of(const CLI::App& command) {
  std::vector<NamedFile> files;
  for (const CLI::Option* option : command.get_options()) {
    const Argument argument = argument_of(*option);
    if (argument.kind != ValueKind::file) continue;
    const bool is_read = option->get_positional() || argument.type == kSceneType;
    // What a state is loaded from may be saved to: it has been read then.
    if (argument.names.back() == "--load") continue;
    for (const std::string& path : option->results())
      if (!is_a_device(path)) {
        std::error_code none;
        files.push_back({argument.names.back(), path, is_read, fs::weakly_canonical(path, none)});
      }
  }
  return files;
}

bool are_one(const NamedFile& a, const NamedFile& b) {
  std::error_code none;
  return a.whole == b.whole || fs::equivalent(a.whole, b.whole, none);
}

}  // namespace

void check_files(const CLI::App& command) {
  const std::vector<NamedFile> files = files_of(command);
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!(files[i].is_read && files[j].is_read) && are_one(files[i], files[j]))
        throw CLI::ValidationError(files[i].option,
                                   fmt::format("found \"{}\" for {} too, expected another file",
                                               files[i].path, files[j].option));
}

std::vector<Command> commands_of(const CLI::App& program) {
  std::vector<Command> commands{command_of(program)};
  for (const CLI::App* sub : program.get_subcommands({})) commands.push_back(command_of(*sub));
  return commands;
}

CLI::Validator named(std::initializer_list<const char*> endings) {
  const std::vector<std::string> known(endings.begin(), endings.end());
  return CLI::Validator(
      [known](std::string& text) {
        const bool fits = std::any_of(known.begin(), known.end(), [&](const std::string& ending) {
          return text.size() > ending.size() && text.ends_with(ending);
        });
        return fits ? std::string()
                    : fmt::format("found \"{}\", expected a name that ends in {}", text,
                                  fmt::join(known, " or "));
      },
      fmt::format("{}", fmt::join(known, "|")));
}

}  // namespace pantin::program
