// Events of the window, and simulated events of a script.
#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <cmath>

#include "engine/scene/json/words.hpp"
#include "tools/pantin/program.hpp"
#include "tools/pantin/view_session.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr SDL_Keycode kKeyCodes[]{SDLK_SPACE, SDLK_PERIOD, SDLK_LEFTBRACKET, SDLK_RIGHTBRACKET,
                                  SDLK_1,     SDLK_2,      SDLK_3,           SDLK_4,
                                  SDLK_5,     SDLK_o,      SDLK_r,           SDLK_s,
                                  SDLK_h,     SDLK_q,      SDLK_w,           SDLK_f,
                                  SDLK_l,     SDLK_x,      SDLK_p,           SDLK_b,
                                  SDLK_c,     SDLK_v,      SDLK_TAB,         SDLK_F5,
                                  SDLK_HOME,  SDLK_LEFT,   SDLK_RIGHT,       SDLK_UP,
                                  SDLK_DOWN,  SDLK_PAGEUP, SDLK_PAGEDOWN,    SDLK_PLUS,
                                  SDLK_MINUS, SDLK_ESCAPE, SDLK_m,           SDLK_k,
                                  SDLK_a,     SDLK_d,      SDLK_e,           SDLK_g,
                                  SDLK_i,     SDLK_j,      SDLK_t,           SDLK_u,
                                  SDLK_n,     SDLK_y};
static_assert(std::size(kKeyCodes) == std::size(kKeys));
constexpr std::uint8_t kButtonCodes[]{SDL_BUTTON_LEFT, SDL_BUTTON_MIDDLE, SDL_BUTTON_RIGHT};
static_assert(std::size(kButtonCodes) == std::size(kButtons));

/// Maps equivalent keys: keypads, and a plus as shifted equals sign.
SDL_Keycode usual(SDL_Keycode key) {
  if (key == SDLK_KP_PLUS || key == SDLK_EQUALS) return SDLK_PLUS;
  return key == SDLK_KP_MINUS ? SDLK_MINUS : key;
}

/// Keys that repeat while held down.
bool repeats(std::string_view name) {
  for (const char* one : {".", "left", "right", "up", "down", "+", "-"})
    if (name == one) return true;
  return false;
}

KeysHeld keys_held() {
  const SDL_Keymod held = SDL_GetModState();
  return {(held & KMOD_SHIFT) != 0, (held & KMOD_ALT) != 0};
}

Entity body_of(const World& world, const std::string& name) {
  for (Entity e : world.bodies.owners())
    if (world.name_of(e) == name) return e;
  return {};
}

}  // namespace

void Session::handle_all() {
  for (SDL_Event e; SDL_PollEvent(&e) != 0;) handle(e);
}

void Session::handle(const SDL_Event& e) {
  if (panel_ && desk_.width() < width_ && panel_->feed(e, desk_.width())) {
    if (e.type == SDL_MOUSEMOTION) desk_.leave();
    return;
  }
  desk_.hold(keys_held());
  switch (e.type) {
    case SDL_QUIT:
      desk_.quits = true;
      break;
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP:
      button(e.button);
      break;
    case SDL_MOUSEMOTION:
      desk_.move(e.motion.x, e.motion.y);
      break;
    case SDL_MOUSEWHEEL:
      desk_.wheel(static_cast<double>(e.wheel.preciseY), static_cast<double>(e.wheel.preciseX));
      break;
    case SDL_KEYDOWN: {
      const SDL_Keycode code = usual(e.key.keysym.sym);
      for (std::size_t i = 0; i < std::size(kKeys); ++i)
        if (code == kKeyCodes[i] && (!e.key.repeat || repeats(kKeys[i]))) desk_.key(kKeys[i]);
      break;
    }
    case SDL_WINDOWEVENT:
      if (e.window.event == SDL_WINDOWEVENT_LEAVE) desk_.leave();
      desk_.stale = true;
      break;
    default:
      break;
  }
}

