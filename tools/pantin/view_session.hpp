#pragma once
// The window around a Desk: events in, pictures out, files.
#include <memory>
#include <string>
#include <vector>

#include "engine/render/capture.hpp"
#include "tools/pantin/view_export.hpp"
#include "tools/pantin/view_loop.hpp"
#include "tools/pantin/view_panel.hpp"
#include "tools/pantin/view_window.hpp"

namespace pantin::program {

using namespace detail;

class Session {
 public:
  Session(Scene scene, SessionChoices choices);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  SessionReport run();

 private:
  // view_loop.cpp
  bool open();
  void run_live();
  void run_script();
  bool may_go_on();
  void frame(double wall);
  int most_steps() const;
  void fit_window();
  void finish();
  void fail(const std::vector<Error>& errors, int exit_code, const char* status);

  // view_events.cpp
  void handle_all();
  void handle(const SDL_Event& event);
  void button(const SDL_MouseButtonEvent& event);
  void play(const ScriptEvent& event);
  void push(const ScriptEvent& event);
  void move_script_mouse(const ScriptEvent& event);

  // view_session.cpp
  void draw();
  void draw_pane(std::size_t index, Image& to);
  void compose();
  void save();
  void keep_pose();
  void keep_tuned();
  void watch_run();
  void start_run(RunWish wish);
  void end_run();
  void fail_file(const std::string& path, const std::vector<Error>& errors);
  void toggle_film();
  void film(double wall);
  void end_film();

  SessionChoices choices_;
  Desk desk_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<Window> window_;
  std::unique_ptr<Panel> panel_;       // null: this build has none
  std::unique_ptr<Capture> film_;      // while recording
  std::unique_ptr<RunExport> export_;  // while a run is recorded
  std::string film_path_;
  int film_width_ = 0, film_height_ = 0;
  double film_time_ = 0;  // s not yet filmed
  Image window_image_, pane_image_;
  SessionReport report_;
  double draw_seconds_ = 0;  // wall time of a picture
  std::string window_title_;
  double watched_ = 0;                  // s since the file was checked
  double script_x_ = 0, script_y_ = 0;  // pixels
  std::uint64_t beats_ = 0;
  int width_ = 0, height_ = 0;  // of the window
};

}  // namespace pantin::program
