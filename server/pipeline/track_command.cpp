// `track`: camera poses of a recording, without the model.
#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "server/pipeline/commands.h"
#include "server/pipeline/options.h"
#include "server/pipeline/result_json.h"

namespace meshloop {
namespace {

struct TrackArguments {
  RecordingArguments recording;
  std::string out;
  bool json = false;
};

nlohmann::json pose_json(const TrackedFrame& tracked) {
  const auto& pose = tracked.color_pose;
  return {{"index", tracked.frame.index}, {"timestamp", tracked.frame.color_timestamp_s},
          {"state", name_of(pose.state)}, {"quality", pose.quality},
          {"inliers", pose.inliers},      {"time_ms", tracked.track_ms}};
}

struct TrackRun {
  Trajectory trajectory;
  nlohmann::json results = nlohmann::json::array();
  std::vector<double> times;
};

Status track_all(TrackedFrames& frames, TrackRun& run) {
  for (;;) {
    auto tracked = frames.next();
    if (!tracked) return fail(tracked.error());
    if (!*tracked) return {};
    const TrackedFrame& frame = **tracked;
    run.results.push_back(pose_json(frame));
    run.times.push_back(frame.track_ms);
    if (frame.color_pose.state == TrackState::lost) continue;
    run.trajectory.push_back({frame.frame.color_timestamp_s, frame.color_pose.T_camera_world.inverse()});
  }
}

/// `done`: how the run ended; the frames before an error are told too. `is_written`: the poses are in their file.
void report(const TrackArguments& arguments, const TrackRun& run, const Status& done, bool is_written) {
  const std::size_t lost = run.results.size() - run.trajectory.size();
  if (arguments.json) {
    nlohmann::json json{{"frames", run.results}, {"lost", lost}, {"time_ms", spread_json(run.times)}};
    if (!done) json["error"] = done.error().message;
    print_json(json);
    return;
  }
  std::cout << fmt::format("{} of {} frames tracked, {} lost\n", run.trajectory.size(), run.results.size(), lost);
  if (is_written) std::cout << "poses are in " << arguments.out << '\n';
}

Status track(const TrackArguments& arguments) {
  auto frames = arguments.recording.open();
  if (!frames) return fail(frames.error());
  TrackRun run;
  auto done = track_all(*frames, run);
  if (done && run.trajectory.empty()) done = fail(kEveryFrameIsLost);
  if (run.results.empty()) return done;
  // Good poses of an earlier run are worth more than none.
  bool is_written = false;
  if (!run.trajectory.empty()) {
    const auto written = write_trajectory(arguments.out, run.trajectory);
    is_written = written.has_value();
    if (done && !written) done = written;
  }
  report(arguments, run, done, is_written);
  return done;
}

}  // namespace

void add_track_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<TrackArguments>();
  CLI::App* command = app.add_subcommand("track", "camera poses of a recording, without the model");
  arguments->recording.add_to(*command, false);
  command->add_option("--out", arguments->out, "file for the poses (TUM format, camera to world)")->required();
  command->add_flag("--json", arguments->json, "per-frame state and time as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return track(*arguments); }; });
}

}  // namespace meshloop
