// User input: the mouse and the keys.
#include "tools/pantin/view_desk.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace pantin::program {

using namespace detail;

namespace {

constexpr double kClick = 3;         // pixels: a shorter motion is a click, not a drag
constexpr double kKeyTurn = 40;      // pixels of mouse motion per arrow key
constexpr double kPixelsAcross = 8;  // pixels per click of a sideways wheel

}  // namespace

Desk::Place Desk::place(double x, double y) const {
  const int width = pane_width();
  const auto last = static_cast<double>(panes.size() - 1);
  const double index = std::clamp(std::floor(x / width), 0.0, last);
  return {static_cast<std::size_t>(index), {eye_, x - index * width, y}};
}

void Desk::press(MouseButton button, double x, double y) {
  if (grip_ != Grip::none) return;
  mouse_x_ = x, mouse_y_ = y, has_mouse_ = true, moved_ = 0;
  const Place at = place(x, y);
  pane_ = at.pane, button_ = button;
  stale = true;
  const bool pans = button == MouseButton::right || held_.shift;
  if (button == MouseButton::middle || held_.alt) {
    grip_ = pans ? Grip::pan : Grip::turn;
    return;
  }
  if (button == MouseButton::left && tool != Tool::drag && !held_.shift) return use(tool, x, y);
  const auto picked = pick(panes[pane_]->scene(), at.pixel);
  if (!picked) {
    grip_ = pans ? Grip::pan : Grip::turn;
    return;
  }
  const World& world = panes[pane_]->world();
  if (world.bodies[picked->body].motion == Motion::fixed) {
    tell(world.name_of(picked->body) + " is fixed and cannot be dragged");
    grip_ = pans ? Grip::pan : Grip::turn;
    return;
  }
  if (take(*picked, at, pans ? PinKind::spring : PinKind::exact)) grip_ = Grip::body;
}

/// Grabs the same body in both panes.
bool Desk::take(const Picked& picked, const Place& at, PinKind grip) {
  for (const auto& pane : panes) {
    const Body* body = pane->world().bodies.find(picked.body);
    if (!body || body->motion == Motion::fixed) continue;
    const std::uint32_t slot = pane->world().bodies.slot(picked.body);
    Picked own = picked;
    own.point = to_world(pane->scene().pose_of(slot), picked.anchor);
    pane->hand.take(pane->world(), own, grip, at.pixel);
  }
  return panes[at.pane]->hand.holds();
}

void Desk::let_go() {
  for (const auto& pane : panes) pane->hand.let_go(pane->world());
  if (grip_ == Grip::body) grip_ = Grip::none;
}

void Desk::release(MouseButton button, double x, double y) {
  if (button != button_ || grip_ == Grip::none) return;
  move(x, y);
  const bool is_click = button != MouseButton::middle && !held_.alt && moved_ < kClick;
  if (grip_ == Grip::body) help = false;  // no longer needed, and it covers the picture
  let_go();
  grip_ = Grip::none;
  if (is_click) plot_at(place(x, y));
  stale = true;
}

void Desk::move(double x, double y) {
  const double right = x - mouse_x_, down = y - mouse_y_;
  mouse_x_ = x, mouse_y_ = y, has_mouse_ = true;
  moved_ += std::hypot(right, down);
  const double left = 1.0 * pane_width() * static_cast<double>(pane_);
  if (grip_ == Grip::body) {
    for (const auto& pane : panes) pane->hand.move({eye_, x - left, y});
    return;
  }
  if (grip_ == Grip::none || (right == 0 && down == 0)) return;
  const Camera& camera = orbit_.camera();
  if (grip_ == Grip::turn)
    orbit_.turn(right, down);
  else
    orbit_.pan(right, down, eye_.pixel() * glm::distance(camera.eye, camera.target));
  if (grip_ == Grip::pan) followed = Entity{};
  look();
}

void Desk::wheel(double up, double across) {
  if (up != 0) orbit_.zoom(up);
  if (across != 0) orbit_.turn(kPixelsAcross * across, 0);
  look();
}

void Desk::look_under_mouse() {
  is_under = false;
  if (!has_mouse_ || grip_ == Grip::turn || grip_ == Grip::pan) return;
  const Place at = place(mouse_x_, mouse_y_);
  if (grip_ == Grip::none) pane_ = at.pane;
  const auto picked = pick(panes[at.pane]->scene(), at.pixel);
  if (!picked) return;
  is_under = true, under = picked->body;
}

void Desk::key(std::string_view name) {
  stale = true;
  if (name.size() == 1 && name[0] >= '1' && name[0] - '1' < std::ssize(kOfferedSolvers))
    return choose(kOfferedSolvers[static_cast<std::size_t>(name[0] - '1')], held_.shift ? 1 : 0);
  if (looks_key(name)) return;
  if (name == "m") toggle_posing();
  if (name == "k") wants_pose = true;
  if (name == "space" && is_posing())
    toggle_posing(), paused = false;
  else if (name == "space")
    paused = !paused;
  if (name == ".") single_step();
  if (name == "[") faster(0.5);
  if (name == "]") faster(2);
  if (name == "r") restart();
  if (name == "f5") reload();
  if (name == "page_up" || name == "page_down") leaf(name == "page_down" ? 1 : -1);
  if (name == "x") use(Tool::cut, mouse_x_, mouse_y_);
  if (name == "p") use(Tool::pin, mouse_x_, mouse_y_);
  if (name == "b") use(Tool::ball, mouse_x_, mouse_y_);
  if (name == "c") compare(panes.size() > 1 ? std::nullopt : std::optional<Solver>(another()));
  if (name == "g") measure_at(place(mouse_x_, mouse_y_));
  if (name == "n") plot_at(place(mouse_x_, mouse_y_));
  if (name == "j") next_at_end();
  if (name == "y" && held_.shift) restart(), paused = false;
  if (name == "y") wants_run = held_.shift ? RunWish::whole : RunWish::from_now;
  if (name == "u") wants_tuned = true;
  if (name == "s") wants_picture = true;
  if (name == "v") wants_film = true;
  if (name == "q" || name == "escape") quits = true;
  camera_key(name);
}

