#include "tools/pantin/view_script.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "engine/scene/read/reader.hpp"
#include "tools/pantin/view_desk.hpp"

namespace pantin::program {

using namespace detail;

namespace {

using namespace rows;

constexpr std::string_view kActs[]{"mouse_down", "mouse_move", "mouse_up", "wheel", "key",
                                   "knob",       "open",       "resize",   "quit"};

constexpr std::size_t kMostBytes = 16u << 20;
constexpr Range kSide{16, 8192, "a number of pixels from 16 to 8192"};
constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();  // it could not be read
constexpr Range kTimes{0, 86400, "a time from 0 to 86400 s"};
constexpr Range kPixel{-16384, 16384, "a number of pixels from -16384 to 16384"};
constexpr Range kClicks{-100, 100, "a number of clicks from -100 to 100"};

constexpr Key kT = number("t", "s", kTimes, "When.").needed("the time of the event in seconds");
constexpr Key kType = word("type", kActs, "The kind of event.");
constexpr Key kX = number("x", "pixels", kPixel, "From the left.").expecting("x and y in pixels");
constexpr Key kY = number("y", "pixels", kPixel, "From the top.").expecting("x and y in pixels");
constexpr Key kBody = reference("body", "the name of a body", "At this body.");
constexpr Key kAt = vector("at", "m", "In its own frame. Default: its mass centre.").or_else(0);
constexpr Key kButton = word("button", kButtons, "Of the mouse.").or_else(0);
constexpr Key kDown[]{kT,
                      kType,
                      kX,
                      kY,
                      kBody,
                      kAt,
                      kButton,
                      flag("shift", "Held down.").or_else(false),
                      flag("alt", "Held down.").or_else(false)};
constexpr Key kMove[]{kT,
                      kType,
                      kX,
                      kY,
                      number("dx", "pixels", kPixel, "To the right."),
                      number("dy", "pixels", kPixel, "Downwards."),
                      kBody,
                      kAt};
constexpr Key kUp[]{kT, kType, kX, kY, kBody, kAt, kButton};
constexpr Key kWheel[]{kT, kType, number("dx", "clicks", kClicks, "Sideways.").or_else(0),
                       number("dy", "clicks", kClicks, "Upwards positive.")
                           .needed("the clicks of the wheel, upwards positive")};
constexpr Key kKey[]{kT, kType, word("key", kKeys, "Of the keyboard."),
                     flag("shift", "Held down.").or_else(false)};
constexpr Key kKnob[]{kT, kType,
                      text("name", "Of a knob of the panel.").needed("the name of a knob"),
                      number("to", "", kAnyNumber, "Its number.").needed("a number")};
constexpr Key kOpen[]{kT, kType, text("scene", "A scene file.").needed("the name of a file")};
constexpr Key kResize[]{kT, kType,
                        number("width", "pixels", kSide, "Of the window.").needed("a width"),
                        number("height", "pixels", kSide, "Of the window.").needed("a height")};
constexpr Key kQuit[]{kT, kType};
constexpr KeySet kSets[]{
    {"mouse_down event", "", kDown}, {"mouse_move event", "", kMove}, {"mouse_up event", "", kUp},
    {"wheel event", "", kWheel},     {"key event", "", kKey},         {"knob event", "", kKnob},
    {"open event", "", kOpen},       {"resize event", "", kResize},   {"quit event", "", kQuit}};

std::string find_body(const Reader& r, NodeId value, const World& world) {
  std::vector<std::string_view> names;
  const std::string_view word = r.json[value].text;
  const bool is_text = r.json[value].kind == JsonKind::string;
  for (Entity e : world.bodies.owners()) {
    const std::string* name = world.names.find(e);
    if (!name) continue;
    if (is_text && *name == word) return *name;
    names.push_back(*name);
  }
  r.diagnostics.error_value(value,
                            "the name of a body" + (is_text ? hint(word, names) : std::string()));
  return {};
}

void read_body_spot(const Reader& r, const World& world, ScriptEvent& event) {
  event.spot = Spot::body;
  event.name = find_body(r, r.find("body"), world);
  event.is_centre = !r.has("at");
  event.at = r.vec("at");
}

/// The position of a mouse event, in one of its forms, or none.
void read_spot(const Reader& r, const World& world, ScriptEvent& event) {
  const bool pixel = r.has("x") || r.has("y");
  const bool shift = event.act == Act::mouse_move && (r.has("dx") || r.has("dy"));
  const bool body = r.has("body");
  if (pixel + shift + body > 1) {
    r.diagnostics.error(r.node, "found more than one place, expected one of x and y, body" +
                                    std::string(shift ? ", dx and dy" : ""));
    return;
  }
  if (r.has("at") && !body)
    r.diagnostics.error(r.node, "found \"at\" alone, expected \"body\" beside it");
  if (body) return read_body_spot(r, world, event);
  if (pixel) {
    event.spot = Spot::pixel;
    r.need("x"), r.need("y");
    event.x = r.number("x", 0), event.y = r.number("y", 0);
  } else if (shift) {
    event.spot = Spot::shift;
    event.x = r.number("dx", 0), event.y = r.number("dy", 0);
  } else if (event.act == Act::mouse_move) {
    r.diagnostics.error(r.node, "found no place, expected x and y, dx and dy, or body");
  }
}

ScriptEvent read_event(const JsonDocument& json, Diagnostics& diagnostics, NodeId node,
                       const World& world) {
  ScriptEvent event;
  event.time = kNoTime;
  const NodeId type = json[node].kind == JsonKind::object ? json.member(node, "type") : kNoNode;
  if (type == kNoNode) {
    diagnostics.error(node, "found " + described(json, node) +
                                ", expected an event with a \"type\": " + listed(kActs));
    return event;
  }
  std::size_t act = 0;
  while (act < std::size(kActs) &&
         !(json[type].kind == JsonKind::string && json[type].text == kActs[act]))
    ++act;
  if (act == std::size(kActs)) {
    diagnostics.error_value(
        type,
        listed(kActs) + (json[type].kind == JsonKind::string ? hint(json[type].text, kActs) : ""));
    return event;
  }
  event.act = static_cast<Act>(act);
  const Reader r(json, diagnostics, node, kSets[act]);
  event.time = r.number("t", kNoTime);
  if (act <= static_cast<std::size_t>(Act::mouse_up)) read_spot(r, world, event);
  if (r.accepts("button")) event.button = static_cast<int>(r.word("button"));
  if (r.accepts("alt")) event.alt = r.flag("alt");
  if (r.accepts("shift")) event.shift = r.flag("shift");
  if (event.act == Act::wheel) event.x = r.number("dx", 0), event.y = r.number("dy", 0);
  if (event.act == Act::knob) event.name = r.text("name", ""), event.x = r.number("to", 0);
  if (event.act == Act::open) event.name = r.text("scene", "");
  if (event.act == Act::resize) event.x = r.number("width", 16), event.y = r.number("height", 16);
  if (event.act == Act::key) {
    if (!r.has("key"))
      r.diagnostics.error(node, "found no \"key\", expected one of " + listed(kKeys));
    event.key = r.word("key", 0);
  }
  return event;
}

Result<std::string> read_whole(const std::string& path) {
  std::error_code trouble;
  if (std::filesystem::is_directory(path, trouble))
    return Error{path + ": found a directory, expected a script of events"};
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return Error{path + ": found no file to read (" + std::strerror(errno ? errno : EIO) +
                 "), expected a script of events"};
  std::string text(kMostBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMostBytes)
    return Error{path + ": found more than " + std::to_string(kMostBytes) +
                 " bytes, expected a script of events"};
  return text;
}

}  // namespace

Result<std::vector<ScriptEvent>> load_script(const std::string& path, const World& world) {
  const Result<std::string> text = read_whole(path);
  if (!text) return text.errors();
  const JsonDocument json = parse_json(*text);
  Diagnostics diagnostics(json, path);
  std::vector<ScriptEvent> events;
  for (const JsonFault& fault : json.faults)
    if (fault.node == kNoNode) return diagnostics.errors();  // the document is incomplete
  if (json[0].kind != JsonKind::array) {
    if (!diagnostics.any_errors()) diagnostics.error_value(0, "an array of events");
    return diagnostics.errors();
  }
  for (NodeId item = json[0].first_child; item != kNoNode; item = json[item].next) {
    events.push_back(read_event(json, diagnostics, item, world));
    if (std::isnan(events.back().time)) {
      events.pop_back();
      continue;
    }
    const double before = events.size() > 1 ? events[events.size() - 2].time : 0;
    if (events.back().time < before)
      diagnostics.error(item, "found t " + written(events.back().time) + ", expected " +
                                  written(before) + " or later: events stand in order of time");
  }
  if (diagnostics.any_errors()) return diagnostics.errors();
  return events;
}

}  // namespace pantin::program
