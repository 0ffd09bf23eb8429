#ifdef PANTIN_HAS_VIEW
#include "tools/pantin/view_panel.hpp"

#ifndef PANTIN_HAS_PANEL

namespace pantin::program {

bool has_panel() { return false; }
std::unique_ptr<Panel> Panel::make() { return nullptr; }

}  // namespace pantin::program

#else
#include <imgui.h>

#include <cstddef>
#include <filesystem>
#include <iterator>

#include "engine/render/font.hpp"
#include "tools/pantin/view_painter.hpp"
#include "tools/pantin/view_widgets.hpp"

namespace pantin::program {

using namespace detail;

namespace {

static_assert(sizeof(ImDrawVert) == sizeof(InkVertex) && sizeof(ImDrawIdx) == 2 &&
              offsetof(ImDrawVert, uv) == offsetof(InkVertex, u) &&
              offsetof(ImDrawVert, col) == offsetof(InkVertex, rgba));
static_assert(IM_COL32(1, 0, 0, 0) == 1);

constexpr float kLetters = 15;  // pixels
constexpr int kSettle = 3;      // pictures until the panel has processed an event

struct KeyRow {
  int panel;
  SDL_Scancode window;
};
/// For typing numbers into sliders.
constexpr KeyRow kEditing[]{{ImGuiKey_Tab, SDL_SCANCODE_TAB},
                            {ImGuiKey_LeftArrow, SDL_SCANCODE_LEFT},
                            {ImGuiKey_RightArrow, SDL_SCANCODE_RIGHT},
                            {ImGuiKey_UpArrow, SDL_SCANCODE_UP},
                            {ImGuiKey_DownArrow, SDL_SCANCODE_DOWN},
                            {ImGuiKey_Home, SDL_SCANCODE_HOME},
                            {ImGuiKey_End, SDL_SCANCODE_END},
                            {ImGuiKey_Delete, SDL_SCANCODE_DELETE},
                            {ImGuiKey_Backspace, SDL_SCANCODE_BACKSPACE},
                            {ImGuiKey_Enter, SDL_SCANCODE_RETURN},
                            {ImGuiKey_Escape, SDL_SCANCODE_ESCAPE},
                            {ImGuiKey_A, SDL_SCANCODE_A}};

class ImGuiPanel final : public Panel {
 public:
  ImGuiPanel();
  ~ImGuiPanel() override { ImGui::DestroyContext(context_); }
  ImGuiPanel(const ImGuiPanel&) = delete;
  ImGuiPanel& operator=(const ImGuiPanel&) = delete;

  bool feed(const SDL_Event& event, int left) override;
  bool is_busy() const override { return settling_ > 0; }
  void draw(Desk& desk, Image& window, int left, const PanelClock& clock) override;

 private:
  void load_letters();
  bool feed_key(const SDL_KeyboardEvent& event);
  void paint_over(Image& window) const;

