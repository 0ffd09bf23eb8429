#pragma once
// A desk of the viewer over a scene file of its own.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "tools/pantin/view_desk.hpp"

namespace pantin::program {

inline constexpr const char* kPendulum = R"({
  "version": 1, "title": "Two rods",
  "bodies": [
    {"name": "upper", "position": [0.25, 1, 0], "drag": 0,
     "shape": {"type": "box", "size": [0.5, 0.04, 0.04]}},
    {"name": "lower", "position": [0.75, 1, 0], "drag": 0,
     "shape": {"type": "box", "size": [0.5, 0.04, 0.04]}}],
  "joints": [
    {"name": "hook", "a": "world", "b": "upper", "anchor_a": [0, 1, 0], "anchor_b": [-0.25, 0, 0]},
    {"name": "knee", "a": "upper", "b": "lower", "anchor_a": [0.25, 0, 0],
     "anchor_b": [-0.25, 0, 0]}],
  "camera": {"eye": [0, 1, 4], "target": [0, 1, 0], "automatic": false}
})";

/// A desk over a file of its own.
struct Bench {
  std::filesystem::path folder;
  std::string path;
  std::unique_ptr<Desk> desk;

  explicit Bench(const std::string& text = kPendulum) {
    folder = std::filesystem::temp_directory_path() /
             ("pantin_desk_" + std::to_string(::getpid()) + "_" + std::to_string(next_number()));
    std::filesystem::create_directories(folder);
    path = (folder / "scene.json").string();
    write(text);
    DeskChoices choices;
    choices.path = path, choices.width = 640, choices.height = 360;
    choices.load = [](const std::string& from) { return load_scene(from); };
    desk = std::make_unique<Desk>(load_scene(path).value(), choices);
  }
  ~Bench() { std::filesystem::remove_all(folder); }
  static int next_number() {
    static int number = 0;
    return ++number;
  }

  void write(const std::string& text, const char* name = "scene.json") const {
    std::ofstream(folder / name) << text;
  }
  /// Makes sure that the file's time differs: some systems count in whole milliseconds.
  void touch_later() const {
    std::filesystem::last_write_time(
        path, std::filesystem::last_write_time(path) + std::chrono::seconds(2));
  }
  void run(double seconds) const {
    for (int i = 0; i < static_cast<int>(seconds * 60 + 0.5); ++i) desk->advance(1.0 / 60, 100);
  }
  World& world(std::size_t pane = 0) const { return desk->panes[pane]->world(); }
  Entity find(const char* name) const { return world().find(name); }
  Vec3 on_screen(const char* name) const {
    return desk->eye().project(world().bodies[find(name)].pose.position);
  }
  void click(MouseButton button, Vec3 at) const {
    desk->press(button, at.x, at.y);
    desk->release(button, at.x, at.y);
  }
};

}  // namespace pantin::program
