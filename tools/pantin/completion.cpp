// `pantin completion`: shell completion, generated from the parser's description.
#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include <memory>
#include <string>

#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

namespace {

std::string joined(const std::vector<std::string>& words, const char* between = " ") {
  return fmt::format("{}", fmt::join(words, between));
}

std::vector<std::string> option_names(const Command& command) {
  std::vector<std::string> names;
  for (const Argument& o : command.options)
    names.insert(names.end(), o.names.begin(), o.names.end());
  return names;
}

// ---- bash --------------------------------------------------------------------------------------

/// The bash function call that offers the values of an argument.
std::string bash_values(const Argument& a) {
  switch (a.kind) {
    case ValueKind::choice:
      return fmt::format("_pantin_words '{}'", joined(a.values));
    case ValueKind::file:
      return "_pantin_files " + (a.values.empty() ? "''" : joined(a.values));
    case ValueKind::folder:
      return "_pantin_files";
    default:
      return ":";
  }
}

constexpr const char* kBashHead =
    R"(# bash completion of pantin, written by `pantin completion bash`.

_pantin_words() { COMPREPLY=($(compgen -W "$1" -- "$current")); }

# Folders, and files whose names end in one of the arguments.
_pantin_files() {
  local path ending
  while IFS= read -r path; do
    if [[ -d ${path/#\~\//$HOME/} ]]; then
      COMPREPLY+=("$path")
      continue
    fi
    for ending in "$@"; do
      if [[ $path == *"$ending" ]]; then
        COMPREPLY+=("$path")
        break
      fi
    done
  done < <(compgen -f -- "$current")
  compopt -o filenames 2>/dev/null
}

_pantin() {
  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command="" i
  COMPREPLY=()
  # --option=value comes as three words.
  if [[ $current == = ]]; then
    current=""
  elif [[ $before == = ]]; then
    before=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    if [[ ${COMP_WORDS[i]} != -* ]]; then
      command=${COMP_WORDS[i]}
      break
    fi
  done
  case "$command $before" in
)";

/// Offers values of options, then options, then positionals.
std::string bash_script(const std::vector<Command>& commands) {
  std::string script = kBashHead;
  for (const Command& c : commands)
    for (const Argument& o : c.options) {
      if (o.kind == ValueKind::none) continue;
      const std::string of = &c == &commands.front() ? "" : c.name;
      for (const std::string& name : o.names)
        script += fmt::format("    '{} {}') {}; return ;;\n", of, name, bash_values(o));
    }
  script += "  esac\n  case \"$command $current\" in\n";
  std::vector<std::string> first;
  for (std::size_t i = 1; i < commands.size(); ++i) {
    const Command& c = commands[i];
    first.push_back(c.name);
    script += fmt::format("    '{} '-*) _pantin_words '{}' ;;\n", c.name, joined(option_names(c)));
    if (!c.positionals.empty())
      script += fmt::format("    '{} '*) {} ;;\n", c.name, bash_values(c.positionals.front()));
  }
  script +=
      fmt::format("    ' '-*) _pantin_words '{}' ;;\n", joined(option_names(commands.front())));
  script += fmt::format("    ' '*) _pantin_words '{}' ;;\n", joined(first));
  return script + "  esac\n}\n\ncomplete -F _pantin pantin\n";
}

// ---- zsh ---------------------------------------------------------------------------------------

/// Escapes text for '...[ ]', where brackets, colons and quotes are special.
std::string zsh_text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\'')
      safe += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      safe += std::string("\\") + c;
    else
      safe += c;
  }
  return safe;
}

std::string zsh_values(const Argument& a) {
  std::string endings;
  switch (a.kind) {
    case ValueKind::choice:
      return fmt::format("({})", joined(a.values));
    case ValueKind::file:
      if (a.values.empty()) return "_files";
      for (const std::string& ending : a.values)
        endings += (endings.empty() ? "" : "|") + ending.substr(1);
      // A single one in parentheses would be read as a glob qualifier.
      if (a.values.size() > 1) endings = "(" + endings + ")";
      return fmt::format("_files -g \"*.{}\"", endings);
    case ValueKind::folder:
      return "_files -/";
    default:
      return " ";
  }
}

std::string zsh_arguments(const Command& command, const char* indent) {
  std::string lines;
  for (const Argument& o : command.options)
    for (const std::string& name : o.names) {
      const bool has_value = o.kind != ValueKind::none;
      lines += fmt::format(" \\\n{}'{}{}[{}]{}'", indent, name,
                           has_value && name.starts_with("--") ? "=" : "", zsh_text(o.about),
                           has_value ? ":value:" + zsh_values(o) : "");
    }
  for (const Argument& p : command.positionals)
    lines += fmt::format(" \\\n{}'{}:{}:{}'", indent, p.repeats ? "*" : "1", p.names.front(),
                         zsh_values(p));
  return lines;
}

std::string zsh_script(const std::vector<Command>& commands) {
  std::string script =
      "#compdef pantin\n# zsh completion of pantin, written by `pantin completion zsh`.\n\n"
      "_pantin() {\n  local context state line\n  typeset -A opt_args\n  _arguments -C";
  script += zsh_arguments(commands.front(), "    ") +
            " \\\n    '1: :->command' \\\n    '*:: :->rest'\n  case $state in\n    command)\n"
            "      local -a commands=(\n";
  for (std::size_t i = 1; i < commands.size(); ++i)
    script += fmt::format("        '{}:{}'\n", commands[i].name, zsh_text(commands[i].about));
  script +=
      "      )\n      _describe command commands\n      ;;\n    rest)\n      case $line[1] in\n";
  for (std::size_t i = 1; i < commands.size(); ++i)
    script += fmt::format("        {})\n          _arguments{}\n          ;;\n", commands[i].name,
                          zsh_arguments(commands[i], "            "));
  return script +
         "      esac\n      ;;\n  esac\n}\n\n"
         "# Read from a folder of fpath, or by `source`.\n"
         "if [[ $zsh_eval_context[-1] == loadautofunc ]]; then\n  _pantin \"$@\"\nelse\n"
         "  compdef _pantin pantin\nfi\n";
}

// ---- fish --------------------------------------------------------------------------------------

std::string fish_text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\'' || c == '\\') safe += '\\';
    safe += c;
  }
  return "'" + safe + "'";
}

