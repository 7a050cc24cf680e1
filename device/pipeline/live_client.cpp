#include "device/pipeline/live_client.h"

#include <fmt/format.h>

#include <iostream>
#include <utility>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/image/jpeg_codec.h"
#include "common/program/json_output.h"
#include "common/program/stop_signal.h"

namespace meshloop {
namespace {

/// Side by side, a metre before the camera: a triangle without colours, one with colours, one with a texture.
Model one_of_each_kind() {
  Submesh plain;
  plain.positions = {{0, -1, 1}, {1, -1, 1}, {0, 1, 1}};
  plain.triangles = {{0, 1, 2}};
  Submesh colored;
  colored.positions = {{-1, -1, 1}, {0, -1, 1}, {0, 1, 1}};
  colored.triangles = plain.triangles;
  colored.colors.resize(3);
  Submesh textured = plain;
  TextureProjection one_pixel = TextureProjection::Zero();
  one_pixel(2, 2) = 1;
  if (auto jpeg = encode_jpeg(ColorImage{1, 1}, 90)) {
    textured.texture = make_projected_texture(std::move(*jpeg), one_pixel).value_or(nullptr);
  }
  Model model;
  model.nodes = {make_node(1, "plain", std::move(plain)), make_node(2, "colored", std::move(colored)),
                 make_node(3, "textured", std::move(textured))};
  return model;
}

/// The objects where a camera in the origin sees them.
std::vector<VirtualObject> in_view(std::vector<VirtualObject> objects) {
  constexpr double kDistance = 3;
  for (auto& object : objects) {
    const auto bounds = object.submesh->bounds();
    const double size = bounds.diagonal().norm();
    const Eigen::Vector3d centre = bounds.center().cast<double>();
    object.T_world_object = Pose{Eigen::Translation3d{Eigen::Vector3d{0, 0, kDistance * size} - centre}};
  }
  return objects;
}

}  // namespace

LiveClient::LiveClient(std::unique_ptr<GpuContext> gpu, TrackingSession session, std::unique_ptr<ArRenderer> renderer,
                       std::unique_ptr<SceneReceiver> receiver, std::unique_ptr<Presenter> presenter,
                       const LiveOptions& options, const Camera& camera)
    : gpu_{std::move(gpu)},
      session_{std::move(session)},
      renderer_{std::move(renderer)},
      receiver_{std::move(receiver)},
      presenter_{std::move(presenter)},
      camera_{camera},
      options_{options} {}

Result<std::unique_ptr<LiveClient>> LiveClient::create(const LiveOptions& options, const Camera& camera,
                                                       StartPose start, std::unique_ptr<Presenter> presenter) {
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto session = TrackingSession::create(**gpu, camera, std::move(start));
  if (!session) return fail(session.error());
  auto renderer = ArRenderer::create(**gpu);
  if (!renderer) return fail(renderer.error());
  auto receiver = SceneReceiver::start(options.link);
  if (!receiver) return fail(receiver.error());
  std::unique_ptr<LiveClient> client{new LiveClient{std::move(*gpu), std::move(*session), std::move(*renderer),
                                                    std::move(*receiver), std::move(presenter), options, camera}};
  client->warm_up();
  return client;
}

void LiveClient::warm_up() {
  const Model model = one_of_each_kind();
  session_.warm_up(model);
  const ColorImage black{camera_.width, camera_.height};
  const auto objects = in_view(options_.objects);
  ArFrame view;
  view.camera_image = &black;
  view.camera = camera_;
  view.tracked = true;
  view.model = &model;
  view.objects = &objects;
  (void)renderer_->draw(view);
}

std::string no_scene_yet(const LinkOptions& link) {
  return fmt::format("no scene '{}' has come over DDS domain {}; does a station serve it under this name there?",
                     link.scene, link.domain);
}

void LiveClient::tell_who_waits() {
  constexpr double kPatience_ms = 5000;
  if (told_ || waiting_.milliseconds() < kPatience_ms) return;
  told_ = true;
  log_warning("{} Waiting for it", no_scene_yet(options_.link));
}

void LiveClient::note_arrival(const ReceivedModel& received, bool tracked) {
  const bool was_lost = std::exchange(was_lost_, !tracked);
  const Revision revision = received.model->revision;
  RevisionTimes& times = revisions_[{received.epoch, revision}];
  if (times.drawn_ns != 0) return;
  times.accepted_ns = received.accepted_ns;
  times.complete_ns = received.complete_ns;
  times.decode_ms = received.decode_ms;
  times.waited_for_pose = times.waited_for_pose || was_lost || !tracked;
  if (!tracked) return;
  times.drawn_ns = wall_clock_ns();
  if (options_.json) {
    std::cout << json_line({{"event", "drawn"}, {"revision", revision}}) << std::endl;
  }
}

Status LiveClient::show(const ColorFrame& frame) {
  const auto known = receiver_->newest();
  const TrackRecord& record = session_.track(frame, known ? known->model : nullptr);
  // What came while the pose was being found hides and is shaded already: the pose does not depend on a small change.
  const auto received = known ? receiver_->newest() : known;
  if (auto shown = draw(frame, record, received); !shown) return shown;
  // What came while that was drawn does not wait for the next pose either.
  const auto newer = receiver_->newest();
  if (!received || !newer || newer->model == received->model || record.pose.state == TrackState::lost) return {};
  return draw(frame, record, newer);
}

Status LiveClient::draw(const ColorFrame& frame, const TrackRecord& record,
                        const std::shared_ptr<const ReceivedModel>& received) {
  const Stopwatch watch;
  const std::shared_ptr<const Model> model = received ? received->model : nullptr;
  ArFrame view;
  view.camera_image = &frame.color;
  view.camera = camera_;
  view.T_camera_world = record.pose.T_camera_world;
  view.tracked = record.pose.state != TrackState::lost;
  view.model = model.get();
  view.objects = &options_.objects;
  view.hud = {model ? model->revision : Revision{0},
              model ? std::string(name_of(record.pose.state)) : "waiting for the scene", frames_per_s_};
  const ColorImage picture = renderer_->draw(view);
  draw_ms_.push_back(watch.milliseconds());
  if (draw_ms_.size() > session_.records().size()) draw_ms_.pop_front();
  if (received) note_arrival(*received, view.tracked);
  if (!received) tell_who_waits();
  return presenter_->show(picture);
}

Status LiveClient::run(ColorSource& camera, double seconds) {
  const Stopwatch running;
  while (!stop_requested() && (seconds <= 0 || running.milliseconds() < 1000 * seconds)) {
    const Stopwatch watch;
    const auto frame = camera.next();
    if (!frame) {
      log_warning("{}; going on with the next picture", frame.error().message);
      continue;
    }
    if (!*frame) return {};
    if (auto done = show(**frame); !done) return done;
    constexpr double kSmoothing = 0.1;
    frames_per_s_ += kSmoothing * (1000 / watch.milliseconds() - frames_per_s_);
  }
  return {};
}

nlohmann::json LiveClient::report(const std::optional<Trajectory>& truth) const {
  nlohmann::json revisions = nlohmann::json::array();
  for (const auto& [key, times] : revisions_) {
    if (times.drawn_ns == 0) continue;
    revisions.push_back({{"revision", key.second},
                         {"accepted_ns", times.accepted_ns},
                         {"complete_ns", times.complete_ns},
                         {"drawn_ns", times.drawn_ns},
                         {"decode_ms", times.decode_ms},
                         {"waited_for_pose", times.waited_for_pose}});
  }
  std::vector<double> track_ms;
  for (const auto& record : session_.records()) track_ms.push_back(record.time_ms);
  const auto newest = receiver_->newest();
  const auto counts = receiver_->counts();
  return {{"frames", session_.frames_json()},
          {"lost", session_.lost_frames()},
          {"revision", newest ? nlohmann::json(newest->model->revision) : nlohmann::json(nullptr)},
          {"revisions", revisions},
          {"rejected", counts.rejected},
          {"time_ms", {{"track", spread_json(track_ms)}, {"draw", spread_json({draw_ms_.begin(), draw_ms_.end()})}}},
          {"truth", truth_json(session_.trajectory(), truth)}};
}

}  // namespace meshloop
