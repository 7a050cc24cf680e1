#pragma once
// The live station: frames in, revisions out.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "server/pipeline/adjuster.h"
#include "server/pipeline/views.h"
#include "server/publish/publisher.h"

namespace meshloop {

struct StationOptions {
  std::filesystem::path scene;
  /// Name of the scene on the network.
  LinkOptions link;
  ExaminerOptions examiner;
  /// Accept every confirmed proposal when reason_to_wait has nothing against it; otherwise only show them.
  bool accept_all = false;
  AdjustOptions adjust;
  /// New surface is made of at most so many frames, of those since its region is there.
  int frames_fused = 8;
  /// For the journal: whose station it is, and the rig as calibrated (TrackedFrames::calibration as rig_text).
  std::string operator_name;
  std::string calibration;
  /// Folder for pictures of each revision and of each confirmed region; none when empty.
  std::filesystem::path out;
  /// How pictures look, and which are written.
  ViewArguments views;
  /// Seconds to go on serving the scene after the source has ended; negative: until a stop signal.
  double serve_s = 0;
  /// One JSON document a line on stdout for each event, instead of text.
  bool json = false;
};

/// Owns all stages but the source. One thread; a frame is compared on another one while this one tracks the next.
class Station {
 public:
  /// Opens the store (which must exist), starts the network and publishes the present model.
  [[nodiscard]] static Result<std::unique_ptr<Station>> create(const StationOptions& options, const Rig& rig);

  /// Until the source ends, a stop signal arrives, or an error that cannot be gone around.
  [[nodiscard]] Status run(TrackedFrames& frames);

 private:
  struct Parts;
  explicit Station(std::unique_ptr<Parts> parts);
  /// A frame that is being compared with the model.
  struct InFlight;
  void begin(TrackedFrame tracked);
  /// The rest of the frame in flight, if there is one: regions, pictures, a revision.
  [[nodiscard]] Status finish();
  [[nodiscard]] Status finish(const InFlight& frame, Examination examination);
  /// A revision that devices have and the disk may not.
  struct Change {
    Acceptance acceptance;
    PublishReport published;
    bool is_published = false;
    /// What it was made from, and its picture.
    Examination examination;
    ColorImage picture;
    nlohmann::json registration;
    std::size_t frames = 1;
    double snapshot_ms = 0;
  };
  /// Everything that a frame says: one revision or two, published, brought to the disk and told.
  [[nodiscard]] Status accept(const TrackedFrame& tracked, Examination examination);
  /// Commits and publishes what is proposed, if anything is.
  [[nodiscard]] Result<std::optional<Change>> change(const TrackedFrame& tracked, Examination examination);
  /// What stands where a surface was just removed: a box that moved back is there in the same snapshot.
  [[nodiscard]] Result<std::optional<Change>> change_behind(const TrackedFrame& tracked,
                                                            const Examination& examination);
  void tell_revision(const TrackedFrame& tracked, const Change& change, double sync_ms) const;
  [[nodiscard]] Status publish(const std::shared_ptr<const Model>& model, std::int64_t accepted_ns);
  /// What cannot be sent now (a reader does not keep up) is sent again with the next frame, or while serving.
  void publish_or_retry(std::int64_t accepted_ns);
  [[nodiscard]] nlohmann::json confirmed_json(const TrackedFrame& tracked, const Examination& examination);
  /// Over colour; empty, with a warning, when it cannot be drawn: a picture stops nothing.
  [[nodiscard]] ColorImage draw_color(const TrackedFrame& tracked, const Examination& examination,
                                      const std::string& title);
  void write_pictures(const char* when, Revision revision, const TrackedFrame& tracked, const Examination& examination,
                      const ColorImage* color);
  void serve();
  void tell(nlohmann::json event) const;

 public:
  ~Station();

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace meshloop
