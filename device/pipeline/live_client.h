#pragma once
// The live client: camera and shared scene in, augmented view out.
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/base/clock.h"
#include "device/capture/color_source.h"
#include "device/draw/ar_renderer.h"
#include "device/draw/presenter.h"
#include "device/pipeline/tracking_session.h"
#include "device/receive/scene_receiver.h"

namespace meshloop {

struct LiveOptions {
  LinkOptions link;
  std::vector<VirtualObject> objects;
  /// One JSON document a line on stdout when a revision is drawn for the first time.
  bool json = false;
};

/// What happened to one revision on its way to the screen. Wall clock, nanoseconds since 1970.
struct RevisionTimes {
  std::int64_t accepted_ns = 0;
  std::int64_t complete_ns = 0;
  std::int64_t drawn_ns = 0;
  double decode_ms = 0;
  /// The handheld did not know where it is when the revision was there; nothing can be drawn then.
  bool waited_for_pose = false;
};

/// What to tell somebody who waits for a scene in vain.
[[nodiscard]] std::string no_scene_yet(const LinkOptions& link);

/// One thread, that of the GPU context it makes; receiving and decoding have their own.
class LiveClient {
 public:
  [[nodiscard]] static Result<std::unique_ptr<LiveClient>> create(const LiveOptions& options, const Camera& camera,
                                                                  StartPose start,
                                                                  std::unique_ptr<Presenter> presenter);
  /// Until the camera ends, `seconds` are over (when positive) or a stop signal arrives.
  [[nodiscard]] Status run(ColorSource& camera, double seconds);

  /// {"frames", "lost", "revision", "revisions", "rejected", "time_ms": {"track", "draw"}, "truth"}
  [[nodiscard]] nlohmann::json report(const std::optional<Trajectory>& truth) const;
  [[nodiscard]] const TrackingSession& session() const { return session_; }
  [[nodiscard]] bool has_scene() const { return receiver_->newest() != nullptr; }

 private:
  LiveClient(std::unique_ptr<GpuContext> gpu, TrackingSession session, std::unique_ptr<ArRenderer> renderer,
             std::unique_ptr<SceneReceiver> receiver, std::unique_ptr<Presenter> presenter, const LiveOptions& options,
             const Camera& camera);
  /// Before the first frame: what is compiled or set up at the first use must not delay it.
  void warm_up();
  [[nodiscard]] Status show(const ColorFrame& frame);
  [[nodiscard]] Status draw(const ColorFrame& frame, const TrackRecord& record,
                            const std::shared_ptr<const ReceivedModel>& received);
  void note_arrival(const ReceivedModel& received, bool tracked);
  void tell_who_waits();

  std::unique_ptr<GpuContext> gpu_;
  TrackingSession session_;
  std::unique_ptr<ArRenderer> renderer_;
  std::unique_ptr<SceneReceiver> receiver_;
  std::unique_ptr<Presenter> presenter_;
  Camera camera_;
  LiveOptions options_;
  /// By the station's start and the revision: after a loss of power a number may come again.
  std::map<std::pair<std::uint64_t, Revision>, RevisionTimes> revisions_;
  std::deque<double> draw_ms_;
  Stopwatch waiting_;
  bool told_ = false;
  bool was_lost_ = false;
  double frames_per_s_ = 0;
};

}  // namespace meshloop