void Desk::next_at_end() {
  constexpr const char* kWords[] = {"goes on", "stops", "starts again"};
  choices_.at_end = static_cast<AtEnd>((static_cast<int>(choices_.at_end) + 1) % 3);
  tell(fmt::format("at {:.6g} s, the scene's duration, it {}", scene_.duration,
                   kWords[static_cast<std::size_t>(choices_.at_end)]));
}

/// Keys that change only the display.
bool Desk::looks_key(std::string_view name) {
  bool* const what = name == "o"     ? &overlay
                     : name == "f"   ? &forces
                     : name == "w"   ? &wireframe
                     : name == "h"   ? &help
                     : name == "a"   ? &states
                     : name == "tab" ? &panel
                                     : nullptr;
  if (!what) return false;
  *what = !*what;
  return true;
}

void Desk::camera_key(std::string_view name) {
  if (name == "home") return reset_camera();
  if (name == "l") return toggle_follow();
  const double side = held_.shift ? -1 : 1;
  if (name == "e") return look_from({0, 0, side});
  if (name == "d") return look_from({side, 0, 0});
  if (name == "t") return look_from({0, side, 0});
  if (name == "i") return look_from(glm::normalize(Vec3(1)));
  const double right = name == "left" ? -1 : name == "right" ? 1 : 0;
  const double down = name == "up" ? -1 : name == "down" ? 1 : 0;
  if (name == "+" || name == "-") orbit_.zoom(name == "+" ? 1 : -1);
  if (right != 0 || down != 0) {
    const Camera& camera = orbit_.camera();
    const Real metres = eye_.pixel() * glm::distance(camera.eye, camera.target);
    if (held_.shift)
      orbit_.pan(-kKeyTurn * right, -kKeyTurn * down, metres);
    else
      orbit_.turn(-kKeyTurn * right, -kKeyTurn * down);
  } else if (name != "+" && name != "-") {
    return;
  }
  look();
}

void Desk::use(Tool what, double x, double y) {
  const Place at = place(x, y);
  stale = true;
  if (what == Tool::cut) return cut(at);
  if (what == Tool::pin) return pin(at);
  if (what == Tool::ball) throw_ball(at);
}

void Desk::cut(const Place& at) {
  const Entity found = find_cut(panes[at.pane]->scene(), at.pixel);
  if (!found) return tell("nothing to cut under the mouse");
  const std::string name = panes[at.pane]->world().name_of(found);
  let_go();
  for (const auto& pane : panes) {
    if (pane->world().is_alive(found) && pane->world().name_of(found) == name)
      pane->world().destroy(found);
    pane->place();
  }
  tell("cut " + name);
}

void Desk::pin(const Place& at) {
  const auto picked = pick(panes[at.pane]->scene(), at.pixel);
  if (!picked) return tell("no body under the mouse to pin");
  const std::string name = panes[at.pane]->world().name_of(picked->body);
  std::optional<bool> is_pinned;
  for (const auto& pane : panes)
    if (pane->world().bodies.find(picked->body)) {
      is_pinned = toggle_pin(pane->world(), *picked);
      pane->place();
    }
  if (!is_pinned) return tell(name + " is not dynamic and cannot be pinned");
  tell((*is_pinned ? "pinned " : "released ") + name);
}

/// Adds the point under the mouse to the gauge; nothing there clears it.
void Desk::measure_at(const Place& at) {
  const auto picked = pick(panes[at.pane]->scene(), at.pixel);
  if (!picked && gauge.empty()) return tell("no body under the mouse to measure from");
  if (!picked) return gauge.clear();
  gauge.add({picked->body, picked->anchor});
  tell(gauge.words(panes[at.pane]->scene()));
}

/// Chooses the object under the mouse for the plots.
void Desk::plot_at(const Place& at) {
  const World& world = panes[at.pane]->world();
  const Entity found = find_object(panes[at.pane]->scene(), at.pixel);
  if (!found) return tell(fmt::format("no body at {:.0f}, {:.0f}", mouse_x_, mouse_y_));
  const std::string name = world.name_of(found);
  for (const auto& pane : panes) {
    const bool has = pane->world().is_alive(found) && pane->world().name_of(found) == name;
    pane->focus.choose(pane->world(), has ? found : Entity{}, how_.h);
  }
  std::string all;
  const Focus& focus = panes[at.pane]->focus;
  for (const Plotted& p : focus.quantities())
    all += (all.empty() ? "" : ", ") + short_name(focus, p);
  tell("plots " + name + ": " + all);
}

void Desk::throw_ball(const Place& at) {
  if (is_posing()) return tell("no ball in pose mode: m ends it");
  for (const auto& pane : panes) {
    if (auto ball = shoot(pane->world(), ray_through(at.pixel), gun); !ball)
      tell(ball.errors().front().message);
    pane->place();
  }
}

}  // namespace pantin::program
#endif
