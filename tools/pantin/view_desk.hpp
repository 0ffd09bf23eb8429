#pragma once
// The viewer without its window: its state, and the effect of keys, mouse and panel.
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/world/solver_list.hpp"
#include "tools/pantin/view_acts.hpp"
#include "tools/pantin/view_files.hpp"
#include "tools/pantin/view_gauge.hpp"
#include "tools/pantin/view_knobs.hpp"
#include "tools/pantin/view_orbit.hpp"
#include "tools/pantin/view_pane.hpp"

namespace pantin::program {

using namespace detail;

/// Names of the keys in use, as in scripts.
inline constexpr std::string_view kKeys[]{
    "space", ".",    "[",     "]",  "1",    "2",       "3",         "4", "5", "o",      "r",   "s",
    "h",     "q",    "w",     "f",  "l",    "x",       "p",         "b", "c", "v",      "tab", "f5",
    "home",  "left", "right", "up", "down", "page_up", "page_down", "+", "-", "escape", "m",   "k",
    "a",     "d",    "e",     "g",  "i",    "j",       "t",         "u", "n", "y"};

/// The solvers that the window offers: those that any scene can be tried with.
inline constexpr auto kOfferedSolvers = [] {
  constexpr auto is_offered = [](const SolverInfo& s) {
    return s.scope == SolverScope::any || s.scope == SolverScope::posing;
  };
  std::array<Solver, std::ranges::count_if(kSolverInfos, is_offered)> offered{};
  auto at = offered.begin();
  for (const SolverInfo& s : kSolverInfos)
    if (is_offered(s)) *at++ = s.solver;
  return offered;
}();

enum class MouseButton : std::uint8_t { left, middle, right };
struct KeysHeld {
  bool shift = false, alt = false;
};
/// The action of the left button.
enum class Tool : std::uint8_t { drag, cut, pin, ball };
inline constexpr const char* kTools[]{"drag", "cut", "pin", "ball"};

/// Reads a scene file again; errors are whole lines.
using SceneLoader = std::function<Result<Scene>(const std::string& path)>;

/// What happens at the end of the scene's duration.
enum class AtEnd : std::uint8_t { go_on, stop, loop };
inline constexpr const char* kAtEnds[]{"go_on", "stop", "loop"};

/// A request to write a run: from now on until it is requested again, or from a restart to the end
/// of the scene's duration.
enum class RunWish : std::uint8_t { none, from_now, whole };

struct DeskChoices {
  std::string path;  // of the scene
  SceneLoader load;
  int width = 1280, height = 720;  // of the picture, pixels, without the panel
  int threads = 1;
  std::optional<Solver> beside;  // a second pane from the start
  AtEnd at_end = AtEnd::go_on;
};

class Desk {
 public:
  Desk(Scene scene, DeskChoices choices);

  // Time.
  /// Advances by wall time, at most `most` steps in each pane.
  void advance(double wall, int most);
  void single_step();
  /// Begins or ends pose mode: time stands still, and mechanisms follow the mouse without dynamics.
  void toggle_posing();
  bool is_posing() const { return panes[0]->hand.poses(); }
  void restart();
  void faster(double times);

  // User input, in pixels of the picture.
  void press(MouseButton button, double x, double y);
  void release(MouseButton button, double x, double y);
  void move(double x, double y);
  void wheel(double up, double across);
  void key(std::string_view name);
  void hold(KeysHeld keys) { held_ = keys; }
  /// The mouse has left the picture.
  void leave() { has_mouse_ = false; }
  /// Updates the body under the mouse.
  void look_under_mouse();

  // Display.
  void resize(int width, int height);
  /// The pane with the mouse, or that which had it last.
  const Pane& pane_at_mouse() const { return *panes[pane_]; }
  int pane_width() const { return std::max(1, width_ / static_cast<int>(panes.size())); }
  int width() const { return width_; }
  int height() const { return height_; }
  View view() const;
  const Eye& eye() const { return eye_; }
  void toggle_follow();
  /// The scene's own camera, or one that frames what is there now from the scene's direction.
  void reset_camera();
  /// Frames what is there now, seen from a side (unit, towards the eye).
  void look_from(Vec3 way);

