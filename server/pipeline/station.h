#pragma once
// The live station: frames in, revisions out.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/pipeline/acceptance_rule.h"
#include "server/pipeline/adjuster.h"
#include "server/pipeline/operator_commands.h"
#include "server/pipeline/views.h"
#include "server/publish/publisher.h"

namespace meshloop {

struct StationOptions {
  std::filesystem::path scene;
  /// Name of the scene on the network.
  LinkOptions link;
  ExaminerOptions examiner;
  /// Which confirmed proposals are accepted when reason_to_wait has nothing against the frame.
  AcceptanceRule accept;
  /// Take commands (operator_commands.h) from standard input, and show what is proposed.
  bool commands = false;
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

  /// Until the source ends, a stop signal arrives, or an error that cannot be gone around. Fails, too, when nothing was
  /// changed and each frame that could have changed something was withheld.
  [[nodiscard]] Status run(TrackedFrames& frames);

 private:
  struct Parts;
  explicit Station(std::unique_ptr<Parts> parts);
  /// A frame that is being compared with the model.
  struct InFlight;
  /// What a frame proposes, and what that was made from.
  struct Offer;
  struct Fusable;
  struct Looked;
  /// Why a command was not done.
  using Refusal = std::optional<std::string>;
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
    const Offer* offer = nullptr;
    ColorImage picture;
  };
  /// Whether a look at a frame counts for the frames that come: a second one at the same frame does not.
  enum class Turn { first, again };
  /// What a frame proposes, remembered; or why it may propose nothing, which is told.
  [[nodiscard]] Result<Offer> look(TrackedFrame tracked, Examination examination, Fusable fusable, Turn turn);
  [[nodiscard]] Fusable fusable_with(const TrackedFrame& tracked, const RegionMap& regions) const;
  /// Counts the frames that must pass the gates before the model is changed again, and those that were withheld.
  /// `speaks_for_poses`: not of a frame that is compared anew, and not where nothing is proposed.
  [[nodiscard]] std::optional<std::string> count_withheld(int frame, const std::optional<PoseObjection>& objection,
                                                          bool speaks_for_poses);
  void tell_withheld(const TrackedFrame& tracked, const std::string& reason, const Registration& registration,
                     const EdgeRings& rings) const;
  /// Where nothing is proposed to anybody: tells once a second whether the pose is wrong.
  void watch_pose(const TrackedFrame& tracked, const Examination& examination);
  /// One revision, published, brought to the disk and told.
  [[nodiscard]] Status accept(const Offer& offer, const std::vector<Offered>& accepted, const std::string& author);
  /// The same, with a second revision of what stands behind, if the rule accepts that. What is left out is told then.
  [[nodiscard]] Status accept_by_rule(Offer offer, const std::vector<Offered>& accepted);
  /// Once it is on the disk: ids that were told are never given again.
  [[nodiscard]] Status tell_left_out(Offer offer, std::optional<Offer> behind);
  /// Commits and publishes what is accepted, which is not nothing. The offer must outlive what it gives.
  [[nodiscard]] Result<Change> change(const Offer& offer, const std::vector<Offered>& accepted,
                                      const std::string& author);
  /// What stands where a surface was just removed: a box that moved back is there in the same snapshot.
  [[nodiscard]] Result<std::optional<Change>> change_behind(const Offer& offer, const std::string& author,
                                                            std::optional<Offer>& behind);
  [[nodiscard]] Status conclude(const std::vector<Change>& changes);
  // station_operator.cpp
  /// A frame with confirmed regions that may change the model: accepts by the rule, or shows what it proposes.
  [[nodiscard]] Status consider(const TrackedFrame& tracked, Examination examination);
  [[nodiscard]] std::vector<Offered> chosen_by_rule(const Offer& offer) const;
  /// False when the same regions were looked at a moment ago, and nothing became of it.
  [[nodiscard]] bool is_worth_a_look(const RegionMap& regions, double timestamp_s) const;
  void tell_proposals(const Offer& offer) const;
  /// The frame that was offered last, against the present model.
  [[nodiscard]] Status offer_again();
  /// Commands that have come. One that cannot be done is told, and no error.
  [[nodiscard]] Status obey_all();
  [[nodiscard]] Result<Refusal> obey(OperatorCommand command);
  [[nodiscard]] Result<Refusal> accept_as_told(const OperatorCommand& command);
  [[nodiscard]] Result<Refusal> reject_as_told(OperatorCommand command);
  [[nodiscard]] Result<Refusal> go_back_or_forth(bool back);
  void tell_revision(const Change& change, double sync_ms) const;
  [[nodiscard]] Status publish(const std::shared_ptr<const Model>& model, std::int64_t accepted_ns);
  /// What cannot be sent now (a reader does not keep up) is sent again with the next frame, or while serving.
  void publish_or_retry(std::int64_t accepted_ns);
  [[nodiscard]] nlohmann::json confirmed_json(const TrackedFrame& tracked, const Examination& examination);
  /// Over colour; empty, with a warning, when it cannot be drawn: a picture stops nothing.
  [[nodiscard]] ColorImage draw_color(const TrackedFrame& tracked, const Examination& examination,
                                      const std::string& title, const Framing* framing);
  void write_pictures(const char* when, Revision revision, const TrackedFrame& tracked, const Examination& examination,
                      const ColorImage* color);
  [[nodiscard]] Status serve();
  void tell_end() const;
  /// Why the run changed nothing, if its poses are to blame.
  [[nodiscard]] Status check_any_used() const;
  void tell(nlohmann::json event) const;

 public:
  ~Station();

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace meshloop