/// The possible values, as options of `complete`.
std::string fish_values(const Argument& a) {
  switch (a.kind) {
    case ValueKind::none:
      return "";
    case ValueKind::choice:
      return fmt::format(" -x -a '{}'", joined(a.values));
    case ValueKind::folder:
      return " -x -a '(__fish_complete_directories)'";
    case ValueKind::file:
      if (a.values.empty()) return " -r -F";
      {
        std::string calls;
        for (const std::string& ending : a.values)
          calls += fmt::format("{}__fish_complete_suffix {}", calls.empty() ? "" : "; ", ending);
        return fmt::format(" -x -k -a '({})'", calls);
      }
    default:
      return " -x";
  }
}

void add_fish_lines(std::string& script, const Command& command, const std::string& when) {
  for (const Argument& o : command.options) {
    script += "complete -c pantin -n " + when;
    for (const std::string& name : o.names)
      script += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    script += fish_values(o) + " -d " + fish_text(o.about) + "\n";
  }
  for (const Argument& p : command.positionals)
    script += "complete -c pantin -n " + when + fish_values(p) + "\n";
}

std::string fish_script(const std::vector<Command>& commands) {
  std::string script =
      "# fish completion of pantin, written by `pantin completion fish`.\ncomplete -c pantin -f\n";
  add_fish_lines(script, commands.front(), "__fish_use_subcommand");
  for (std::size_t i = 1; i < commands.size(); ++i) {
    const Command& c = commands[i];
    script += fmt::format("complete -c pantin -n __fish_use_subcommand -a {} -d {}\n", c.name,
                          fish_text(c.about));
    add_fish_lines(script, c, fmt::format("'__fish_seen_subcommand_from {}'", c.name));
  }
  return script;
}

constexpr const char* kExamples =
    R"help(Writes a shell script that completes commands, options, their values and scene files.
`cmake --install` puts it where shells look for it; by hand:

Examples:
  pantin completion bash > out/pantin
  pantin completion zsh > out/_pantin
  pantin completion fish > out/pantin.fish

Or load it when the shell starts: "source <(pantin completion bash)" in ~/.bashrc, the same of zsh
in ~/.zshrc after compinit, "pantin completion fish | source" in ~/.config/fish/config.fish.

Exit codes: 0 ok, 2 usage.)help";

}  // namespace

void add_completion(CommandLine& program) {
  auto shell = std::make_shared<std::string>();
  const Subcommand command = program.add("completion", "Prints a shell completion script");
  command.option("shell", *shell, "the shell").required().one_of({"bash", "zsh", "fish"});
  command.footer(kExamples);
  command.runs([shell, &program] {
    const std::vector<Command> commands = program.described();
    fmt::print("{}", *shell == "bash"  ? bash_script(commands)
                     : *shell == "zsh" ? zsh_script(commands)
                                       : fish_script(commands));
    return kOk;
  });
}

}  // namespace pantin::program
