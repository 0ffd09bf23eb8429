#include "engine/render/overlay.hpp"

#include <algorithm>

#include "engine/render/frame.hpp"

namespace pantin::detail {
namespace {

constexpr Vec3 kPanel{0.06, 0.07, 0.09}, kText{0.96, 0.97, 0.98}, kAlarm{1, 0.36, 0.3};

}  // namespace

void OverlayList::add_quad(const float (&corners)[4][2], const float (&locals)[4][2],
                           const float (&form)[4], const Paint& paint) {
  for (int i = 0; i < 4; ++i) {
    OverlayVertex v{};
    for (int k = 0; k < 2; ++k) v.pixel[k] = corners[i][k], v.local[k] = locals[i][k];
    for (int k = 0; k < 4; ++k) v.form[k] = form[k];
    for (int k = 0; k < 3; ++k) v.colour[k] = static_cast<float>(paint.colour[k]);
    v.colour[3] = static_cast<float>(paint.opacity);
    vertices_.push_back(v);
  }
}

void OverlayList::add_box(Vec3 middle, Vec3 half, Real radius, const Paint& paint) {
  const auto w = static_cast<float>(half.x), h = static_cast<float>(half.y);
  const auto x = static_cast<float>(middle.x), y = static_cast<float>(middle.y);
  const float locals[4][2] = {{-w - 1, -h - 1}, {w + 1, -h - 1}, {w + 1, h + 1}, {-w - 1, h + 1}};
  float corners[4][2];
  for (int i = 0; i < 4; ++i) corners[i][0] = x + locals[i][0], corners[i][1] = y + locals[i][1];
  add_quad(corners, locals, {w, h, static_cast<float>(radius), 1}, paint);
}

void OverlayList::add_line(Vec3 a, Vec3 b, Real width, const Paint& paint) {
  const Vec3 way{b.x - a.x, b.y - a.y, 0};
  const Real length = glm::length(way);
  const Vec3 u = length > 0 ? way / length : Vec3{1, 0, 0};
  const Real w = (length + width) / 2, h = width / 2;
  float corners[4][2], locals[4][2];
  const Real signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int i = 0; i < 4; ++i) {
    const Real s = signs[i][0] * (w + 1), t = signs[i][1] * (h + 1);
    corners[i][0] = static_cast<float>((a.x + b.x) / 2 + s * u.x - t * u.y);
    corners[i][1] = static_cast<float>((a.y + b.y) / 2 + s * u.y + t * u.x);
    locals[i][0] = static_cast<float>(s), locals[i][1] = static_cast<float>(t);
  }
  add_quad(corners, locals,
           {static_cast<float>(w), static_cast<float>(h), static_cast<float>(h), 1}, paint);
}

void OverlayList::add_triangle(Vec3 a, Vec3 b, Vec3 c, const Paint& paint) {
  const auto corner = [](Vec3 p, int k) { return static_cast<float>(p[k]); };
  const float corners[4][2] = {{corner(a, 0), corner(a, 1)},
                               {corner(b, 0), corner(b, 1)},
                               {corner(c, 0), corner(c, 1)},
                               {corner(c, 0), corner(c, 1)}};
  // An infinite box has no border, so that neighbours join without a seam.
  add_quad(corners, {{0, 0}, {0, 0}, {0, 0}, {0, 0}}, {1e4f, 1e4f, 0, 1}, paint);
}

void OverlayList::add_ring(Vec3 middle, Real radius, Real width, Vec3 colour) {
  constexpr int kSides = 20;
  for (int i = 0; i < kSides; ++i) {
    const auto on_ring = [&](int k) {
      const Real t = 2 * kPi * k / kSides;
      return middle + radius * Vec3{std::cos(t), std::sin(t), 0};
    };
    add_line(on_ring(i), on_ring(i + 1), width, colour);
  }
}