void Session::button(const SDL_MouseButtonEvent& e) {
  for (std::size_t i = 0; i < std::size(kButtonCodes); ++i) {
    if (e.button != kButtonCodes[i]) continue;
    const auto which = static_cast<MouseButton>(i);
    if (e.type == SDL_MOUSEBUTTONDOWN)
      desk_.press(which, e.x, e.y);
    else
      desk_.release(which, e.x, e.y);
  }
}

void Session::move_script_mouse(const ScriptEvent& event) {
  if (event.spot == Spot::pixel) script_x_ = event.x, script_y_ = event.y;
  if (event.spot == Spot::shift) script_x_ += event.x, script_y_ += event.y;
  if (event.spot != Spot::body) return;
  const Pane& pane = *desk_.panes[0];
  const Entity body = body_of(pane.world(), event.name);
  if (!body) return desk_.tell("no body is called " + event.name + " any more");
  const Pose& pose = pane.scene().pose_of(pane.world().bodies.slot(body));
  const Pose* origin = pane.world().origins.find(body);
  Vec3 local(0);
  if (!event.is_centre) local = origin ? to_world(*origin, event.at) : event.at;
  const Vec3 at = desk_.eye().project(to_world(pose, local));
  script_x_ = std::floor(at.x), script_y_ = std::floor(at.y);
}

/// Events that no single user action produces are carried out directly.
void Session::play(const ScriptEvent& event) {
  if (event.act == Act::knob && !desk_.turn(event.name, event.x)) {
    const std::vector<Knob> knobs = desk_.knobs();
    std::vector<std::string_view> names;
    for (const Knob& knob : knobs) names.push_back(knob.name);
    desk_.tell("there is no knob " + event.name + hint(event.name, names));
  }
  if (event.act == Act::open) desk_.open(event.name);
  if (event.act == Act::resize)
    window_->resize(static_cast<int>(std::lround(event.x)), static_cast<int>(std::lround(event.y)));
  if (event.act != Act::knob && event.act != Act::open && event.act != Act::resize) push(event);
}

/// Puts an event into SDL's queue, as user input would be.
void Session::push(const ScriptEvent& event) {
  if (event.act <= Act::mouse_up) move_script_mouse(event);
  const int x = static_cast<int>(std::lround(script_x_));
  const int y = static_cast<int>(std::lround(script_y_));
  SDL_Event e{};
  const auto send = [&e] {
    if (SDL_PushEvent(&e) < 0) complain(std::string("SDL took no event: ") + SDL_GetError());
  };
  const int held = (event.shift ? KMOD_LSHIFT : 0) | (event.alt ? KMOD_LALT : 0);
  if (event.act == Act::mouse_down || event.act == Act::key)
    SDL_SetModState(static_cast<SDL_Keymod>(held));
  switch (event.act) {
    case Act::mouse_down:
    case Act::mouse_up:
      e.button.type = event.act == Act::mouse_down ? SDL_MOUSEBUTTONDOWN : SDL_MOUSEBUTTONUP;
      e.button.state = event.act == Act::mouse_down ? SDL_PRESSED : SDL_RELEASED;
      e.button.windowID = window_->id(), e.button.button = kButtonCodes[event.button];
      e.button.clicks = 1, e.button.x = x, e.button.y = y;
      break;
    case Act::mouse_move:
      e.motion.type = SDL_MOUSEMOTION, e.motion.windowID = window_->id();
      e.motion.x = x, e.motion.y = y;
      break;
    case Act::wheel:
      e.wheel.type = SDL_MOUSEWHEEL, e.wheel.windowID = window_->id();
      e.wheel.preciseX = static_cast<float>(event.x),
      e.wheel.preciseY = static_cast<float>(event.y);
      e.wheel.x = static_cast<int>(std::lround(event.x));
      e.wheel.y = static_cast<int>(std::lround(event.y));
      break;
    case Act::key:
      e.key.type = SDL_KEYDOWN, e.key.windowID = window_->id(), e.key.state = SDL_PRESSED;
      e.key.keysym.sym = kKeyCodes[event.key];
      send();
      e.key.type = SDL_KEYUP, e.key.state = SDL_RELEASED;
      break;
    default:
      e.type = SDL_QUIT;
      break;
  }
  send();
}

}  // namespace pantin::program
#endif
