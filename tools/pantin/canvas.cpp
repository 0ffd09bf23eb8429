#include "tools/pantin/canvas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#ifdef PANTIN_HAS_RENDER
#include "engine/render/font.hpp"
#include "engine/render/png.hpp"
#endif

namespace pantin::program {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

class SvgCanvas final : public Canvas {
 public:
  SvgCanvas(int width, int height)
      : text_(fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
                          "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"{2}\">\n"
                          "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
                          width, height, kLetter)) {}

  void box(Spot corner, Spot size, Ink ink) override {
    text_ += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
        "fill=\"{}\"/>\n",
        corner.x, corner.y, size.x, size.y, hex(ink));
  }
  void line(Spot from, Spot to, double width, Ink ink) override {
    text_ += fmt::format(
        "<path d=\"M{:.2f} {:.2f}L{:.2f} {:.2f}\" stroke=\"{}\" "
        "stroke-width=\"{:g}\" stroke-linecap=\"round\"/>\n",
        from.x, from.y, to.x, to.y, hex(ink), width);
  }
  void text(Spot at, std::string_view utf8, Ink ink, Anchor anchor) override {
    constexpr const char* kAnchors[] = {"start", "middle", "end"};
    text_ += fmt::format(
        "<text x=\"{:.2f}\" y=\"{:.2f}\" fill=\"{}\" text-anchor=\"{}\">{}"
        "</text>\n",
        at.x, at.y, hex(ink), kAnchors[static_cast<int>(anchor)], escaped(utf8));
  }
  std::string bytes() override { return text_ + "</svg>\n"; }

 private:
  static std::string hex(Ink i) {
    return fmt::format("#{:02x}{:02x}{:02x}", i.red, i.green, i.blue);
  }
  std::string text_;
};

#ifdef PANTIN_HAS_RENDER
class PixelCanvas final : public Canvas {
 public:
  PixelCanvas(int width, int height)
      : image_{width, height, std::vector<std::uint8_t>(std::size_t(width) * height * 4, 255)},
        font_(detail::load_font(detail::usual_fonts(), kLetter)) {}

  void box(Spot corner, Spot size, Ink ink) override {
    const auto edge = [](double x) { return static_cast<int>(std::lround(x)); };
    for (int y = edge(corner.y); y < edge(corner.y + size.y); ++y)
      for (int x = edge(corner.x); x < edge(corner.x + size.x); ++x) blend(x, y, ink, 1);
  }
  void line(Spot a, Spot b, double width, Ink ink) override {
    const double far = width / 2 + 1, dx = b.x - a.x, dy = b.y - a.y, l2 = dx * dx + dy * dy;
    const auto low = [&](double u, double v) { return static_cast<int>(std::min(u, v) - far); };
    const auto high = [&](double u, double v) { return static_cast<int>(std::max(u, v) + far); };
    for (int y = low(a.y, b.y); y <= high(a.y, b.y); ++y)
      for (int x = low(a.x, b.x); x <= high(a.x, b.x); ++x) {
        const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
        const double t = l2 > 0 ? std::clamp((px * dx + py * dy) / l2, 0.0, 1.0) : 0;
        const double away = std::hypot(px - t * dx, py - t * dy);
        blend(x, y, ink, std::clamp(width / 2 + 0.5 - away, 0.0, 1.0));
      }
  }
  void text(Spot at, std::string_view utf8, Ink ink, Anchor anchor) override {
    double pen = at.x - font_.width(utf8) * (anchor == Anchor::start    ? 0
                                             : anchor == Anchor::middle ? 0.5
                                                                        : 1);
    while (!utf8.empty()) {
      const detail::Glyph& g = font_.glyph(detail::take_letter(utf8));
      for (int y = 0; y < g.height; ++y)
        for (int x = 0; x < g.width; ++x) {
          const std::size_t from = std::size_t(g.y + y) * font_.atlas_width + g.x + x;
          blend(static_cast<int>(std::lround(pen)) + g.left + x,
                static_cast<int>(std::lround(at.y)) - g.top + y, ink, font_.atlas[from] / 255.0);
        }
      pen += g.advance;
    }
  }
  std::string bytes() override {
    detail::PngEncoder encoder;
    return std::string(detail::as_text(encoder.encode(image_)));
  }

