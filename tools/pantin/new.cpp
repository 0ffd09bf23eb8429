#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "engine/base/utf8.hpp"
#include "engine/scene/json/words.hpp"
#include "engine/scene/keys/schema.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {
namespace {

/// A starting scene: short enough to read at once, with one of each thing that it shows.
struct Template {
  std::string_view name, about, text;
};

constexpr Template kTemplates[] = {
    {"pendulum", "two rods on a hook; a push after two seconds", R"({
  "$schema": "scene.schema.json",
  "version": 1,
  "title": "Two rods on a hook, pushed after two seconds",
  "duration": 6,
  "materials": [
    {"name": "red", "colour": "#c0392b"},
    {"name": "blue", "colour": "#2f66b0"}
  ],
  "bodies": [
    {"name": "upper", "position": [0, 1.5, 0], "density": 600, "drag": 0,
     "shape": {"type": "capsule", "radius": 0.03, "length": 0.44, "material": "red"}},
    {"name": "lower", "position": [0, 1, 0], "density": 600, "drag": 0,
     "shape": {"type": "capsule", "radius": 0.03, "length": 0.44, "material": "blue"}}
  ],
  "joints": [
    {"name": "hook", "kind": "ball", "a": "world", "b": "upper", "anchor": [0, 1.75, 0]},
    {"name": "elbow", "kind": "hinge", "a": "upper", "b": "lower", "anchor": [0, 1.25, 0],
     "axis": [0, 0, 1]}
  ],
  "events": [
    {"type": "push", "body": "lower", "force": [6, 0, 0], "from": 2, "to": 2.3}
  ]
}
)"},
    {"chain", "a chain whose top follows a path, over a floor with a box", R"({
  "$schema": "scene.schema.json",
  "version": 1,
  "title": "A chain led over a box",
  "duration": 6,
  "materials": [
    {"name": "steel", "colour": "#5b6770", "metallic": 0.6},
    {"name": "sand", "colour": "#d8b98a"},
    {"name": "wood", "colour": "#b98a55"}
  ],
  "bodies": [
    {"name": "floor", "motion": "fixed", "shape": {"type": "plane"}, "collision": true},
    {"name": "box", "motion": "fixed", "position": [0, 0.2, 0], "collision": {"friction": 0.4},
     "shape": {"type": "box", "size": [0.5, 0.4, 0.5], "material": "wood"}},
    {"name": "hand", "motion": "kinematic", "position": [-0.8, 1.5, 0],
     "shape": {"type": "sphere", "radius": 0.05, "material": "steel"}}
  ],
  "generators": {
    "chains": [
      {"name": "chain", "links": 16, "length": 0.08, "start": [-0.8, 1.45, 0], "attach": "hand",
       "shape": {"type": "capsule", "radius": 0.025, "length": 0.03}, "materials": ["sand", "steel"],
       "density": 800, "collision": {"friction": 0.4}}
    ]
  },
  "paths": [
    {"body": "hand", "keyframes": [
      {"time": 0, "position": [-0.8, 1.5, 0]},
      {"time": 1, "position": [-0.8, 1.5, 0]},
      {"time": 3, "position": [0.7, 1.3, 0]},
      {"time": 5, "position": [0, 1.2, 0]}]}
  ]
}
)"},
    {"linkage", "a four-bar linkage with a motor, by the exact solver", R"({
  "$schema": "scene.schema.json",
  "version": 1,
  "title": "A four-bar linkage, turned by a motor",
  "duration": 6,
  "step": 0.005,
  "solver": {"type": "lagrangian"},
  "materials": [
    {"name": "red", "colour": "#c0453a"},
    {"name": "brass", "colour": "#d9a53c"},
    {"name": "blue", "colour": "#2f66b0"}
  ],
  "bodies": [
    {"name": "crank", "position": [0, 1.1, 0], "drag": 0,
     "shape": {"type": "box", "size": [0.03, 0.2, 0.03], "material": "red"}},
    {"name": "coupler", "position": [0.3, 1.325, 0], "rotation_deg": [0, 0, 22.61986494804043], "drag": 0,
     "shape": {"type": "box", "size": [0.65, 0.03, 0.03], "material": "brass"}},
    {"name": "rocker", "position": [0.6, 1.225, 0], "drag": 0,
     "shape": {"type": "box", "size": [0.03, 0.45, 0.03], "material": "blue"}}
  ],
  "joints": [
    {"name": "motor", "kind": "hinge", "a": "world", "b": "crank", "anchor": [0, 1, 0],
     "axis": [0, 0, 1], "motor": {"velocity_deg": 180, "gain": 10, "cap": 20}},
    {"name": "pin", "kind": "hinge", "a": "crank", "b": "coupler", "anchor": [0, 1.2, 0],
     "axis": [0, 0, 1]},
    {"name": "knee", "kind": "hinge", "a": "coupler", "b": "rocker", "anchor": [0.6, 1.45, 0],
     "axis": [0, 0, 1]},
    {"name": "pivot", "kind": "hinge", "a": "world", "b": "rocker", "anchor": [0.6, 1, 0],
     "axis": [0, 0, 1]}
  ]
}
)"},
};

struct NewChoices {
  std::string path, from = "pendulum";
  bool replace = false;
};

int write_new(const NewChoices& choices) {
  namespace fs = std::filesystem;
  const auto* found = std::find_if(std::begin(kTemplates), std::end(kTemplates),
                                   [&](const Template& t) { return t.name == choices.from; });
  // An editor finds the schema at the path that the scene names.
  const fs::path schema = fs::path(choices.path).parent_path() / "scene.schema.json";
  std::error_code ignored;
  if (schema == choices.path) {
    complain(
        fmt::format("{}: found the name of the schema, which is written beside the scene; "
                    "expected another",
                    printable(choices.path)));
    return kUsage;
  }
  if (!choices.replace && fs::exists(choices.path, ignored)) {
    complain(fmt::format("{}: found a file, expected none; --replace overwrites it",
                         printable(choices.path)));
    return kUsage;
  }
  if (const int code = write_or_complain(choices.path, found->text)) return code;
  if (!fs::exists(schema, ignored))
    if (const int code = write_or_complain(schema.string(), schema_text())) return code;
  fmt::print("{}: {}\n", printable(choices.path), found->about);
  return kOk;
}

constexpr const char* kExamples =
    R"(Writes a small scene to start from, and scene.schema.json beside it, with which editors
complete keys and mark errors. Files are overwritten only with --replace.

Examples:
  pantin new scene.json && pantin run scene.json --frames out/frames
  pantin new bench.json --from linkage && pantin view bench.json

Exit codes: 0 ok, 2 usage or an existing file, 4 could not write.)";

}  // namespace

void add_new(CommandLine& program) {
  auto choices = std::make_shared<NewChoices>();
  const Subcommand command = program.add("new", "Writes a small scene to start from");
  command.option("SCENE", choices->path, "the file to write").required().type(kSceneType);
  std::vector<std::string> names;
  std::string about = "the template:";
  for (const Template& t : kTemplates) {
    names.emplace_back(t.name);
    about += fmt::format("{} {} ({})", names.size() > 1 ? "," : "", t.name, t.about);
  }
  command.option("--from", choices->from, about).one_of(names);
  command.flag("--replace", choices->replace, "overwrite an existing file");
  command.footer(kExamples);
  command.runs([choices] { return write_new(*choices); });
}

}  // namespace pantin::program