  // The scene.
  const Scene& scene() const { return scene_; }
  const std::string& path() const { return choices_.path; }
  /// Reads the scene again if its file, or a mesh that it names, has changed since the last call.
  void watch();
  void reload() { open(choices_.path); }
  /// Opens another file, or the same again; on failure the scene stays, and the reason is shown.
  void open(std::string path);
  const std::vector<std::string>& scenes() const { return scenes_; }
  void leaf(int by);
  void choose(Solver solver, std::size_t pane);
  /// Opens a second pane that continues from the present state with another solver.
  void compare(std::optional<Solver> solver);
  std::vector<Knob> knobs() const;
  bool turn(const std::string& name, double value);
  /// Knobs that were changed since the file was read, with their values.
  const std::vector<std::pair<std::string, double>>& turned() const { return turned_; }
  void use(Tool tool, double x, double y);

  /// Shows a message in the picture and the report.
  void tell(std::string line);
  /// The text lines over a pane's picture.
  std::vector<std::string> labels(std::size_t pane) const;

  std::vector<std::unique_ptr<Pane>> panes;  // one or two
  Tool tool = Tool::drag;
  BallGun gun;
  double speed = 1;
  bool paused = false, overlay = false, forces = false, wireframe = false, help = true;
  bool states = false;  // bodies are coloured by their state
  Gauge gauge;
  bool panel = false;
  // Requests to the owner of the window.
  bool quits = false, wants_picture = false, wants_film = false, wants_pose = false,
       wants_tuned = false;
  RunWish wants_run = RunWish::none;
  bool stale = true;      // the picture is out of date
  Entity under;           // the body under the mouse, or the last one if there is none
  bool is_under = false;  // it is under the mouse now
  Entity followed;
  std::string message;
  bool is_trouble = false;    // the message reports a failure
  double message_left = 0;    // s, wall
  std::string status = "ok";  // of the session: ok, diverged, energy_grew
  int restarts = 0;
  std::vector<std::string> notes;

 private:
  enum class Grip : std::uint8_t { none, body, turn, pan };
  /// The position of a press.
  struct Place {
    std::size_t pane;
    SeenPixel pixel;
  };

  Place place(double x, double y) const;
  Camera home_camera() const;
  void begin(Scene scene);
  void watch_files();
  void start_panes();
  Solver another() const;
  void look();
  void follow();
  void notice(Pane& pane, const StepReport& step);
  bool take(const Picked& picked, const Place& at, PinKind grip);
  void let_go();
  void camera_key(std::string_view name);
  bool looks_key(std::string_view name);
  void cut(const Place& at);
  void pin(const Place& at);
  void throw_ball(const Place& at);
  void measure_at(const Place& at);
  void plot_at(const Place& at);
  void end_of_scene(double before);
  void next_at_end();

  Scene scene_;
  DeskChoices choices_;
  std::vector<std::string> scenes_;
  std::size_t leaf_ = 0;  // index in scenes_
  FileWatch watch_;
  Orbit orbit_;
  Eye eye_;
  StepSettings how_;
  std::vector<std::pair<std::string, double>> turned_;  // changed knobs, until the file is read
                                                        // again
  int width_, height_;
  double title_left_ = 0;  // s that the title is shown, wall
  double mouse_x_ = 0, mouse_y_ = 0;
  double moved_ = 0;  // pixels since the button was pressed
  bool has_mouse_ = false;
  KeysHeld held_;
  Grip grip_ = Grip::none;
  MouseButton button_ = MouseButton::left;
  std::size_t pane_ = 0;  // the pane in which the button was pressed
};

}  // namespace pantin::program
