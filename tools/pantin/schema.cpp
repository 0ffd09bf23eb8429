#include "engine/scene/keys/schema.hpp"

#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {
namespace {

constexpr std::size_t kColumns = 100;

/// Formats a value, on one line if it fits; `used` columns of the line are taken.
std::string laid_out(const Json& json, std::size_t indent, std::size_t used) {
  std::string whole = json.dump();
  if (!json.is_structured() || json.empty() || used + whole.size() < kColumns) return whole;
  std::string text;
  for (const auto& [key, value] : json.items()) {
    const std::string name = json.is_object() ? Json(key).dump() + ": " : "";
    text += text.empty() ? "\n" : ",\n";
    text.append(indent + 2, ' ').append(name);
    text += laid_out(value, indent + 2, indent + 2 + name.size());
  }
  text += "\n" + std::string(indent, ' ');
  return json.is_object() ? "{" + text + "}" : "[" + text + "]";
}

int schema(const std::string& path) {
  const std::string text = schema_text();
  if (path.empty()) {
    fmt::print("{}", text);
    return kOk;
  }
  return write_or_complain(path, text);
}

constexpr const char* kExamples =
    R"(Prints the JSON Schema (draft 2020-12) of scene files: every key with its type, unit, range,
default and meaning, from the tables with which the program reads scenes.

Examples:
  pantin schema --out out/scene.schema.json
  pantin schema

An editor that supports JSON Schema completes keys, shows their meaning and marks errors while you
type, in any scene that begins with
  {"$schema": "scene.schema.json", "version": 1, ...
or, in VS Code, in all files that its settings name:
  "json.schemas": [{"fileMatch": ["scenes/*.json"], "url": "./out/scene.schema.json"}]

Exit codes: 0 ok, 2 usage, 4 could not write.)";

}  // namespace

std::string schema_text() { return laid_out(Json::parse(scene_schema()), 0, 0) + "\n"; }

void add_schema(CommandLine& program) {
  auto path = std::make_shared<std::string>();
  const Subcommand command = program.add("schema", "Prints the JSON Schema of scene files");
  command.option("--out", *path, "write it to this file instead").type(kFileType);
  command.footer(kExamples);
  command.runs([path] { return schema(*path); });
}

}  // namespace pantin::program
