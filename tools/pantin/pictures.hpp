#pragma once
// Pictures of a run: frames, films and a filmstrip, in a build that can draw.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/report.hpp"

namespace pantin::program {

using namespace detail;

struct PictureChoices {
  std::string frames, video, gif, strip;  // paths; empty: none
  std::string size, gl = "auto";
  double fps = 0;  // 0: the scene's
  int strip_columns = 6, strip_rows = 2;
  std::string strip_times = "auto";  // or "run"
  std::string from;                  // the side that it is seen from; empty: the scene's camera
  bool overlay = false, states = false;
  std::vector<std::string> labels;  // instead of the time: at the start and after each step
  bool wanted() const { return captured() || !strip.empty(); }
  /// Whether more than a strip is made.
  bool captured() const { return !frames.empty() || !video.empty() || !gif.empty(); }
  /// Reports options that specify how pictures are made although none are; empty: no fault.
  std::string idle_option() const;
};

class Subcommand;
/// --frames, --video, --gif, --strip and what says how they look.
void add_picture_options(const Subcommand& command, PictureChoices& choices);
/// --from, --states.
void add_look_options(const Subcommand& command, PictureChoices& choices);
/// The words of --from, as in technical drawings.
std::vector<std::string> side_words();
/// From the scene towards the eye, unit; none for another word.
std::optional<Vec3> direction_of_side(std::string_view word);

/// Why pictures cannot be made or written, with the exit code.
struct PictureFailure {
  std::vector<Error> errors;
  int exit_code;
};

/// Draws the frames due after each step. Frame k shows the time k / fps, interpolated between two
/// steps.
class Pictures {
 public:
  /// Detects early all failures that can be. Frames are drawn from the present `scene`.
  static std::variant<std::unique_ptr<Pictures>, PictureFailure> open(const PictureChoices& choices,
                                                                      const Scene& scene,
                                                                      std::uint64_t steps);
  virtual ~Pictures() = default;
  /// Remembers the poses before a step.
  virtual void before_step(const World& world) = 0;
  /// Draws the due frames; `worst_gap` (m) goes into the label. Returns false once it has failed.
  virtual bool after_step(const World& world, double worst_gap) = 0;
  /// The period that the strip shows, s; 0 if it shows the whole run.
  virtual double strip_period() const = 0;
  /// Waits for the writers. Returns the number of frames written.
  virtual std::variant<std::size_t, PictureFailure> finish() = 0;
};

}  // namespace pantin::program
