// `track`: model-based tracking of a recording.
#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "common/program/json_output.h"
#include "common/program/model_arguments.h"
#include "device/capture/recording_source.h"
#include "device/draw/presenter.h"
#include "device/pipeline/commands.h"
#include "device/pipeline/object_arguments.h"
#include "device/pipeline/tracking_session.h"

namespace meshloop {
namespace {

struct TrackArguments {
  ModelArguments model;
  std::string recording;
  std::string init;
  std::string out;
  std::string draw;
  int every = 1;
  ObjectArguments object;
  bool json = false;
};

/// Draws the augmented view of each tracked frame into a folder.
class Views {
 public:
  static Result<Views> create(GpuContext& gpu, const TrackArguments& arguments, VirtualObject object) {
    auto renderer = ArRenderer::create(gpu);
    if (!renderer) return fail(renderer.error());
    auto presenter = OffscreenPresenter::create({.folder = arguments.draw, .every_nth = arguments.every});
    if (!presenter) return fail(presenter.error());
    return Views{std::move(*renderer), std::move(*presenter), std::move(object)};
  }

  Status draw(const ColorFrame& frame, const Camera& camera, const TrackRecord& record, const Model& model) {
    if (!presenter_->keeps_next()) {
      presenter_->skip();
      return {};
    }
    ArFrame view;
    view.camera_image = &frame.color;
    view.camera = camera;
    view.T_camera_world = record.pose.T_camera_world;
    view.tracked = record.pose.state != TrackState::lost;
    view.model = &model;
    view.objects = &objects_;
    view.hud = {0, std::string(name_of(record.pose.state)), 0};
    return presenter_->show(renderer_->draw(view));
  }

 private:
  Views(std::unique_ptr<ArRenderer> renderer, std::unique_ptr<OffscreenPresenter> presenter, VirtualObject object)
      : renderer_{std::move(renderer)}, presenter_{std::move(presenter)}, objects_{std::move(object)} {}
  std::unique_ptr<ArRenderer> renderer_;
  std::unique_ptr<OffscreenPresenter> presenter_;
  std::vector<VirtualObject> objects_;
};

/// `done`: how the run ended; the frames before an error are told too. `is_written`: the poses are in their file.
void report(const TrackArguments& arguments, const TrackingSession& session, const nlohmann::json& truth,
            const ImportedModel& model, const Status& done, bool is_written) {
  std::vector<double> times;
  for (const auto& record : session.records()) times.push_back(record.time_ms);
  nlohmann::json json{{"frames", session.frames_json()},
                      {"lost", session.lost_frames()},
                      {"time_ms", spread_json(times)},
                      {"truth", truth},
                      {"model", import_json(model)}};
  if (!done) json["error"] = done.error().message;
  if (arguments.json) {
    print_json(json);
    return;
  }
  std::cout << import_text(arguments.model.file, model) << '\n';
  std::cout << fmt::format("{} frames, {} lost\n", session.records().size(), session.lost_frames());
  if (is_written) std::cout << "poses are in " << arguments.out << '\n';
  if (!truth.is_null()) {
    std::cout << fmt::format("mean error {:.1f} mm, largest {:.1f} mm\n", 1000 * truth["mean_error_m"].get<double>(),
                             1000 * truth["max_error_m"].get<double>());
  }
}

Status track_all(ColorSource& source, TrackingSession& session, const std::shared_ptr<const Model>& model,
                 std::optional<Views>& views) {
  for (;;) {
    const auto frame = source.next();
    if (!frame) return fail(frame.error());
    if (!*frame) return {};
    const TrackRecord& record = session.track(**frame, model);
    if (!views) continue;
    if (auto done = views->draw(**frame, source.camera(), record, *model); !done) return done;
  }
}

Status track(const TrackArguments& arguments) {
  auto start = StartPose::parse(arguments.init);
  if (!start) return fail(start.error());
  const auto object = arguments.object.make();
  if (!object) return fail(object.error());
  auto imported = arguments.model.import();
  if (!imported) return fail(imported.error());
  const auto model = std::make_shared<const Model>(imported->model);
  auto source = ColorRecordingSource::open(arguments.recording);
  if (!source) return fail(source.error());
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto session = TrackingSession::create(**gpu, (*source)->camera(), std::move(*start));
  if (!session) return fail(session.error());
  std::optional<Views> views;
  if (!arguments.draw.empty()) {
    auto made = Views::create(**gpu, arguments, *object);
    if (!made) return fail(made.error());
    views = std::move(*made);
  }
  auto done = track_all(**source, *session, model, views);
  if (session->records().empty()) return done;
  const Trajectory trajectory = session->trajectory();
  if (done && trajectory.empty()) done = fail("every frame is lost; do --init and the model fit the recording?");
  // Good poses of an earlier run are worth more than none.
  bool is_written = false;
  if (!trajectory.empty()) {
    const auto written = write_trajectory(arguments.out, trajectory);
    is_written = written.has_value();
    if (done && !written) done = written;
  }
  report(arguments, *session, truth_json(trajectory, (*source)->recording().ground_truth()), *imported, done,
         is_written);
  return done;
}

}  // namespace

void add_track_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<TrackArguments>();
  CLI::App* command = app.add_subcommand("track", "track a recording against a model, in batch");
  arguments->model.add_to(*command, "--model");
  command->add_option("--recording", arguments->recording, "folder with rgb.txt and rig.yaml")->required();
  command->add_option("--init", arguments->init, kInitHelp)->required();
  command->add_option("--out", arguments->out, "file for the poses (TUM format, camera to world)")->required();
  command->add_option("--draw", arguments->draw, "folder for the augmented views, as PNG");
  command->add_option("--every", arguments->every, "draw every n-th view only")->check(CLI::Range(1, 1'000'000));
  arguments->object.add_to(*command);
  command->add_flag("--json", arguments->json, "per-frame state, quality and time as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return track(*arguments); }; });
}

}  // namespace meshloop