 private:
  void blend(int x, int y, Ink ink, double part) {
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
    std::uint8_t* p = &image_.rgba[(std::size_t(y) * image_.width + x) * 4];
    const int to[] = {ink.red, ink.green, ink.blue};
    for (int k = 0; k < 3; ++k)
      p[k] = static_cast<std::uint8_t>(std::lround(p[k] + part * (to[k] - p[k])));
  }
  Image image_;
  detail::Font font_;
};
#endif

/// A round distance between ticks, for about five of them.
double tick_of(double span) {
  const double rough = span / 5, ten = std::pow(10, std::floor(std::log10(rough)));
  for (const double k : {1.0, 2.0, 5.0})
    if (k * ten >= rough * 0.999) return k * ten;
  return 10 * ten;
}

}  // namespace

std::unique_ptr<Canvas> make_canvas(const std::string& path, int width, int height) {
  if (path.ends_with(".svg")) return std::make_unique<SvgCanvas>(width, height);
#ifdef PANTIN_HAS_RENDER
  return std::make_unique<PixelCanvas>(width, height);
#else
  return nullptr;
#endif
}

Ink ink_of(std::size_t k) {
  constexpr std::array<Ink, 8> kInks{{{31, 90, 180},
                                      {215, 95, 0},
                                      {0, 125, 90},
                                      {190, 40, 60},
                                      {120, 70, 170},
                                      {120, 85, 50},
                                      {200, 70, 150},
                                      {60, 60, 60}}};
  return kInks[k % kInks.size()];
}

Spot Frame::at(double x, double y) const {
  return {corner.x + (x - across.low) / (across.high - across.low) * size.x,
          corner.y + size.y - (y - up.low) / (up.high - up.low) * size.y};
}

bool Frame::holds(double x, double y) const {
  return x >= across.low && x <= across.high && y >= up.low && y <= up.high;
}

void Frame::draw(Canvas& canvas, std::string_view title) const {
  const Spot low{corner.x, corner.y + size.y}, high{corner.x + size.x, corner.y};
  canvas.line(low, {high.x, low.y}, 1, {}), canvas.line(low, {low.x, high.y}, 1, {});
  canvas.line({low.x, high.y}, high, 1, {}), canvas.line({high.x, low.y}, high, 1, {});
  const auto ticks = [](const Axis& axis, auto&& draw) {
    const double step = tick_of(axis.high - axis.low);
    for (double t = std::ceil(axis.low / step - 1e-9) * step; t <= axis.high + 1e-9 * step;
         t += step)
      draw(std::abs(t) < 1e-9 * step ? 0.0 : t);
  };
  ticks(across, [&](double t) {
    const double x = at(t, up.low).x;
    canvas.line({x, low.y}, {x, low.y + 4}, 1, {});
    canvas.text({x, low.y + 18}, fmt::format("{:.4g}", t), {}, Anchor::middle);
  });
  ticks(up, [&](double t) {
    const double y = at(across.low, t).y;
    canvas.line({low.x - 4, y}, {low.x, y}, 1, {});
    canvas.text({low.x - 8, y + 4}, fmt::format("{:.4g}", t), {}, Anchor::end);
  });
  canvas.text({corner.x + size.x / 2, low.y + 38}, across.name, {}, Anchor::middle);
  canvas.text({corner.x - 40, corner.y - 10}, up.name, {}, Anchor::start);
  canvas.text({corner.x + size.x / 2, corner.y - 26}, title, {}, Anchor::middle);
}

}  // namespace pantin::program
