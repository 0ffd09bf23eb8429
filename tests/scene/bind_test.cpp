// Rows that are bound to members: what a reader makes of them, and what the schema says.
#include "engine/scene/read/bind.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/scene/keys/schema.hpp"
#include "engine/scene/read/read.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

using namespace rows;

enum class Mood : std::uint8_t { calm, wild };
struct Shade {
  Real width = 0.25;
};
struct Lamp {
  std::string name, room;
  std::optional<std::string> beside;
  Real bright = 2, angle = 0.5, most = 1e300;
  std::optional<Real> length;
  int bulbs = 3;
  bool on = true;
  Mood mood = Mood::wild;
  Vec3 way{0, -1, 0}, place{0};
  Shade shade;
  int doubled = 0;
};

bool read_double(const RowValue& row, Lamp& lamp) {
  lamp.doubled = 2 * row.from.whole(row.key.name, 0);
  return true;
}

constexpr std::string_view kMoods[] = {"calm", "wild"};
constexpr Key kLamp[] = {
    needed_name<&Lamp::name>(),
    needed_reference<&Lamp::room>("room", "the name of a room", "Where it is."),
    reference<&Lamp::beside>("beside", "the name of a thing", "What it stands by."),
    number<&Lamp::bright>("bright", "W", kPositive, "How bright."),
    number<&Lamp::angle>("angle_deg", "degrees", kDegrees, "How far it leans."),
    number<&Lamp::most>("most", "W", kNotNegative, "At most. Default: any."),
    number<&Lamp::length>("length", "m", kSize, "Of its cord. Default: as needed."),
    whole<&Lamp::bulbs>("bulbs", 1, 9, "How many."),
    flag<&Lamp::on>("on", "Whether it shines."),
    word<&Lamp::mood>("mood", kMoods, "How it flickers."),
    direction<&Lamp::way>("way", "Where it shines to."),
    vector<&Lamp::place>("place", "m", "Default: anywhere.").without_default(),
    number<&Lamp::shade, &Shade::width>("width", "m", kSize, "Of its shade."),
    whole<read_double>("pairs", 0, 9, "Of bulbs.").or_else(0),
    number<&Shade::width>("other", "m", kSize, "A row of another struct."),
    number("unbound", "", kUnit, "Read by code."),
};
constexpr KeySet kLampSet{"lamp", "A lamp.", kLamp};

/// Reads a lamp; `lines` are the complaints.
struct ReadLamp {
  explicit ReadLamp(const std::string& text) {
    const SceneLimits limits;
    SceneFiles files(limits);
    SceneFile& file = files.open("lamp.json", text);
    REQUIRE(file.is_json());
    JsonPlaces places(files);
    Recipe recipe;
    SceneReading whole{recipe, files, places, limits, Poll(limits.is_cancelled)};
    const Reading reading = reading_of(whole, file);
    const Reader from(file.json, file.diagnostics, 0, kLampSet);
    is_whole = read_rows(reading, from, lamp);
    for (const Error& e : file.diagnostics.errors()) lines.push_back(e.message);
  }
  Lamp lamp;
  bool is_whole = false;
  std::vector<std::string> lines;
};

}  // namespace

TEST_CASE("Values go where their rows are bound to, whatever the type of the member") {
  const ReadLamp read(R"({"name": "l", "room": "hall", "beside": "bed", "bright": 5, "most": 7,
"angle_deg": 90, "length": 2, "bulbs": 4, "on": false, "mood": "calm", "way": [0, 0, 2],
"place": [1, 2, 3], "width": 0.5, "pairs": 3, "other": 9, "unbound": 1})");
  CHECK(read.lines.empty());
  CHECK(read.is_whole);
  const Lamp& lamp = read.lamp;
  CHECK((lamp.name == "l" && lamp.room == "hall" && lamp.beside == "bed"));
  CHECK((lamp.bright == 5 && lamp.most == 7 && lamp.angle == 90 * (kPi / 180)));
  CHECK((lamp.length == 2 && lamp.bulbs == 4 && !lamp.on && lamp.mood == Mood::calm));
  CHECK((lamp.way == Vec3(0, 0, 1) && lamp.place == Vec3(1, 2, 3)));
  CHECK((lamp.shade.width == 0.5 && lamp.doubled == 6));
}

TEST_CASE("What is absent or wrong leaves its member as it is") {
  const ReadLamp read(R"({"name": "l", "room": 1, "bright": 0, "bulbs": 10, "mood": "sad",
"angle_deg": "x"})");
  CHECK_FALSE(read.is_whole);  // it needs a room
  CHECK(read.lines ==
        std::vector<std::string>{
            "lamp.json:1:23: /room: found 1, expected the name of a room",
            "lamp.json:1:36: /bright: found 0, expected a number above 0, at most 1e12",
            "lamp.json:1:48: /bulbs: found 10, expected a whole number from 1 to 9",
            "lamp.json:1:60: /mood: found \"sad\", expected calm or wild",
            "lamp.json:2:14: /angle_deg: found \"x\", expected an angle in degrees, between -1e6 "
            "and 1e6"});
  const Lamp &lamp = read.lamp, fresh;
  CHECK((lamp.bright == fresh.bright && lamp.angle == fresh.angle && lamp.bulbs == fresh.bulbs));
  CHECK((lamp.mood == fresh.mood && lamp.way == fresh.way && lamp.most == fresh.most));
  CHECK((!lamp.length && !lamp.beside && lamp.on && lamp.room.empty()));
}

TEST_CASE("What a member is at first is the default in the schema, where it may be told") {
  const nlohmann::json schema = nlohmann::json::parse(schema_of(kLampSet))["properties"];
  CHECK(schema["bright"]["default"] == 2);
  CHECK(schema["bulbs"]["default"] == 3);
  CHECK(schema["on"]["default"] == true);
  CHECK(schema["mood"]["default"] == "wild");
  CHECK(schema["way"]["default"] == nlohmann::json::array({0, -1, 0}));
  CHECK(schema["width"]["default"] == 0.25);
  CHECK(schema["pairs"]["default"] == 0);
  for (const char* key :
       {"name", "room", "beside", "angle_deg", "most", "length", "place", "unbound"}) {
    CAPTURE(key);
    CHECK(schema.contains(key));
    CHECK_FALSE(schema[key].contains("default"));
  }
}