void OverlayList::add_text(Vec3 baseline, std::string_view utf8, Vec3 colour) {
  float pen = static_cast<float>(std::round(baseline.x));
  const float y = static_cast<float>(std::round(baseline.y));
  while (!utf8.empty()) {
    const Glyph& g = font_.glyph(take_letter(utf8));
    const float x0 = std::round(pen) + static_cast<float>(g.left);
    const float y0 = y - static_cast<float>(g.top);
    const auto w = static_cast<float>(g.width), h = static_cast<float>(g.height);
    const float u0 = static_cast<float>(g.x) / static_cast<float>(font_.atlas_width);
    const float v0 = static_cast<float>(g.y) / static_cast<float>(font_.atlas_height);
    const float u1 = u0 + w / static_cast<float>(font_.atlas_width);
    const float v1 = v0 + h / static_cast<float>(font_.atlas_height);
    if (g.width > 0)
      add_quad({{x0, y0}, {x0 + w, y0}, {x0 + w, y0 + h}, {x0, y0 + h}},
               {{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}}, {0, 0, 0, 0}, colour);
    pen += g.advance;
  }
}

namespace {

/// Wraps a text into lines of at most `room` pixels, at spaces if possible.
void add_wrapped(const Font& font, std::string_view text, float room,
                 std::vector<std::string_view>& to) {
  while (font.width(text) > room) {
    std::string_view rest = text;
    std::size_t fits = 0, space = 0;
    float width = 0;
    while (!rest.empty()) {
      const std::size_t before = text.size() - rest.size();
      const char32_t letter = take_letter(rest);
      width += font.glyph(letter).advance;
      if (width > room && before > 0) break;
      if (letter == U' ') space = before + 1;
      fits = text.size() - rest.size();
    }
    const std::size_t cut = space > 0 ? space : fits;
    to.push_back(text.substr(0, cut));
    text.remove_prefix(cut);
    if (text.empty()) return;
  }
  to.push_back(text);
}

}  // namespace

void OverlayList::add_labels(const Overlay& overlay, const Eye& eye) {
  const Real line = std::round(1.12 * font_.line_height), pad = std::round(0.55 * line);
  const Real edge = std::round(0.6 * line), swatch = std::round(0.62 * line);
  const auto panel = [&](Real top, Real widest, std::size_t lines) {
    const Vec3 half{widest / 2 + pad, static_cast<Real>(lines) * line / 2 + 0.8 * pad, 0};
    add_box({edge + half.x, top + half.y, 0}, half, 0.35 * line, {kPanel, 0.62});
    return top + 0.8 * pad + (line - font_.line_height) / 2 + font_.ascent;  // first baseline
  };
  std::vector<std::string_view> lines;
  const auto room = static_cast<float>(eye.width - 2 * (edge + pad));
  for (const std::string& text : overlay.lines) add_wrapped(font_, text, room, lines);
  const std::size_t calm = lines.size();
  if (!overlay.alarm.empty()) add_wrapped(font_, overlay.alarm, room, lines);
  Real widest = 0;
  for (std::string_view text : lines)
    widest = std::max(widest, static_cast<Real>(font_.width(text)));
  Real at = lines.empty() ? 0 : panel(edge, widest, lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i, at += line)
    add_text({edge + pad, at, 0}, lines[i], i < calm ? kText : kAlarm);
  if (overlay.legend.empty()) return;
  widest = 0;
  for (const LegendEntry& entry : overlay.legend)
    widest = std::max(widest, 1.6 * swatch + font_.width(entry.text));
  const Real height = static_cast<Real>(overlay.legend.size()) * line + 1.6 * pad;
  Real y = panel(eye.height - edge - height, widest, overlay.legend.size());
  for (const LegendEntry& entry : overlay.legend) {
    const Real middle = y - 0.36 * font_.ascent;
    add_box({edge + pad + swatch / 2, middle, 0}, {swatch / 2, swatch / 2, 0}, 0.2 * swatch,
            srgb(entry.colour));
    add_text({edge + pad + 1.6 * swatch, y, 0}, entry.text, kText);
    y += line;
  }
}

}  // namespace pantin::detail
