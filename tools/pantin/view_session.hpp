#pragma once
// What happens in the window: the state of a session and what keys and the mouse do to it.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "tools/pantin/view_loop.hpp"
#include "tools/pantin/view_window.hpp"

namespace pantin::program {

using namespace detail;

class Session {
 public:
  Session(const Scene& scene, const SessionChoices& choices);
  Session(const Session&) = delete;  // systems of the simulation point here
  Session& operator=(const Session&) = delete;

  SessionReport run();

 private:
  // view_loop.cpp
  bool open();
  void run_live();
  void run_script();
  bool may_go_on();
  void push(const ScriptEvent& event);
  void move_script_mouse(const ScriptEvent& event);
  void frame(double wall);
  void advance(double wall);
  void draw();
  std::vector<std::string> label() const;
  void save();
  void fail(const std::vector<Error>& errors, int exit_code, const char* status);

  // view_session.cpp
  void start_over();
  void handle_all();
  void handle(const SDL_Event& event);
  void button_down(const SDL_MouseButtonEvent& event);
  void button_up(const SDL_MouseButtonEvent& event);
  void mouse_moved(const SDL_MouseMotionEvent& event);
  void key_down(SDL_Keycode key);
  void single_step();
  void notice(const StepReport& step);
  void rotation(double right, double down);
  void zoom(double clicks);
  void look();
  void choose(Solver solver);
  void tell(std::string line);
  void stop(const char* status, std::string line);
  std::string solver() const;

  const Scene& scene_;
  const SessionChoices& choices_;
  View view_;
  Eye eye_;
  Simulation sim_;
  Hand hand_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<Window> window_;
  Image image_;
  std::vector<Pose> poses_;  // as drawn, by slot
  std::optional<Solver> chosen_;
  SessionReport report_;
  std::string message_;
  std::string alarm_;       // why the last step stopped the run, until it starts over
  int message_frames_ = 0;  // for which it is still shown
  double fraction_ = 0;     // of the next step
  double gap_ = 0;          // m, after the last step
  double simulated_ = 0;    // s, restarts included
  double speed_ = 1;
  double draw_seconds_ = 0, step_seconds_ = 0;  // wall time of a frame, of a step
  double script_x_ = 0, script_y_ = 0;          // pixels
  int mouse_x_ = 0, mouse_y_ = 0;               // pixels
  std::uint8_t holding_button_ = 0;
  bool paused_ = false, overlay_ = false, help_ = true, turning_ = false, behind_ = false;
  bool quit_ = false, stale_ = true, save_ = false;
};

}  // namespace pantin::program
