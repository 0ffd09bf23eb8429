#include "tools/pantin/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string_view>

#include "engine/scene/json/words.hpp"
#include "tools/pantin/exit.hpp"

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

/// Parses "TEXT:{a,b}", "FILE", "FILE:.a|.b" and "FOLDER".
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

/// A file named on the command line.
struct NamedFile {
  std::string option, path;
  bool is_read = false;
  fs::path whole = {};  // canonical path
};

/// Whether the name denotes a device, which is written in place.
bool is_a_device(const fs::path& path) {
  std::error_code none;
  const fs::file_type kind = fs::status(path, none).type();
  return kind != fs::file_type::not_found && kind != fs::file_type::regular;
}

/// The canonical path of a name, links resolved, whether or not the file exists.
fs::path whole_path(const fs::path& name) {
  constexpr int kMostLinks = 40;
  std::error_code none;
  fs::path path = fs::absolute(name, none);
  for (int n = 0; n < kMostLinks && fs::is_symlink(path, none); ++n)
    path = path.parent_path() / fs::read_symlink(path, none);
  return fs::weakly_canonical(path, none);
}

std::vector<NamedFile> files_of(const CLI::App& command) {
  std::vector<NamedFile> files;
  for (const CLI::Option* option : command.get_options()) {
    const Argument argument = argument_of(*option);
    if (argument.kind != ValueKind::file && argument.kind != ValueKind::folder) continue;
    for (const std::string& path : option->results())
      if (path.empty())
        throw CLI::ValidationError(
            argument.names.back(),
            fmt::format("found \"\", expected the name of a {}",
                        argument.kind == ValueKind::file ? "file" : "folder"));
    if (argument.kind == ValueKind::folder) continue;
    const bool is_read = option->get_positional() || argument.type == kSceneType;
    // A state may be saved to the file it was loaded from, which has been read by then.
    if (argument.names.back() == "--load") continue;
    for (const std::string& path : option->results())
      if (path != "-" && !is_a_device(path))
        files.push_back({argument.names.back(), path, is_read, whole_path(path)});
  }
  return files;
}

bool are_one(const NamedFile& a, const NamedFile& b) {
  std::error_code none;
  return a.whole == b.whole || fs::equivalent(a.whole, b.whole, none);
}

/// Throws if one name is given for two files one of which would overwrite the other: for two
/// outputs, or for an output and the scene.
void check_files(const CLI::App& command) {
  const std::vector<NamedFile> files = files_of(command);
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!(files[i].is_read && files[j].is_read) && are_one(files[i], files[j]))
        throw CLI::ValidationError(files[i].option,
                                   fmt::format("found \"{}\" for {} too, expected another file",
                                               files[i].path, files[j].option));
}

/// The fault of a command line, in one line. An unknown word is named, with the nearest known one:
/// CLI11 would report the missing command instead.
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
  if (std::find(known.begin(), known.end(), word) != known.end())
    return fmt::format("found \"{}\" before the command, expected it after", word);
  const std::vector<std::string_view> candidates(known.begin(), known.end());
  return fmt::format("found \"{}\", expected {}{}", word,
                     is_option || !chosen.empty() ? "one of the options" : "one of " + commands,
                     pantin::detail::hint(word, candidates));
}

/// Whether the command line has unknown words: it is then not only a call for help.
bool has_stray_words(const CLI::App& program) { return !program.remaining(true).empty(); }

}  // namespace

// ---- Arguments of a command ---------------------------------------------------------------------

const Option& Option::required() const {
  option_->required();
  return *this;
}

const Option& Option::type(const char* name) const {
  option_->type_name(name);
  return *this;
}

const Option& Option::one_of(const std::vector<std::string>& words) const {
  option_->check(CLI::Validator(
      [words](std::string& text) {
        if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
        const std::vector<std::string_view> candidates(words.begin(), words.end());
        return fmt::format("found \"{}\", expected one of {}{}", text, fmt::join(words, ", "),
                           pantin::detail::hint(text, candidates));
      },
      fmt::format("{{{}}}", fmt::join(words, ","))));
  return *this;
}

namespace {

/// Accepts text that parses completely as a T from `least` to `most`.
template <typename T>
CLI::Validator in_range(T least, T most, const char* what) {
  return {[=](std::string& text) {
            T x = 0;
            const char* end = text.data() + text.size();
            const auto read = std::from_chars(text.data(), end, x);
            // Positive comparisons, so that NaN is rejected.
            if (read.ec == std::errc() && read.ptr == end && x >= least && x <= most)
              return std::string();
            return fmt::format("found \"{}\", expected {} from {} to {}", text, what, least, most);
          },
          fmt::format("in [{} - {}]", least, most)};
}

}  // namespace

const Option& Option::within(int least, int most) const {
  option_->check(in_range(least, most, "a whole number"));
  return *this;
}

