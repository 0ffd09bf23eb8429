// Options of the commands that make pictures.
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/pictures.hpp"

namespace pantin::program {

namespace {

struct Side {
  const char* word;
  Vec3 way;  // towards the eye
};

constexpr Real kCorner = 0.57735026918962576;  // 1 / sqrt(3)
constexpr Side kSides[] = {{"front", {0, 0, 1}},
                           {"back", {0, 0, -1}},
                           {"left", {-1, 0, 0}},
                           {"right", {1, 0, 0}},
                           {"top", {0, 1, 0}},
                           {"bottom", {0, -1, 0}},
                           {"corner", {kCorner, kCorner, kCorner}}};

}  // namespace

std::vector<std::string> side_words() {
  std::vector<std::string> words;
  for (const Side& side : kSides) words.emplace_back(side.word);
  return words;
}

std::optional<Vec3> direction_of_side(std::string_view word) {
  for (const Side& side : kSides)
    if (word == side.word) return side.way;
  return std::nullopt;
}

void add_look_options(const Subcommand& command, PictureChoices& c) {
  command
      .option("--from", c.from,
              "the side from which the whole scene is seen: front (along -z), back, left, right, "
              "top, bottom or corner; by default as the scene's camera")
      .one_of(side_words());
  command.flag("--states", c.states,
               "colour bodies by state: moving, asleep, kinematic or fixed, with a legend");
}

void add_picture_options(const Subcommand& command, PictureChoices& c) {
  command.option("--frames", c.frames, "folder for frame_000000.png and so on").type(kFolderType);
  command.option("--video", c.video, "video file, .mp4 or .mkv (needs ffmpeg)")
      .ends_in({".mp4", ".mkv"})
      .type(kFileType);
  command
      .option("--gif", c.gif,
              "animated .gif (needs ffmpeg); without --size at most 640 pixels wide, without --fps "
              "at most 25 frames per second")
      .ends_in({".gif"})
      .type(kFileType);
  command
      .option(
          "--strip", c.strip,
          "one PNG with frames of the run side by side; without --size 1600 pixels wide at most")
      .type(kFileType);
  command.option("--strip-columns", c.strip_columns, "pictures in a row of the strip")
      .within(1, 20);
  command.option("--strip-rows", c.strip_rows, "rows of the strip").within(1, 20);
  command
      .option("--strip-times", c.strip_times,
              "auto: spread over the last period of a motion that repeats, else over the run; run: "
              "always over the run")
      .one_of({"auto", "run"});
  command.option("--size", c.size, "in pixels; by default the scene's").type("WIDTHxHEIGHT");
  command.option("--fps", c.fps, "frames per second; by default the scene's").between(0.1, 1000.0);
  command.option("--gl", c.gl, "OpenGL context: auto, surfaceless, device or osmesa")
      .one_of({"auto", "surfaceless", "device", "osmesa"});
  command.flag("--overlay", c.overlay, "draw joints, axes and pins");
  add_look_options(command, c);
}

}  // namespace pantin::program