  ImGuiContext* context_;
  InkAtlas atlas_;
  int settling_ = kSettle;
  bool has_grip_ = false;  // a button was pressed in the panel and is still held
  // A button that was pressed, and perhaps released, since the last picture: both must be reported.
  bool pressed_ = false, released_ = false;
};

ImGuiPanel::ImGuiPanel() : context_(ImGui::CreateContext()) {
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr, io.LogFilename = nullptr;
  io.BackendRendererName = "pantin";
  io.MousePos = {-1e6f, -1e6f};
#if IMGUI_VERSION_NUM < 18700
  for (const KeyRow& row : kEditing) io.KeyMap[row.panel] = row.window;
#endif
  load_letters();
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0, style.FrameRounding = 3, style.WindowBorderSize = 0;
  style.ItemSpacing = {6, 4}, style.WindowPadding = {10, 8};
  style.AntiAliasedLinesUseTex = false;
  style.Colors[ImGuiCol_WindowBg] = {0.11f, 0.12f, 0.14f, 1};
}

void ImGuiPanel::load_letters() {
  ImGuiIO& io = ImGui::GetIO();
  ImFontConfig how;
  how.OversampleH = 1, how.OversampleV = 1, how.PixelSnapH = true;  // as they are painted
  std::error_code trouble;
  bool found = false;
  for (const char* file : usual_fonts())
    if (!found && std::filesystem::exists(file, trouble))
      found = io.Fonts->AddFontFromFileTTF(file, kLetters, &how) != nullptr;
  if (!found) io.Fonts->AddFontDefault();
  unsigned char* coverage = nullptr;
  io.Fonts->GetTexDataAsAlpha8(&coverage, &atlas_.width, &atlas_.height);
  atlas_.coverage = coverage;
  io.Fonts->SetTexID(reinterpret_cast<ImTextureID>(&atlas_));
}

bool ImGuiPanel::feed_key(const SDL_KeyboardEvent& e) {
  ImGuiIO& io = ImGui::GetIO();
  const bool down = e.type == SDL_KEYDOWN;
  const SDL_Keymod held = SDL_GetModState();
  io.KeyCtrl = (held & KMOD_CTRL) != 0, io.KeyShift = (held & KMOD_SHIFT) != 0;
#if IMGUI_VERSION_NUM < 18700
  io.KeysDown[e.keysym.scancode] = down && io.WantTextInput;
#else
  for (const KeyRow& row : kEditing)
    if (row.window == e.keysym.scancode) io.AddKeyEvent(static_cast<ImGuiKey>(row.panel), down);
  io.AddKeyEvent(ImGuiMod_Ctrl, io.KeyCtrl);
#endif
  return io.WantTextInput;
}

bool ImGuiPanel::feed(const SDL_Event& e, int left) {
  ImGuiIO& io = ImGui::GetIO();
  const auto at = [&](int x, int y) {
    io.MousePos = {static_cast<float>(x), static_cast<float>(y)};
    return x >= left;
  };
  settling_ = kSettle;
  switch (e.type) {
    case SDL_MOUSEMOTION:
      return at(e.motion.x, e.motion.y) || has_grip_;
    case SDL_MOUSEBUTTONDOWN:
      if (!at(e.button.x, e.button.y)) return false;
      if (e.button.button == SDL_BUTTON_LEFT) has_grip_ = pressed_ = true;
      return true;
    case SDL_MOUSEBUTTONUP:
      at(e.button.x, e.button.y);
      if (e.button.button != SDL_BUTTON_LEFT || !has_grip_) return false;
      has_grip_ = false, released_ = true;
      return true;
    case SDL_MOUSEWHEEL:
      if (io.MousePos.x < static_cast<float>(left)) return false;
      io.MouseWheel += e.wheel.preciseY;
      return true;
    case SDL_TEXTINPUT:
      io.AddInputCharactersUTF8(e.text.text);
      return io.WantTextInput;
    case SDL_KEYDOWN:
    case SDL_KEYUP:
      return feed_key(e.key);
    default:
      return false;
  }
}

void ImGuiPanel::draw(Desk& desk, Image& window, int left, const PanelClock& clock) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(window.width), static_cast<float>(window.height)};
  io.DeltaTime = static_cast<float>(clock.passed);
  io.MouseDown[0] = has_grip_ || pressed_;
  ImGui::NewFrame();
  ImGui::SetNextWindowPos({static_cast<float>(left), 0});
  ImGui::SetNextWindowSize({static_cast<float>(window.width - left), io.DisplaySize.y});
  constexpr ImGuiWindowFlags kStill = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;
  ImGui::Begin("panel", nullptr, kStill);
  lay_out(desk, clock);
  ImGui::End();
  ImGui::Render();
  paint_over(window);
  if (released_ || pressed_) settling_ = kSettle;
  pressed_ = released_ = false;
  if (settling_ > 0) --settling_;
}

void ImGuiPanel::paint_over(Image& window) const {
  const ImDrawData* data = ImGui::GetDrawData();
  for (int i = 0; i < data->CmdListsCount; ++i) {
    const ImDrawList& list = *data->CmdLists[i];
    const auto* vertices = reinterpret_cast<const InkVertex*>(list.VtxBuffer.Data);
    const auto count = static_cast<std::size_t>(list.VtxBuffer.Size);
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.UserCallback) continue;
      const ImVec4& clip = command.ClipRect;
      paint(window,
            {{vertices + command.VtxOffset, count - command.VtxOffset},
             {list.IdxBuffer.Data + command.IdxOffset, command.ElemCount},
             {clip.x, clip.y, clip.z, clip.w}},
            atlas_);
    }
  }
}

}  // namespace

bool has_panel() { return true; }
std::unique_ptr<Panel> Panel::make() { return std::make_unique<ImGuiPanel>(); }

}  // namespace pantin::program
#endif
#endif