const Option& Option::between(double least, double most) const {
  option_->check(in_range(least, most, "a number"));
  return *this;
}

const Option& Option::ends_in(std::initializer_list<const char*> endings) const {
  const std::vector<std::string> known(endings.begin(), endings.end());
  option_->check(CLI::Validator(
      [known](std::string& text) {
        const bool fits = std::any_of(known.begin(), known.end(), [&](const std::string& ending) {
          return text.size() > ending.size() && text.ends_with(ending);
        });
        return fits ? std::string()
                    : fmt::format("found \"{}\", expected a name that ends in {}", text,
                                  fmt::join(known, " or "));
      },
      fmt::format("{}", fmt::join(known, "|"))));
  return *this;
}

const Option& Option::read_as(const std::function<std::string(std::string)>& word) const {
  option_->transform(word);
  return *this;
}

const Option& Option::separated_by(char delimiter) const {
  option_->delimiter(delimiter);
  return *this;
}

const Option& Option::count(int values) const {
  option_->expected(values);
  return *this;
}

const Option& Option::one_at_a_time() const {
  option_->allow_extra_args(false);
  return *this;
}

const Option& Option::shows_default() const {
  option_->capture_default_str();
  return *this;
}

const Option& Option::excludes(const Option& other) const {
  option_->excludes(other.option_);
  return *this;
}

template <typename T>
Option Subcommand::option(const char* name, T& value, const std::string& about) const {
  return Option(*parser_->add_option(name, value, about));
}
template Option Subcommand::option(const char*, int&, const std::string&) const;
template Option Subcommand::option(const char*, double&, const std::string&) const;
template Option Subcommand::option(const char*, std::string&, const std::string&) const;
template Option Subcommand::option(const char*, std::optional<int>&, const std::string&) const;
template Option Subcommand::option(const char*, std::optional<double>&, const std::string&) const;
template Option Subcommand::option(const char*, std::optional<std::string>&,
                                   const std::string&) const;
template Option Subcommand::option(const char*, std::vector<double>&, const std::string&) const;
template Option Subcommand::option(const char*, std::vector<std::string>&,
                                   const std::string&) const;

Option Subcommand::flag(const char* name, bool& value, const std::string& about) const {
  return Option(*parser_->add_flag(name, value, about));
}

Option Subcommand::added(const char* name) const { return Option(*parser_->get_option(name)); }

void Subcommand::footer(const char* text) const { parser_->footer(text); }

void Subcommand::runs(std::function<int()> action) const {
  parser_->callback([action = std::move(action), code = exit_code_] { *code = action(); });
}

// ---- The program --------------------------------------------------------------------------------

CommandLine::CommandLine(const Texts& texts)
    : parser_(std::make_unique<CLI::App>(texts.about, "pantin")) {
  parser_->set_version_flag("--version", texts.version);
  parser_->footer(texts.footer);
  parser_->require_subcommand(1);
  parser_->get_formatter()->column_width(30);
}

CommandLine::~CommandLine() = default;

Subcommand CommandLine::add(const char* name, const char* about) {
  CLI::App* command = parser_->add_subcommand(name, about);
  command->parse_complete_callback([command] { check_files(*command); });
  return Subcommand(*command, exit_code_);
}

std::vector<std::string> CommandLine::names() const {
  std::vector<std::string> names;
  for (const CLI::App* sub : parser_->get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

std::vector<Command> CommandLine::described() const {
  std::vector<Command> commands{command_of(*parser_)};
  for (const CLI::App* sub : parser_->get_subcommands({})) commands.push_back(command_of(*sub));
  return commands;
}

std::string CommandLine::version() const { return parser_->version(); }

std::string CommandLine::help() const {
  // Its own help() would show the active command, which may be `help`.
  return parser_->get_formatter()->make_help(parser_.get(), "pantin", CLI::AppFormatMode::Normal);
}

std::string CommandLine::help(const std::string& command) const {
  return parser_->get_subcommand(command)->help("pantin");
}

int CommandLine::run(int argc, char** argv) {
  if (argc == 1) {
    fmt::print("{}", parser_->help());
    return kOk;
  }
  try {
    parser_->parse(argc, argv);
    return exit_code_;
  } catch (const CLI::ParseError& e) {
    // --help, --version
    if (e.get_exit_code() == 0 && !has_stray_words(*parser_)) return parser_->exit(e);
    // One line, and where to find help.
    const auto chosen = parser_->get_subcommands();
    const std::string who = chosen.empty() ? "pantin" : "pantin " + chosen.front()->get_name();
    const CLI::ExtrasError strays(who, parser_->remaining(true));
    const CLI::ParseError& why = e.get_exit_code() == 0 ? strays : e;
    fmt::print(stderr, "{}: {}; see {} --help\n", who, complaint_of(*parser_, why), who);
    return kUsage;
  }
}

const char* parser_version() { return CLI11_VERSION; }

}  // namespace pantin::program
